// mechatronics/virtual_axle.hpp - one axle that is only computed: its rotation on the degraded rail.
//
//   torque, friction brake, force of the rail over slip -> [one step] -> speed of the axle, force on it
//
//     J_w w' = C + B(w) - r T(w)        (D3), the brake's part B apart where it follows the axle's own speed
//
// Integration  theta method (one unknown, Newton): the slope of T over w is stiff at small slip, as that of B is where the pads
//              hold. theta = 1/2, and for a rate times step above 2 as much larger as damps it in one step.
#pragma once
#include <cmath>
#include <limits>

namespace rollerrig {

struct SpinningWheels {
  double inertia{};  ///< J_w, of both wheels and what turns with them [kg m^2]
  double radius{};   ///< r [m]
};

class VirtualAxle {
 public:
  VirtualAxle() = default;
  explicit VirtualAxle(double speed) : speed_{speed} {}

  /// @param torque  C, constant over the step [N m]
  /// @param rail    rail(w) -> T, forward [N]
  /// @param brake   brake(w) -> B, against the turning [N m]
  template <class Rail, class Brake>
  void step(SpinningWheels const& wheels, double torque, double period, Rail&& rail, Brake&& brake) {
    auto const held = [&](double w) { return rail(w) - brake(w) / wheels.radius; };
    double const before = speed_, reach = implicit_part(wheels, period, held);
    rate_ = locked_ ? 0.0 : solved_rate(wheels, torque, reach, held);
    double const within = speed_ + reach * rate_;
    force_ = rail(within), brake_ = brake(within);
    speed_ += period * rate_;
    middle_ = 0.5 * (before + speed_);
  }

  /// Until `unlock` it turns at `speed` [rad/s], whatever torque acts on it: locked wheels.
  void lock(double speed) {
    locked_ = true;
    speed_ = speed;
  }
  void unlock() { locked_ = false; }
  bool locked() const { return locked_; }

  double speed() const { return speed_; }          ///< w [rad/s]
  double middle_speed() const { return middle_; }  ///< mean of the last step [rad/s]
  double rate() const { return rate_; }            ///< over the last step [rad/s^2]
  double force() const { return force_; }          ///< T [N]
  double brake_torque() const { return brake_; }   ///< B [N m]
  void state(auto& archive) { archive(speed_, middle_, rate_, force_, brake_, locked_); }

 private:
  /// theta h: 1/2 h, or (1 - 1/(lambda h)) h for a rate lambda beyond 2/h.
  template <class Force>
  double implicit_part(SpinningWheels const& wheels, double period, Force&& force) const {
    double const w = speed_, dw = 1e-6 * (1.0 + std::fabs(w));
    double const stiffness = wheels.radius * (force(w + dw) - force(w - dw)) / (2.0 * dw * wheels.inertia);
    return stiffness * period > 2.0 ? period - 1.0 / stiffness : 0.5 * period;
  }

  /// Solves J_w a = C - r T(w + reach a) for a: Newton with a numerical slope, halving where it leaves the bracket. T over
  /// slip is steep in the middle and flat outside, where Newton alone oscillates without end.
  template <class Force>
  double solved_rate(SpinningWheels const& wheels, double torque, double reach, Force&& force) const {
    double const J = wheels.inertia, r = wheels.radius, w = speed_;
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    double a = (torque - r * force(w)) / J;
    for (int iteration = 0; iteration < 60; ++iteration) {
      double const at = w + reach * a;
      double const t = force(at);
      double const dw = 1e-6 * (1.0 + std::fabs(at));
      double const slope = (force(at + dw) - t) / dw;
      double const residual = J * a - torque + r * t;
      (residual > 0.0 ? high : low) = a;
      // Beyond the peak of adhesion T falls with slip: the step must not change its sign.
      double next = a - residual / std::fmax(J + r * slope * reach, 0.2 * J);
      bool const close = std::fabs(next - a) * reach < 1e-12 * (1.0 + std::fabs(w));
      if (!close && !(next > low && next < high) && std::isfinite(high - low)) next = 0.5 * (low + high);
      a = next;
      if (close) break;
    }
    return a;
  }

  double speed_{0.0}, middle_{0.0}, rate_{0.0}, force_{0.0}, brake_{0.0};
  bool locked_{false};
};

}  // namespace rollerrig
