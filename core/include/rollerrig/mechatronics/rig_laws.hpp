// mechatronics/rig_laws.hpp - the laws of the rig's controller that a case can name: feedback of the roller drives, where it takes
// the torque on an axle from, and how a roller's drive is asked for a torque.
//
//   error of speed, feed-forward -> [feedback] -> wanted torque
//   estimate, pressure in the cylinder, torque of the motor -> [axle torque] -> C of the virtual train, (D3)
//   wanted torque, measured torque -> [drive command] -> command, within the largest torque
//
// To add one: a struct here, its line in AnyFeedback, AnyAxleTorque or AnyDriveCommand, its parameters in
// python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <algorithm>
#include <cmath>
#include <optional>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/estimators.hpp"

namespace rollerrig {

/// What the feedback of a roller's drive acts on at one sample.
struct TrackingError {
  double feed_forward{};  ///< (D5) [N m]
  double error{};         ///< virtual minus measured wheel speed [rad/s]
  double period{};        ///< since the last sample [s]
};

struct NoFeedback {
  static constexpr char const* name = "none";
  static constexpr auto fields() { return members(); }

  struct State {};

  double step(State& /*state*/, AssumedParameters const& /*assumed*/, TrackingError const& now,
              double /*limit*/) const {
    return now.feed_forward;
  }
};

/// PI feedback on the wheels' speed, without wind-up at the command's limit.
///
/// For wheel and roller as one inertia J = J_w + J_r (r/R)^2, with bandwidth w and damping ratio zeta of the loop:
///
///     k_p = 2 zeta w J R/r,   k_i = w^2 J R/r        (D6)
///
/// Source  docs/theory/rig_control.md.
struct ProportionalIntegral {
  static constexpr char const* name = "proportional_integral";
  double bandwidth{}, damping_ratio{};
  std::optional<double> proportional{}, integral{};

  static constexpr auto fields() {
    using P = ProportionalIntegral;
    return members(Member{"bandwidth", &P::bandwidth, "rad/s", "bandwidth of the loop, w", positive},
                   Member{"damping_ratio", &P::damping_ratio, "1", "damping ratio of the loop, zeta", not_negative},
                   Member{"proportional", &P::proportional, "N m s/rad", "proportional gain k_p in place of (D6)"},
                   Member{"integral", &P::integral, "N m/rad", "integral gain k_i in place of (D6)"});
  }

  struct Gains {
    double proportional{}, integral{};
  };
  /// (D6), where they are not given.
  Gains gains(AssumedParameters const& p) const {
    double const ratio = p.wheel_radius / p.roller_radius;
    double const inertia = p.wheelset_inertia + p.roller_inertia * (ratio * ratio);
    return {proportional.value_or(2.0 * damping_ratio * bandwidth * inertia / ratio),
            integral.value_or(bandwidth * bandwidth * inertia / ratio)};
  }

  struct State {
    double integral{};  ///< of the error [rad]
    void state(auto& archive) { archive(integral); }
  };

  double step(State& s, AssumedParameters const& assumed, TrackingError const& now, double limit) const {
    auto const [k_p, k_i] = gains(assumed);
    double const with = now.feed_forward + k_p * now.error + k_i * (s.integral + now.period * now.error);
    if (std::fabs(with) <= limit) s.integral += now.period * now.error;
    return now.feed_forward + (k_p * now.error + k_i * s.integral);
  }
};

/// A torque of constant size against the error's sign, in proportion near zero.
struct SlidingMode {
  static constexpr char const* name = "sliding_mode";
  double switching{}, boundary_layer{};

  static constexpr auto fields() {
    using P = SlidingMode;
    return members(Member{"switching", &P::switching, "N m", "largest torque of the feedback"},
                   Member{"boundary_layer", &P::boundary_layer, "rad/s",
                          "speed error at which the largest torque is reached", positive});
  }

  struct State {};

  double step(State& /*state*/, AssumedParameters const& /*assumed*/, TrackingError const& now,
              double /*limit*/) const {
    return now.feed_forward + switching * std::clamp(now.error / boundary_layer, -1.0, 1.0);
  }
};

using AnyFeedback = OneOf<ProportionalIntegral, SlidingMode, NoFeedback>;

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

using AnyAxleTorque = OneOf<EstimatedTorque, KnownTorque, ExtrapolatedTorque>;

/// The torque that a roller's drive is to exert, and what it exerts.
struct WantedTorque {
  double feed_forward{};  ///< of it, (D5) [N m]
  double total{};         ///< with the feedback [N m]
  double measured{};      ///< of the drive now [N m]
};

/// The drive is asked for the wanted torque, and follows with its lag.
struct DirectCommand {
  static constexpr char const* name = "direct";
  static constexpr auto fields() { return members(); }

  struct State {};

  double step(State& /*state*/, WantedTorque const& now, double /*period*/) const { return now.total; }
};

/// The feed-forward runs ahead along its slope by what the drive will be late.
///
///     c = U + a U_ff'        (D20)
///
/// With a the lag 1/w_b of a drive of first order this is its inverse. Source  docs/theory/rig_control.md.
struct LeadCommand {
  static constexpr char const* name = "lead";
  double ahead{};

  static constexpr auto fields() {
    return members(Member{"ahead", &LeadCommand::ahead, "s", "lead of the feed-forward, a", not_negative});
  }

  struct State {
    double last{};  ///< feed-forward [N m]
    void state(auto& archive) { archive(last); }
  };

  double step(State& s, WantedTorque const& now, double period) const {
    double const slope = (now.feed_forward - s.last) / period;
    s.last = now.feed_forward;
    return now.total + ahead * slope;
  }
};

/// A loop around the drive, closed over its measured torque.
///
///     c = U + g (U - U_measured)        (D21)
///
/// A drive of first order gets the bandwidth (1 + g) w_b. Source  docs/theory/rig_control.md.
struct TorqueLoop {
  static constexpr char const* name = "torque_loop";
  double gain{};

  static constexpr auto fields() {
    return members(Member{"gain", &TorqueLoop::gain, "1", "gain on demanded less measured torque, g", not_negative});
  }

  struct State {};

  double step(State& /*state*/, WantedTorque const& now, double /*period*/) const {
    return now.total + gain * (now.total - now.measured);
  }
};

using AnyDriveCommand = OneOf<DirectCommand, LeadCommand, TorqueLoop>;

}  // namespace rollerrig
