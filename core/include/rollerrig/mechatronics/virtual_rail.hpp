// mechatronics/virtual_rail.hpp - the degraded rail under one axle of the virtual train: longitudinal contact force over slip.
//
//   slip, speed, load, place, energy -> [friction map, the case's creep law] -> force on the axle
//   force, slip, way -> [rail_memory.hpp] -> energy and sand under the axle
//
// The laws are those of the 3-D contact; what is left out is everything sideways: both wheels of an axle roll centred, on
// an ellipse that grows with the load as Hertz' does.
#pragma once
#include <cmath>
#include <span>
#include <vector>

#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/contact/adhesion/rail_memory.hpp"
#include "rollerrig/contact/creep/creep_law.hpp"

namespace rollerrig {

/// One ellipse that stands for all patches of a wheel.
struct EquivalentPatch {
  double load{};    ///< of the wheel [N]
  double a{}, b{};  ///< semi-axes along and across the rolling direction [m]
  double width{};   ///< that the patches sweep together: their area over their length [m]
};

/// The ellipse with the patches' area together and their mean shape, weighted with their areas.
inline EquivalentPatch equivalent_patch(double load, std::vector<double> const& a, std::vector<double> const& b) {
  double area = 0.0, squares = 0.0, across = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) area += a[i] * b[i], squares += a[i] * a[i], across += b[i];
  double const aspect = squares / area;
  return {load, std::sqrt(area * aspect), std::sqrt(area / aspect), 0.5 * pi * across};
}

/// What lies on the rails, left there by the axles ahead.
struct FoundRail {
  std::span<RailCells> energy{};  ///< of one rail or two; an axle finds their mean and cleans all of them
  SandedRail* sand{};             ///< null: none
  double const* sand_flow{};      ///< in front of each axle [kg/s]
  double friction{1.0};           ///< over what its law says
};

/// What an axle finds there, with its own part.
struct RailUnderAxle {
  double energy{};  ///< dissipated per area, and what the wheels keep [J/m^2]
  double sand{};    ///< mass per length [kg/m]
  CleanedWheel wheels{};
  void state(auto& archive) { archive(energy, sand, wheels); }
};

/// An axle over a step.
struct AxlePassage {
  double from{}, passed{};              ///< place along the rail, length of it that passes [m]
  double train_speed{}, wheel_speed{};  ///< the wheels' at their circumference [m/s]
  double force{};                       ///< of the rail [N]
  double circumference{}, period{};     ///< [m], [s]
};

struct VirtualRail {
  CreepLaw creep{};
  Friction friction{};
  double wheel_load{}, a{}, b{}, width{}, cell{}, wheel_memory{}, sand_kept{1.0};
  KalkerStiffness<double> stiffness{};  ///< of one wheel
  double creepage_regularisation_speed{};

  static constexpr auto fields() {
    using P = VirtualRail;
    return members(
        Member{"creep", &P::creep}, Member{"friction", &P::friction},
        Member{"wheel_load", &P::wheel_load, "N", "static load of one wheel, to which the ellipse belongs", positive},
        Member{"a", &P::a, "m", "semi-axis along the rolling direction", positive},
        Member{"b", &P::b, "m", "semi-axis across it", positive},
        Member{"width", &P::width, "m",
               "width over which dissipated energy is spread: that the patches of a wheel sweep together", positive},
        Member{"cell", &P::cell, "m", "length of the cells in which dissipated energy is kept", positive},
        Member{"wheel_memory", &P::wheel_memory, "m",
               "rolling distance over which a wheel's own cleaning fades; 0: it keeps nothing", not_negative},
        Member{"sand_kept", &P::sand_kept, "1", "part of the sand on the rail that a wheel leaves behind", fraction},
        Member{"stiffness", &P::stiffness},
        Member{"creepage_regularisation_speed", &P::creepage_regularisation_speed, "m/s",
               "rolling speed below which creepage turns into viscous friction, V_s", not_negative});
  }

  /// Force of both wheels on the axle, forward [N].
  ///
  /// @param slip   wheel surface speed less train speed [m/s]
  /// @param speed  of the train [m/s]
  /// @param load   of the axle [N]
  /// @param place  distance along the rail [m]
  /// @param energy_density  dissipated per area of the rail there [J/m^2]
  /// @param sand   mass per length of the rail there [kg/m]
  /// @param friction_factor  over what the law says
  double force(double slip, double speed, double load, double time, double place, double energy_density, double sand,
               double friction_factor = 1.0) const {
    double const per_wheel = 0.5 * load;
    double const growth = std::cbrt(per_wheel / wheel_load);  // of the semi-axes
    double const rolling = speed + 0.5 * slip;
    double const epsilon =
        -slip / std::sqrt(rolling * rolling + creepage_regularisation_speed * creepage_regularisation_speed);
    double const grown = growth * growth;
    KalkerStiffness<double> const f{grown * stiffness.f11, grown * stiffness.f22, grown * growth * stiffness.f23,
                                    grown * grown * stiffness.f33};
    auto const surface = friction(time, place, std::fabs(slip), energy_density, sand);
    double const adhesion = friction_factor * surface.friction * per_wheel + regularisation::adhesion;
    // Creepage is wheel over roller: a driving wheel's surface runs backwards.
    Creepage<double> const creepage{epsilon, 0.0, 0.0};
    CreepQuery<double> const query{creepage, f, adhesion, growth * a, growth * b, std::log(a / b), 1.0};
    auto const force = friction.map ? creep_force(creep, query, surface) : creep_force(creep, query);
    return 2.0 * force.longitudinal;
  }

  /// What the wheels ahead and this axle, number i, have left on the rail under it.
  void pass(RailUnderAxle& under, AxlePassage const& axle, FoundRail const& found, std::size_t i) const {
    double const power = 0.5 * std::fabs(axle.force * (axle.wheel_speed - axle.train_speed));  // of one wheel
    under.energy =
        under.wheels.pass(found.energy, axle.from, axle.passed, energy_per_area(power, axle.train_speed, width),
                          axle.period * std::fabs(axle.wheel_speed), axle.circumference, wheel_memory);
    if (found.sand != nullptr)
      under.sand = found.sand->run(axle.from, axle.from + axle.passed, found.sand_flow[i] * axle.period, sand_kept);
  }
};

}  // namespace rollerrig
