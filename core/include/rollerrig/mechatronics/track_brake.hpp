// mechatronics/track_brake.hpp - brakes that act on the rail, not on a wheel: one of the laws in track_brake/, and when it is on.
//
//   demand, speed of the train -> [delay, straight rise] -> excitation, 0 to 1 -> force on each bogie, against running
//
// On track the force acts on what carries the magnets, in the line of its centre; on a rig there is no rail beside the rollers: it
// acts on the virtual train alone, by the same law.
//
// To add a law: a struct here, its line in AnyTrackBrake, its table in python/rollerrig/config/schema/brakes.py.
#pragma once
#include <algorithm>
#include <variant>

#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/fields.hpp"

namespace rollerrig {

/// Magnets that are lowered to the rail and rub on it.
///
///     F(v) = N mu(|v|) v/sqrt(v^2 + v_r^2)        (A20)
///
/// The attraction N stands between magnet and rail: it loads no wheel and unloads none. mu falls with speed as the law says that
/// the case names; what lies on the rail, and what rubbing magnets clean of it, is not part of it.
struct MagneticTrackBrake {
  static constexpr char const* name = "magnetic";

  double attraction{};
  FrictionLaw friction{};  ///< mu of pole shoes on the rail, over speed
  double regularisation_speed{};

  static constexpr auto fields() {
    using P = MagneticTrackBrake;
    return members(
        Member{"attraction", &P::attraction, "N", "attraction of all magnets of a bogie together, N", not_negative},
        Member{"friction", &P::friction},
        Member{"regularisation_speed", &P::regularisation_speed, "m/s",
               "speed below which friction turns into viscous drag, v_r", positive});
  }

  /// Against running [N], at a speed over the rail [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    using std::sqrt;
    T const fast = select(speed < 0.0, -speed, speed);
    return attraction * friction_at(friction, fast) * speed /
           sqrt(speed * speed + regularisation_speed * regularisation_speed);
  }
};

/// Magnets over the rail that do not touch it: eddy currents in the rail brake.
///
///     F(v) = 2 F_k / (v/v_k + v_k/v)        (A21)
///
/// Source  J.H. Wouterse, Critical torque and speed of eddy current brake with widely separated soft iron poles, IEE Proc. B 138
///         (1991): the curve over a critical speed. Its numbers for rails are the case's.
struct EddyCurrentTrackBrake {
  static constexpr char const* name = "eddy_current";

  double largest_force{}, critical_speed{};

  static constexpr auto fields() {
    using P = EddyCurrentTrackBrake;
    return members(Member{"largest_force", &P::largest_force, "N",
                          "largest force of all magnets of a bogie together, F_k", not_negative},
                   Member{"critical_speed", &P::critical_speed, "m/s",
                          "speed at which the largest force is reached, v_k", positive});
  }

  /// Against running [N], at a speed over the rail [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    return 2.0 * largest_force * critical_speed * speed / (speed * speed + critical_speed * critical_speed);
  }
};

using AnyTrackBrake = OneOf<MagneticTrackBrake, EddyCurrentTrackBrake>;

struct TrackBrake {
  AnyTrackBrake law{};  ///< of one bogie
  double bogies{};
  TimeTable demand{};
  double delay{}, rise_time{}, release_speed{};

  static constexpr auto fields() {
    using P = TrackBrake;
    return members(Member{"law", &P::law},
                   Member{"bogies", &P::bogies, "1", "number of bogies under test that have it", not_negative},
                   Member{"demand", &P::demand, "1", "demanded excitation, 0 to 1", fraction},
                   Member{"delay", &P::delay, "s", "delay from the demand to the first force: lowering", not_negative},
                   Member{"rise_time", &P::rise_time, "s", "rise time of the excitation, from none to full", positive},
                   Member{"release_speed", &P::release_speed, "m/s", "train speed below which the magnets are lifted",
                          not_negative});
  }

  /// Of one bogie in full excitation, against running [N], at a speed over the rail [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    return std::visit([&](auto const& one) { return one.force(speed); }, law);
  }

  /// The excitation a step later.
  double next(double excitation, double t, double train_speed, double h) const {
    double const wanted = train_speed < release_speed ? 0.0 : demand.at(t - delay);
    return std::clamp(wanted, excitation - h / rise_time, excitation + h / rise_time);
  }
};

}  // namespace rollerrig
