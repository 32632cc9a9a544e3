// mechatronics/wheel_slip_control.hpp - reduces the torque of a driven axle that slips, and restores it.
//
//   axle speeds (sampled), estimated train speed -> slip and acceleration -> factor on the torque of each axle, (A8)
//
// The torque is that of traction, or of an electrodynamic brake: braking is traction with all speeds negative. Which of them it is
// says the sign of the motors' torque.
#pragma once
#include <cmath>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/mechatronics/reference_speed.hpp"

namespace rollerrig {

// Finds by trial the slip at which an axle transmits most.
//     M = mean(C) - J (w_1 - w_0)/t,   s <- s q or s/q: as before where M has grown, the other way where it has fallen   (A24)
// Perturb and observe. Only intervals count in which the axle has slipped and was not released for the reference speed: where the
// slip limits nothing there is nothing to learn. Source  ours; docs/theory/adhesion.md.

struct SlipSearch {
  double interval{}, ratio{}, least{}, largest{}, axle_inertia{};

  static constexpr auto fields() {
    using P = SlipSearch;
    return members(
        Member{"interval", &P::interval, "s", "interval t between two changes of the slip; 0: no search", not_negative},
        Member{"ratio", &P::ratio, "1", "ratio q of a change", Range{1.0, 10.0, "1 to 10"}},
        Member{"least", &P::least, "1", "least slip tried, over that of the thresholds", not_negative},
        Member{"largest", &P::largest, "1", "largest slip tried, over that of the thresholds", not_negative},
        Member{"axle_inertia", &P::axle_inertia, "kg m^2", "inertia of an axle with its motor as assumed, J",
               not_negative});
  }

  /// Of one axle.
  struct State {
    double slip{1.0};           ///< s, on the thresholds of slip
    bool rises{false};          ///< by its last change
    double clock{}, impulse{};  ///< of the interval [s], of the motor in it [N m s]
    double speed_before{};      ///< w_0 [rad/s]
    double last{};              ///< M of the interval before [N m]; 0: it does not count
    bool slipped{false};        ///< in the interval
    void state(auto& archive) { archive(slip, rises, clock, impulse, speed_before, last, slipped); }
  };

  /// One sample of an axle that slips or not.
  ///
  /// @param torque, speed  of the motor and of the axle, both in the sense in which the axle slips [N m], [rad/s]
  void step(State& s, double torque, double speed, bool slips, bool released, double period) const {
    if (!(interval > 0.0)) return;
    if (released || s.clock == 0.0) s = {s.slip, s.rises, 0.0, 0.0, speed, released ? 0.0 : s.last, false};
    s.clock += period;
    s.impulse += torque * period;
    s.slipped = s.slipped || slips;
    if (s.clock < interval) return;
    double const transmitted = (s.impulse - axle_inertia * (speed - s.speed_before)) / s.clock;
    if (s.slipped) {
      if (transmitted < s.last) s.rises = !s.rises;
      s.slip = std::fmin(std::fmax(largest, least), std::fmax(least, s.rises ? s.slip * ratio : s.slip / ratio));
    }
    s.last = s.slipped ? transmitted : 0.0;
    s.clock = 0.0;
  }
};

struct WheelSlipControl {
  static constexpr char const* name = "wheel_slip_control";
  static constexpr Command command = Command::torque_factor;

  double wheel_radius{}, reference_acceleration{}, slip{}, slip_speed{}, acceleration{}, filter_time{};
  double reduction_rate{}, restoring_rate{}, least_factor{}, release_interval{}, shortest_release{};
  double longest_release{}, release_deceleration{}, least_acceleration{}, regained_after{};
  SlipSearch search{};

  static constexpr auto fields() {
    using P = WheelSlipControl;
    return members(
        Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheels as assumed", positive},
        Member{"reference_acceleration", &P::reference_acceleration, "m/s^2",
               "largest acceleration of the reference speed"},
        Member{"slip", &P::slip, "1", "relative slip above which torque is reduced"},
        Member{"slip_speed", &P::slip_speed, "m/s", "lower limit of that slip as a speed"},
        Member{"acceleration", &P::acceleration, "m/s^2", "acceleration above which an axle loses torque as well"},
        Member{"filter_time", &P::filter_time, "s", "filter time of the axles' acceleration", not_negative},
        Member{"reduction_rate", &P::reduction_rate, "1/s", "reduction rate of the factor on the torque"},
        Member{"restoring_rate", &P::restoring_rate, "1/s", "restoring rate of the factor on the torque"},
        Member{"least_factor", &P::least_factor, "1", "least factor on the torque"},
        Member{"release_interval", &P::release_interval, "s",
               "interval at which an axle is released for the reference speed while axles slip; 0: never"},
        Member{"shortest_release", &P::shortest_release, "s",
               "shortest duration of such a release: the torque needs some time to fall"},
        Member{"longest_release", &P::longest_release, "s", "longest duration of such a release"},
        Member{"release_deceleration", &P::release_deceleration, "m/s^2",
               "deceleration below which a released axle runs at the train's speed"},
        Member{"least_acceleration", &P::least_acceleration, "m/s^2",
               "least acceleration of the reference speed between releases"},
        Member{"regained_after", &P::regained_after, "s",
               "duration without slip after which the axles run at the train's speed"},
        Member{"search", &P::search});
  }

  struct AxleState {
    double speed{}, acceleration{};  ///< at the wheel's circumference [m/s], [m/s^2]
    double factor{1.0};
    SlipSearch::State search{};
    void state(auto& archive) { archive(speed, acceleration, factor, search); }
  };
  struct State {
    PerAxle<AxleState> axle{};
    ReferenceSpeed reference{false, 0.0};
    double no_slip_for{1e9};  ///< [s]; before the first slip: for ever

    double reference_speed() const { return reference.value(); }
    void state(auto& archive) { archive(axle, reference, no_slip_for); }
  };

  State start(Measurements const& /*now*/, double train_speed, double /*period*/) const {
    State state{.axle = {}, .reference = {false, train_speed}};
    for (AxleState& axle : state.axle) axle.speed = train_speed;
    return state;
  }

  /// One sample: factors on the torque demand, 0..1.
  void step(State& s, Measurements const& now, double period, PerAxle<double>& factor) const {
    double const sign = follow(s, now, period);  // 1 in traction, -1 in braking
    double const reference = s.reference.value();
    for (int i = 0; i < now.axles; ++i) {
      auto const k = at(i);
      AxleState& axle = s.axle[k];
      double const speed = wheel_radius * now.vehicle_axle_speed[k];
      axle.acceleration += period / (filter_time + period) * ((speed - axle.speed) / period - axle.acceleration);
      axle.speed = speed;
      double const slips_above = axle.search.slip * std::fmax(slip * std::fabs(reference), slip_speed);
      bool const slips = sign * (speed - reference) > slips_above || sign * axle.acceleration > acceleration;
      bool const released = s.reference.releases(i);
      search.step(axle.search, sign * now.motor_torque[k], sign * now.vehicle_axle_speed[k], slips, released, period);
      s.no_slip_for = slips ? 0.0 : s.no_slip_for;
      axle.factor += (slips || released ? -reduction_rate : restoring_rate) * period;
      axle.factor = std::fmin(1.0, std::fmax(least_factor, axle.factor));
      factor[k] = axle.factor;
    }
  }

 private:
  /// The reference speed, one sample on.
  ///
  /// @return  1 of motors that pull, -1 of those that brake; of motors without torque what they did last
  double follow(State& s, Measurements const& now, double period) const {
    double torque = 0.0;
    for (int i = 0; i < now.axles; ++i) torque += now.motor_torque[at(i)];
    double const sign = torque > 0.0 ? 1.0 : torque < 0.0 ? -1.0 : s.reference.sign();
    double nearest = wheel_radius * now.vehicle_axle_speed[0];
    for (int i = 1; i < now.axles; ++i)
      nearest = sign * std::fmin(sign * nearest, sign * wheel_radius * now.vehicle_axle_speed[at(i)]);
    if (sign != s.reference.sign()) s.reference = {sign < 0.0, nearest};
    ReferenceSpeedRules const rules{reference_acceleration, least_acceleration, release_interval, shortest_release,
                                    longest_release};
    s.reference.advance(nearest, period);
    s.no_slip_for += period;
    if (s.no_slip_for > regained_after)
      s.reference.is_known(rules);
    else
      s.reference.search(rules, nearest, now.axles, period,
                         [&](int axle) { return sign * s.axle[at(axle)].acceleration < -release_deceleration; });
    return sign;
  }
};

}  // namespace rollerrig
