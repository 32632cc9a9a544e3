// mechatronics/axle_torques.hpp - where the controller takes the torque on an axle from: the laws that a case can name.
//
//   estimate, pressure in the cylinder, torque of the motor -> [axle torque] -> C of the virtual train, (D3)
//
// To add one: a struct here, its line in AnyAxleTorque, its parameters in python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <cmath>
#include <string_view>
#include <variant>

#include "rollerrig/fields.hpp"

namespace rollerrig {

/// What the controller knows of one axle's torque at a sample.
struct TorqueSample {
  double estimate{};   ///< of the estimator, late by its lag [N m]
  double bandwidth{};  ///< of the estimator [rad/s]; 0: no lag
  double motor{};      ///< of the traction motor, as its drive reports it [N m]
  double brake{};      ///< of the friction brake, from the pressure in its cylinder and the friction of its pads [N m]
};

/// The axle's torque as the estimator finds it, late by the estimator's lag.
struct EstimatedTorque {
  static constexpr char const* name = "estimated";
  static constexpr auto fields() { return members(); }

  struct State {};

  double step(State& /*state*/, TorqueSample const& now, double /*period*/) const { return now.estimate; }
};

/// The axle's torque from cylinder pressure and motor current, corrected by the estimate.
///
///     K = C_motor + f C_brake(p, w),   C = K + G_c (C_e - G_e K)        (D18)
///
/// The known torque K has no lag and may be wrong in size; the estimate C_e is right in the mean and late. G_e has the lag of the
/// estimator, so that a change which both see is no error; G_c is slow.
///
/// Source  complementary filter; docs/theory/rig_control.md.
struct KnownTorque {
  static constexpr char const* name = "known";
  double bandwidth{}, brake_friction{};

  static constexpr auto fields() {
    return members(Member{"bandwidth", &KnownTorque::bandwidth, "rad/s",
                          "bandwidth of the correction by the estimate, G_c", positive},
                   Member{"brake_friction", &KnownTorque::brake_friction, "1",
                          "friction of the pads as assumed, over the real one, f", not_negative});
  }

  struct State {
    double late{};        ///< G_e K [N m]
    double correction{};  ///< [N m]
    void state(auto& archive) { archive(late, correction); }
  };

  double step(State& s, TorqueSample const& now, double period) const {
    double const known = now.motor + brake_friction * now.brake;
    s.late += (now.bandwidth > 0.0 ? 1.0 - std::exp(-now.bandwidth * period) : 1.0) * (known - s.late);
    s.correction += (1.0 - std::exp(-bandwidth * period)) * (now.estimate - s.late - s.correction);
    return known + s.correction;
  }
};

/// The estimated torque of the axle, run ahead along its slope.
///
///     C = C_e + a G C_e'        (D19)
///
/// G, a low-pass of first order, keeps noise out of the slope. Source  docs/theory/rig_control.md.
struct ExtrapolatedTorque {
  static constexpr char const* name = "extrapolated";
  double ahead{}, bandwidth{};

  static constexpr auto fields() {
    return members(Member{"ahead", &ExtrapolatedTorque::ahead, "s", "lead of the estimate, a", not_negative},
                   Member{"bandwidth", &ExtrapolatedTorque::bandwidth, "rad/s",
                          "bandwidth of the low-pass on its slope, G", positive});
  }

  struct State {
    double last{}, slope{};  ///< C_e [N m], its filtered rate [N m/s]
    void state(auto& archive) { archive(last, slope); }
  };

  double step(State& s, TorqueSample const& now, double period) const {
    s.slope += (1.0 - std::exp(-bandwidth * period)) * ((now.estimate - s.last) / period - s.slope);
    s.last = now.estimate;
    return now.estimate + ahead * s.slope;
  }
};

using AnyAxleTorque = std::variant<EstimatedTorque, KnownTorque, ExtrapolatedTorque>;

}  // namespace rollerrig
