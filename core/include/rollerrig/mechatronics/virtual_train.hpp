// mechatronics/virtual_train.hpp - the train on the degraded rail that the rig's controller integrates.
//
//   torque C on each axle (estimated) -> [virtual train] -> wheel speeds, contact forces and train speed to be reproduced
//
//     J_w w_v' = C - r T_v        (D3)
//     M v'     = sum T_v - R(v) - M g i - F        (D4)
//     F        of brakes that act on the rail, less that of the axles of simulated_axles.hpp
//     T_v      from the adhesion law at the virtual slip r w_v - v, per axle
//     N_i      = N_i0 + t_i (v' + g i)         (D9)
//
// Source  Malvezzi, Pugi et al., rig for degraded adhesion; Davis' formula for R(v).
#pragma once
#include <cmath>
#include <tuple>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/mechatronics/virtual_axle.hpp"

namespace rollerrig {

struct VirtualTrain {
  double mass{}, wheelset_inertia{}, wheel_radius{}, resistance_constant{}, resistance_linear{};
  double resistance_quadratic{}, gradient{}, gravity{};
  std::vector<double> static_load{}, load_transfer{}, position{};

  static constexpr auto fields() {
    using P = VirtualTrain;
    return members(
        Member{"mass", &P::mass, "kg", "mass that these axles carry and brake, M", positive},
        Member{"wheelset_inertia", &P::wheelset_inertia, "kg m^2",
               "moment of inertia of a wheelset about its axis, J_w", positive},
        Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheels, r", positive},
        Member{"resistance_constant", &P::resistance_constant, "N", "running resistance R = A + B v + C v^2: A"},
        Member{"resistance_linear", &P::resistance_linear, "N s/m", "running resistance R = A + B v + C v^2: B"},
        Member{"resistance_quadratic", &P::resistance_quadratic, "N s^2/m^2",
               "running resistance R = A + B v + C v^2: C"},
        Member{"gradient", &P::gradient, "1", "gradient of the line, positive uphill, i"},
        Member{"gravity", &P::gravity, "m/s^2", "acceleration of free fall, g"},
        Member{"static_load", &P::static_load, "N", "static load of each axle, N_i0"},
        Member{"load_transfer", &P::load_transfer, "kg", "load transfer of each axle, t_i in (D9)"},
        Member{"position", &P::position, "m", "position of each axle along the train"});
  }

  double resistance(double v) const {
    return resistance_constant + resistance_linear * v + resistance_quadratic * v * v;
  }
};

class VirtualTrainState {
 public:
  VirtualTrainState() = default;
  VirtualTrainState(VirtualTrain const& train, double speed) : speed_{speed} {
    axle_.fill(VirtualAxle{speed / train.wheel_radius});
  }

  /// One sample under the torques `axle_torque` [N m], constant over it.
  ///
  /// @param axles  under test: the first ones of the train's lists
  /// @param load   of each of them [N], in place of (D9); null: (D9)
  /// @param retarding  F [N]
  /// @param law    law(axle, slip speed [m/s], train speed [m/s], axle load [N]) -> force T_v on the axle, forward [N]
  template <class Law>
  void step(VirtualTrain const& train, int axles, PerAxle<double> const& axle_torque, PerAxle<double> const* load,
            double retarding, double period, Law&& law) {
    double const half = 0.5 * period;
    double const speed_middle = std::fmax(0.0, speed_ + half * acceleration_);
    double const specific_force = acceleration_ + train.gravity * train.gradient;
    double sum = 0.0;
    for (int i = 0; i < axles; ++i) {
      auto const k = index(i);
      double const carries =
          load != nullptr ? (*load)[k] : train.static_load[k] + train.load_transfer[k] * specific_force;
      auto const rail = [&](double w) { return law(i, train.wheel_radius * w - speed_middle, speed_middle, carries); };
      auto const no_brake = [](double /*w*/) { return 0.0; };  // it is in the torque
      axle_[k].step({train.wheelset_inertia, train.wheel_radius}, axle_torque[k], period, rail, no_brake);
      sum += axle_[k].force();
    }
    acceleration_ = (sum - train.resistance(speed_middle) - retarding) / train.mass - train.gravity * train.gradient;
    distance_ += period * speed_middle;
    speed_ = std::fmax(0.0, speed_ + period * acceleration_);
  }

  void lock(int i, double axle_speed) { axle_[index(i)].lock(axle_speed); }
  void unlock(int i) { axle_[index(i)].unlock(); }
  bool locked(int i) const { return axle_[index(i)].locked(); }

  double speed() const { return speed_; }                ///< v [m/s]
  double distance() const { return distance_; }          ///< [m]
  double acceleration() const { return acceleration_; }  ///< v' [m/s^2]
  double axle_speed(int i) const { return axle_[index(i)].speed(); }
  double axle_rate(int i) const { return axle_[index(i)].rate(); }  ///< over the last sample [rad/s^2]
  double force(int i) const { return axle_[index(i)].force(); }     ///< T_v [N]
  void state(auto& archive) { archive(speed_, distance_, acceleration_, axle_); }

 private:
  static std::size_t index(int i) { return at(i); }

  double speed_{0.0}, distance_{0.0}, acceleration_{0.0};
  PerAxle<VirtualAxle> axle_{};
};

}  // namespace rollerrig
