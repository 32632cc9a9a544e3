// contact/adhesion/friction_laws.hpp - the friction laws a configuration can name: friction over slip velocity.
//
// To add a law: a struct with its name, its fields and `T operator()(T const& slip) const`, and its line in FrictionLaw.
//
// Source  Polach, Creep forces in simulations of traction vehicles running on adhesion limit, Wear 258 (2005): (A1).
#pragma once
#include <cmath>

#include "rollerrig/fields.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// Coulomb's.
struct ConstantFriction {
  static constexpr char const* name = "constant";
  double mu_0{0.3};
  static constexpr auto fields() {
    return members(Member{"mu_0", &ConstantFriction::mu_0, "1", "friction coefficient", not_negative});
  }

  template <Scalar T>
  T operator()(T const& /*slip*/) const {
    return T(mu_0);
  }
};

/// Polach's, that falls with slip velocity w: mu(w) = mu_0 [(1 - A) exp(-B w) + A]   (A1)
struct FallingFriction {
  static constexpr char const* name = "falling";
  double mu_0{0.3}, A{1.0}, B{0.0};
  static constexpr auto fields() {
    return members(Member{"mu_0", &FallingFriction::mu_0, "1", "friction coefficient at no slip", not_negative},
                   Member{"A", &FallingFriction::A, "1", "friction at large slip over mu_0"},
                   Member{"B", &FallingFriction::B, "s/m", "rate at which friction falls with slip velocity"});
  }

  /// @param slip  slip velocity, not negative [m/s]
  template <Scalar T>
  T operator()(T const& slip) const {
    using std::exp;
    return mu_0 * ((1.0 - A) * exp(-B * slip) + A);
  }
};

using FrictionLaw = OneOf<ConstantFriction, FallingFriction>;

/// Friction coefficient at a slip velocity [m/s].
template <Scalar T>
T friction_at(FrictionLaw const& law, T const& slip) {
  return std::visit([&](auto const& chosen) { return chosen(slip); }, law);
}

}  // namespace rollerrig
