// multibody/force_laws.hpp - the force laws a configuration can name, and those that act in one direction.
//
//   deflection, rate, inner nodes -> [preload and laws, in parallel] -> force on b, dissipated power, rates of the nodes
//
// To add a law: a struct here, with its name (the key in a configuration), its fields and
// `void operator()(DirectionState<T> const&, DirectionForce<T>&) const`, and its line in ForceLaw: docs/how_to/force_element.md.
#pragma once
#include <optional>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/curves.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// State of one direction of an element, as a law sees it.
template <Scalar T>
struct DirectionState {
  T const& d;     ///< deflection [m or rad]
  T const& rate;  ///< [m/s or rad/s]
  T const& s;     ///< of the law's inner node, where it has one
};

/// What acts in one direction of an element; every law adds its share.
template <Scalar T>
struct DirectionForce {
  T force;       ///< on b along +axis [N or N m]
  T dissipated;  ///< power turned into heat [W]
};

/// A law's inner node s: c s_dot is a force that moves s towards its place with about the stiffness k.
struct InnerNode {
  double damping;    ///< c [N s/m]
  double stiffness;  ///< k [N/m]

  double relaxation_rate() const { return stiffness / damping; }  ///< [1/s]
};

/// Force over deflection: a constant stiffness, or a table.
struct LinearSpring {
  static constexpr char const* name = "stiffness";
  double stiffness{0.0};
  static constexpr auto fields() {
    return members(Member{"stiffness", &LinearSpring::stiffness, "N/m or N m/rad", "stiffness"});
  }

  template <Scalar T>
  void operator()(DirectionState<T> const& at, DirectionForce<T>& on_b) const {
    on_b.force -= stiffness * at.d;
  }
  double potential(double d, double /*s*/) const { return 0.5 * stiffness * d * d; }
};

/// A nonlinear spring or a bumpstop.
struct TabulatedSpring {
  static constexpr char const* name = "table";
  PiecewiseLinear table{};
  static constexpr auto fields() {
    return members(Member{"table", &TabulatedSpring::table, "N or N m", "force over deflection"});
  }

  template <Scalar T>
  void operator()(DirectionState<T> const& at, DirectionForce<T>& on_b) const {
    on_b.force -= table.at(at.d);
  }
  double potential(double d, double /*s*/) const { return table.integral(d); }
};

/// Force over rate: a constant damping, or a table.
struct LinearDamper {
  static constexpr char const* name = "damping";
  double damping{0.0};
  static constexpr auto fields() {
    return members(Member{"damping", &LinearDamper::damping, "N s/m or N m s/rad", "damping"});
  }

  template <Scalar T>
  void operator()(DirectionState<T> const& at, DirectionForce<T>& on_b) const {
    T const viscous = damping * at.rate;
    on_b.force -= viscous;
    on_b.dissipated += viscous * at.rate;
  }
};

struct TabulatedDamper {
  static constexpr char const* name = "damping_table";
  PiecewiseLinear damping_table{};
  static constexpr auto fields() {
    return members(Member{"damping_table", &TabulatedDamper::damping_table, "N or N m", "force over rate"});
  }

  template <Scalar T>
  void operator()(DirectionState<T> const& at, DirectionForce<T>& on_b) const {
    T const viscous = damping_table.at(at.rate);
    on_b.force -= viscous;
    on_b.dissipated += viscous * at.rate;
  }
};

/// A damper in series with a spring (Maxwell).
///
/// Between them is the inner node s: the force is k_s (d - s), and c s_dot equals it.
struct SeriesDamper {
  static constexpr char const* name = "damper";
  double damping{0.0}, series_stiffness{0.0};
  static constexpr auto fields() {
    return members(Member{"damping", &SeriesDamper::damping, "N s/m or N m s/rad", "damping, c"},
                   Member{"series_stiffness", &SeriesDamper::series_stiffness, "N/m or N m/rad",
                          "stiffness of the series spring, k_s"});
  }

  InnerNode node() const { return {damping, series_stiffness}; }

  template <Scalar T>
  void operator()(DirectionState<T> const& at, DirectionForce<T>& on_b, T& node_rate) const {
    T const branch = series_stiffness * (at.d - at.s);
    node_rate = branch / damping;
    on_b.force -= branch;
    on_b.dissipated += branch * node_rate;
  }
  double potential(double d, double s) const { return 0.5 * series_stiffness * (d - s) * (d - s); }
};

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
