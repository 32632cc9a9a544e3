// integrate/step_control.hpp - from the error of a step to the size of the next.
//
// In:  error norm (1 = exactly the tolerance), the step it belongs to.  Out: the next step [s].
// Source  Hairer, Norsett, Wanner, Solving ODEs I (1993), II.4; Hairer, Wanner, Solving ODEs II
//         (1996), IV.2 (PI control, explicit) and IV.8 (predictive control, implicit); both controls
//         are due to Gustafsson (1991, 1994).
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace rollerrig::integrate {

/// Root mean square of error_i / (atol_i + rtol max(|x_i|, |x_new_i|)); HNW I eq. (4.11).
template <class Error, class State>
double error_norm(Error const& error, State const& x, State const& x_new, Eigen::VectorXd const& absolute,
                  double relative) {
  double sum = 0;
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    double const scale = absolute[i] + relative * std::max(std::abs(x[i]), std::abs(x_new[i]));
    double const ratio = error[i] / scale;
    sum += ratio * ratio;
  }
  return error.size() == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(error.size()));
}

class StepController {
 public:
  /// @param error_order  order q of the error estimate in the step: error ~ h^q
  /// @param implicit     predictive control (stiff methods) instead of PI control
  StepController(double error_order, bool implicit) : q_{error_order}, implicit_{implicit} {}

  /// Forget the past: after the start and after a kink of the input.
  void restart() { *this = StepController(q_, implicit_); }

  /// Next step after one with error <= 1.
  double accepted(double h, double error) {
    double shrink = implicit_ ? predictive(h, error) : proportional_integral(error);
    shrink = std::clamp(shrink, smallest_shrink(), largest_shrink);
    if (rejected_) shrink = std::max(shrink, 1.0);  // no growth right after a rejection
    rejected_ = false;
    last_step_ = h;
    last_error_ = std::max(error, implicit_ ? 1e-2 : 1e-4);
    return h / shrink;
  }

  /// Next trial after a step with error > 1.
  double rejected(double h, double error) {
    rejected_ = true;
    return h / std::clamp(std::pow(error, 1 / q_) / safety, 1.0, largest_shrink);
  }

  /// Next trial after a step whose states could not be evaluated.
  double failed(double h) {
    rejected_ = true;
    return 0.5 * h;
  }

  void state(auto& archive) {
    archive(rejected_, last_step_, last_error_);
    archive.need(last_step_ >= 0 && last_error_ > 0);
  }

 private:
  static constexpr double safety = 0.9;
  static constexpr double largest_shrink = 5;
  double smallest_shrink() const { return implicit_ ? 1.0 / 6 : 1.0 / 10; }

  /// HNW I, II.4 (4.13') with beta = 0.04 as in DOPRI5: damps the hunting of the step at the
  /// border of stability.
  double proportional_integral(double error) const {
    constexpr double beta = 0.04;
    return std::pow(error, 1 / q_ - 0.75 * beta) / std::pow(last_error_, beta) / safety;
  }

  /// HW II, IV.8 (8.21): extrapolates the trend of the error.
  double predictive(double h, double error) const {
    double const plain = std::pow(error, 1 / q_) / safety;
    if (last_step_ == 0) return plain;
    double const trend = last_step_ / h * std::pow(error * error / last_error_, 1 / q_) / safety;
    // Hairer's code: the more careful of both.  h is the step that just ended.
    return std::max(plain, trend);
  }

  double q_;
  bool implicit_;
  bool rejected_ = false;
  double last_step_ = 0;      // [s] 0: no accepted step yet
  double last_error_ = 1e-4;  // [-]
};

}  // namespace rollerrig::integrate
