// mechatronics/wheel_slip_control.hpp - reduces the torque of a driven axle that slips, and restores it.
//
//   axle speeds (sampled), estimated train speed -> slip and acceleration -> factor on the torque demand of each axle, (A8)
#pragma once
#include <cmath>
#include <string_view>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/mechatronics/reference_speed.hpp"

namespace rollerrig {

struct WheelSlipControl {
  static constexpr char const* name = "wheel_slip_control";
  static constexpr Command command = Command::torque_factor;

  double wheel_radius{};            ///< assumed [m]
  double reference_acceleration{};  ///< largest of the reference speed [m/s^2]
  double slip{};                    ///< relative slip above which torque is reduced [-]
  double slip_speed{};              ///< and the least such slip as a speed [m/s]
  double acceleration{};            ///< an axle that gains speed faster loses torque as well [m/s^2]
  double filter_time{};             ///< of the axles' acceleration [s]
  double reduction_rate{};          ///< of the factor [1/s]
  double restoring_rate{};          ///< [1/s]
  double least_factor{};            ///< [-]
  double release_interval{};        ///< while axles slip, one is released this often for the reference; 0: never [s]
  double shortest_release{};        ///< the torque needs some time to fall [s]
  double longest_release{};         ///< [s]
  double release_deceleration{};    ///< a released axle that slows less runs at the train's speed [m/s^2]
  double least_acceleration{};      ///< of the reference between releases [m/s^2]
  double regained_after{};          ///< without slip for this long, the axles run at the train's speed [s]

  static constexpr auto fields() {
    using P = WheelSlipControl;
    return std::tuple{Member{"wheel_radius", &P::wheel_radius, positive},
                      Member{"reference_acceleration", &P::reference_acceleration},
                      Member{"slip", &P::slip},
                      Member{"slip_speed", &P::slip_speed},
                      Member{"acceleration", &P::acceleration},
                      Member{"filter_time", &P::filter_time, not_negative},
                      Member{"reduction_rate", &P::reduction_rate},
                      Member{"restoring_rate", &P::restoring_rate},
                      Member{"least_factor", &P::least_factor},
                      Member{"release_interval", &P::release_interval},
                      Member{"shortest_release", &P::shortest_release},
                      Member{"longest_release", &P::longest_release},
                      Member{"release_deceleration", &P::release_deceleration},
                      Member{"least_acceleration", &P::least_acceleration},
                      Member{"regained_after", &P::regained_after}};
  }

  struct AxleState {
    double speed{}, acceleration{};  ///< at the wheel's circumference [m/s], [m/s^2]
    double factor{1.0};
  };
  struct State {
    PerAxle<AxleState> axle{};
    ReferenceSpeed reference{false, 0.0};
    double no_slip_for{1e9};  ///< [s]; before the first slip: for ever

    double reference_speed() const { return reference.value(); }
  };

  State start(Measurements const& /*now*/, double train_speed, double /*period*/) const {
    State state{.axle = {}, .reference = {false, train_speed}};
    for (AxleState& axle : state.axle) axle.speed = train_speed;
    return state;
  }

  /// One sample: factors on the torque demand, 0..1.
  void step(State& s, Measurements const& now, double period, PerAxle<double>& factor) const {
    double slowest = wheel_radius * now.vehicle_axle_speed[0];
    for (int i = 1; i < now.axles; ++i)
      slowest = std::fmin(slowest, wheel_radius * now.vehicle_axle_speed[static_cast<std::size_t>(i)]);
    follow(s, slowest, now.axles, period);
    double const reference = s.reference.value();
    for (int i = 0; i < now.axles; ++i) {
      auto const k = static_cast<std::size_t>(i);
      AxleState& axle = s.axle[k];
      double const speed = wheel_radius * now.vehicle_axle_speed[k];
      axle.acceleration += period / (filter_time + period) * ((speed - axle.speed) / period - axle.acceleration);
      axle.speed = speed;
      double const slips_above = std::fmax(slip * std::fabs(reference), slip_speed);
      bool const slips = speed - reference > slips_above || axle.acceleration > acceleration;
      s.no_slip_for = slips ? 0.0 : s.no_slip_for;
      axle.factor += (slips || s.reference.releases(i) ? -reduction_rate : restoring_rate) * period;
      axle.factor = std::fmin(1.0, std::fmax(least_factor, axle.factor));
      factor[k] = axle.factor;
    }
  }

 private:
  void follow(State& s, double slowest, int axles, double period) const {
    ReferenceSpeedRules const rules{reference_acceleration, least_acceleration, release_interval, shortest_release,
                                    longest_release};
    s.reference.advance(slowest, period);
    s.no_slip_for += period;
    if (s.no_slip_for > regained_after) return s.reference.is_known(rules);
    s.reference.search(rules, slowest, axles, period, [&](int axle) {
      return s.axle[static_cast<std::size_t>(axle)].acceleration < -release_deceleration;
    });
  }
};

}  // namespace rollerrig
