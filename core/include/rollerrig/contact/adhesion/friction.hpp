// contact/adhesion/friction.hpp - the friction of one contact, and what its surface leaves of the creep curve's stiffness.
#pragma once
#include <memory>

#include "rollerrig/contact/adhesion/adhesion_map.hpp"

namespace rollerrig {

/// One law for the whole run, or what a map says of arc length, time, slip and dissipated energy.
struct Friction {
  FrictionLaw law{};
  std::shared_ptr<AdhesionMap const> map{};  ///< in place of the law
  static constexpr auto fields() {
    return std::tuple{Member{"law", &Friction::law}, OptionalMember{"map", &Friction::map}};
  }

  /// @param arc_length      along the rail [m]
  /// @param slip            slip velocity [m/s]
  /// @param energy_density  dissipated on this piece of rail, by the wheels ahead and by this one [J/m^2]
  /// @param sand            mass per length on it [kg/m]
  template <Scalar T>
  RailSurface<T> operator()(T const& time, T const& arc_length, T const& slip, double energy_density,
                            double sand) const {
    if (map) return (*map)(map->over_time ? time : arc_length, slip, T(energy_density), sand);
    return {friction_at(law, slip), T(1.0), T(1.0)};
  }
};

}  // namespace rollerrig
