#include "rollerrig/multibody/force_laws/direction_law.hpp"

namespace rollerrig {
namespace {

/// At a deflection [m or rad], with the inner node at s [J].
double potential(ForceLaw const& law, double d, double s) {
  return std::visit(
      [&](auto const& chosen) {
        if constexpr (requires { chosen.potential(d, s); })
          return chosen.potential(d, s);
        else
          return 0.0;
      },
      law);
}

}  // namespace

std::optional<InnerNode> inner_node(ForceLaw const& law) {
  return std::visit(
      []<class Law>(Law const& chosen) -> std::optional<InnerNode> {
        if constexpr (HasNode<Law>) return chosen.node();
        return std::nullopt;
      },
      law);
}

double potential(DirectionLaw const& direction, double d, double const* node) {
  double sum = -direction.preload * d;
  for (ForceLaw const& law : direction.laws) sum += potential(law, d, inner_node(law) ? *node++ : 0.0);
  return sum;
}

}  // namespace rollerrig
