// multibody/force_laws/direction_law.hpp - the force laws a configuration can name, and those that act in one direction.
//
//   deflection, rate, inner nodes -> [preload and laws, in parallel] -> force on b, dissipated power, rates of the nodes
//
// To add a law: a struct in a header of its own, with its name (the key in a configuration), its fields and
// `void operator()(DirectionState<T> const&, DirectionForce<T>&) const`, and its line below: docs/how_to/force_element.md.
#pragma once
#include <optional>
#include <vector>

#include "rollerrig/multibody/force_laws/dampers.hpp"
#include "rollerrig/multibody/force_laws/series_damper.hpp"
#include "rollerrig/multibody/force_laws/springs.hpp"

namespace rollerrig {

using ForceLaw = OneOf<LinearSpring,     //
                       TabulatedSpring,  //
                       LinearDamper,     //
                       TabulatedDamper,  //
                       SeriesDamper>;

/// A law with an inner node: it says how that relaxes, and gives its rate.
template <class Law>
concept HasNode = requires(Law const& law) {
  { law.node() } -> std::same_as<InnerNode>;
};

/// How a law's inner node relaxes; none where it has no node.
template <class... Laws>
std::optional<InnerNode> inner_node(std::variant<Laws...> const& law) {
  return std::visit(
      []<class Law>(Law const& chosen) -> std::optional<InnerNode> {
        if constexpr (HasNode<Law>) return chosen.node();
        return std::nullopt;
      },
      law);
}

/// Energy stored at a deflection [m or rad], with the inner node at s [J]; a law without `potential` stores none.
template <class... Laws>
double potential(std::variant<Laws...> const& law, double d, double s) {
  return std::visit(
      [&](auto const& chosen) {
        if constexpr (requires { chosen.potential(d, s); })
          return chosen.potential(d, s);
        else
          return 0.0;
      },
      law);
}

/// Beyond it a vehicle is thrown wheels deep into the rail, where a step takes milliseconds.
inline constexpr Range preload_range{0.0, 1e8, "at most 1e8", false, false, true};

/// Force over deflection and rate in one direction.
struct DirectionLaw {
  double preload{0.0};
  std::vector<ForceLaw> laws{};  ///< in parallel

  static constexpr auto fields() {
    using P = DirectionLaw;
    return members(
        Member{"preload", &P::preload, "N or N m", "force on b along +axis at zero deflection", preload_range},
        Member{"laws", &P::laws});
  }

  bool active() const { return preload != 0.0 || !laws.empty(); }
};

/// @param node, node_rate  inner nodes of the laws, in their order: where they are, and their rates, which are written
template <Scalar T>
DirectionForce<T> direction_force(DirectionLaw const& direction, T const& d, T const& rate, T const* node,
                                  T* node_rate) {
  DirectionForce<T> on_b{T(direction.preload), T(0.0)};
  for (ForceLaw const& law : direction.laws)
    std::visit(
        [&]<class Law>(Law const& chosen) {
          if constexpr (HasNode<Law>)
            chosen(DirectionState<T>{d, rate, *node++}, on_b, *node_rate++);
          else
            chosen(DirectionState<T>{d, rate, d}, on_b);
        },
        law);
  return on_b;
}

/// Energy stored in one direction [J]; `node` as in direction_force.
template <std::same_as<double> T>
T potential(DirectionLaw const& direction, T d, T const* node) {
  double sum = -direction.preload * d;
  for (ForceLaw const& law : direction.laws) sum += potential(law, d, inner_node(law) ? *node++ : 0.0);
  return sum;
}

}  // namespace rollerrig
