// mechatronics/virtual_train.hpp - the train on the degraded rail that the rig's controller integrates.
//
//   torque C on each axle (estimated) -> [virtual train] -> wheel speeds, contact forces and train speed to be reproduced
//
//     J_w w_v' = C - r T_v        (D3)
//     M v'     = sum T_v - R(v) - M g i - F        (D4)
//     F        of brakes that act on the rail
//     T_v      from the adhesion law at the virtual slip r w_v - v, per axle
//     N_i      = N_i0 + t_i (v' + g i)         (D9)
//
// Integration  theta method in each axle's speed (one unknown, Newton): the slope of T_v over w_v is stiff at small slip.
//              theta = 1/2, and for a rate times step above 2 as much larger as damps it in one step.
// Source  Malvezzi, Pugi et al., rig for degraded adhesion; Davis' formula for R(v).
#pragma once
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/axles.hpp"

namespace rollerrig {

struct VirtualTrain {
  double mass{};                        ///< M: that these axles carry and brake [kg]
  double wheelset_inertia{};            ///< J_w [kg m^2]
  double wheel_radius{};                ///< r [m]
  double resistance_constant{};         ///< R = A + B v + C v^2: A [N]
  double resistance_linear{};           ///< B [N s/m]
  double resistance_quadratic{};        ///< C [N s^2/m^2]
  double gradient{};                    ///< i, positive uphill [-]
  double gravity{};                     ///< [m/s^2]
  std::vector<double> static_load{};    ///< N_i0 of each axle [N]
  std::vector<double> load_transfer{};  ///< t_i [kg]
  std::vector<double> position{};       ///< of the axles along the train [m]

  static constexpr auto fields() {
    using P = VirtualTrain;
    return std::tuple{Member{"mass", &P::mass, positive},
                      Member{"wheelset_inertia", &P::wheelset_inertia, positive},
                      Member{"wheel_radius", &P::wheel_radius, positive},
                      Member{"resistance_constant", &P::resistance_constant},
                      Member{"resistance_linear", &P::resistance_linear},
                      Member{"resistance_quadratic", &P::resistance_quadratic},
                      Member{"gradient", &P::gradient},
                      Member{"gravity", &P::gravity},
                      Member{"static_load", &P::static_load},
                      Member{"load_transfer", &P::load_transfer},
                      Member{"position", &P::position}};
  }

  double resistance(double v) const {
    return resistance_constant + resistance_linear * v + resistance_quadratic * v * v;
  }
};

class VirtualTrainState {
 public:
  VirtualTrainState() = default;
  VirtualTrainState(VirtualTrain const& train, double speed) : speed_{speed} {
    axle_speed_.fill(speed / train.wheel_radius);
  }

  /// One sample under the torques `axle_torque` [N m], constant over it.
  ///
  /// @param load  of each axle [N], in place of (D9); null: (D9)
  /// @param retarding  F [N]
  /// @param law   law(axle, slip speed [m/s], train speed [m/s], axle load [N]) -> force T_v on the axle, forward [N]
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
      auto const force = [&](double w) { return law(i, train.wheel_radius * w - speed_middle, speed_middle, carries); };
      double const reach = implicit_part(train, axle_speed_[k], period, force);
      double const rate = locked_[k] ? 0.0 : axle_rate(train, axle_torque[k], axle_speed_[k], reach, force);
      force_[k] = force(axle_speed_[k] + reach * rate);
      axle_rate_[k] = rate;
      axle_speed_[k] += period * rate;
      sum += force_[k];
    }
    acceleration_ = (sum - train.resistance(speed_middle) - retarding) / train.mass - train.gravity * train.gradient;
    distance_ += period * speed_middle;
    speed_ = std::fmax(0.0, speed_ + period * acceleration_);
  }

  /// Until `unlock` this axle turns at `axle_speed` [rad/s], whatever torque acts on it: a locked wheel.
  void lock(int i, double axle_speed) {
    locked_[index(i)] = true;
    axle_speed_[index(i)] = axle_speed;
  }
  void unlock(int i) { locked_[index(i)] = false; }
  bool locked(int i) const { return locked_[index(i)]; }

  double speed() const { return speed_; }                ///< v [m/s]
  double distance() const { return distance_; }          ///< [m]
  double acceleration() const { return acceleration_; }  ///< v' [m/s^2]
  double axle_speed(int i) const { return axle_speed_[index(i)]; }
  double axle_rate(int i) const { return axle_rate_[index(i)]; }  ///< over the last sample [rad/s^2]
  double force(int i) const { return force_[index(i)]; }          ///< T_v [N]

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  /// theta h: 1/2 h, or (1 - 1/(lambda h)) h for a rate lambda beyond 2/h.
  template <class Force>
  double implicit_part(VirtualTrain const& train, double w, double period, Force&& force) const {
    double const dw = 1e-6 * (1.0 + std::fabs(w));
    double const stiffness = train.wheel_radius * (force(w + dw) - force(w - dw)) / (2.0 * dw * train.wheelset_inertia);
    return stiffness * period > 2.0 ? period - 1.0 / stiffness : 0.5 * period;
  }

  /// Solves J_w a = C - r T(w + reach a) for a: Newton with a numerical slope, halving where it leaves the bracket. T over
  /// slip is steep in the middle and flat outside, where Newton alone oscillates without end.
  template <class Force>
  double axle_rate(VirtualTrain const& train, double torque, double w, double reach, Force&& force) const {
    double const J = train.wheelset_inertia;
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    double a = (torque - train.wheel_radius * force(w)) / J;
    for (int iteration = 0; iteration < 60; ++iteration) {
      double const at = w + reach * a;
      double const t = force(at);
      double const dw = 1e-6 * (1.0 + std::fabs(at));
      double const slope = (force(at + dw) - t) / dw;
      double const residual = J * a - torque + train.wheel_radius * t;
      (residual > 0.0 ? high : low) = a;
      // Beyond the peak of adhesion T falls with slip: the step must not change its sign.
      double next = a - residual / std::fmax(J + train.wheel_radius * slope * reach, 0.2 * J);
      bool const close = std::fabs(next - a) * reach < 1e-12 * (1.0 + std::fabs(w));
      if (!close && !(next > low && next < high) && std::isfinite(high - low)) next = 0.5 * (low + high);
      a = next;
      if (close) break;
    }
    return a;
  }

  double speed_{0.0}, distance_{0.0}, acceleration_{0.0};
  PerAxle<double> axle_speed_{}, axle_rate_{}, force_{};
  PerAxle<bool> locked_{};
};

}  // namespace rollerrig
