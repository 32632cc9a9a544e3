// mechatronics/virtual_rail.hpp - the degraded rail under one axle of the virtual train: longitudinal contact force over slip.
//
//   slip, speed, load, place, energy -> [friction map, the case's creep law] -> force on the axle
//
// The laws are those of the 3-D contact; what is left out is everything sideways: both wheels of an axle roll centred, on
// an ellipse that grows with the load as Hertz' does.
#pragma once
#include <cmath>

#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/contact/creep/creep_law.hpp"

namespace rollerrig {

struct VirtualRail {
  CreepLaw creep{};
  Friction friction{};
  double wheel_load{54546.0};                 ///< static, of one wheel [N]; what follows belongs to it
  double a{6e-3}, b{4e-3};                    ///< semi-axes along and across the rolling direction [m]
  double width{6e-3};                         ///< that the patches of a wheel sweep together [m]
  double log_aspect{0.0};                     ///< ln(a/b)
  KalkerStiffness<double> stiffness{};        ///< of one wheel
  double creepage_regularisation_speed{0.1};  ///< [m/s]

  /// Force of both wheels on the axle, forward [N].
  ///
  /// @param slip   wheel surface speed less train speed [m/s]
  /// @param speed  of the train [m/s]
  /// @param load   of the axle [N]
  double force(double slip, double speed, double load, double time, double place, double energy_density) const {
    double const per_wheel = 0.5 * load;
    double const growth = std::cbrt(per_wheel / wheel_load);  // of the semi-axes
    double const rolling = speed + 0.5 * slip;
    double const epsilon =
        -slip / std::sqrt(rolling * rolling + creepage_regularisation_speed * creepage_regularisation_speed);
    double const grown = growth * growth;
    KalkerStiffness<double> const f{grown * stiffness.f11, grown * stiffness.f22, grown * growth * stiffness.f23,
                                    grown * grown * stiffness.f33};
    auto const surface = friction(time, place, std::fabs(slip), energy_density);
    double const adhesion = surface.friction * per_wheel + regularisation::adhesion;
    // Creepage is wheel over roller: a driving wheel's surface runs backwards.
    Creepage<double> const creepage{epsilon, 0.0, 0.0};
    CreepQuery<double> const query{creepage, f, adhesion, growth * a, growth * b, log_aspect, 1.0};
    auto const force = friction.map ? creep_force(creep, query, surface) : creep_force(creep, query);
    return 2.0 * force.longitudinal;
  }
};

}  // namespace rollerrig
