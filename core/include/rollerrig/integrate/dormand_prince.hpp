// integrate/dormand_prince.hpp - the explicit pair of Dormand and Prince, order 5(4), 7 stages of
// which the last is the next step's first.
//
// Dense output of order 4 (local error h^5) from the same stages.
// Source  Dormand, Prince (1980); Hairer, Norsett, Wanner, Solving ODEs I (1993), II.5 table 5.2 and
//         II.6 (6.13); the form of the dense output is that of Hairer's DOPRI5.
#pragma once
#include <utility>

#include "rollerrig/integrate/evaluator.hpp"

namespace rollerrig::integrate {

class DormandPrince {
 public:
  static constexpr int order = 5;
  static constexpr int error_order = 5;
  static constexpr bool implicit = false;

  template <class System>
  explicit DormandPrince(Evaluator<System> const& f) : states_{f.sizes().states} {
    auto const size = f.sizes().states + f.sizes().quadratures;
    for (Vector* v : {&k1_, &k2_, &k3_, &k4_, &k5_, &k6_, &k7_, &stage_, &bend_, &quartic_}) v->setZero(size);
    error_.setZero(states_);
  }

  void restart() { has_end_slope_ = false; }

  /// Once before each new step (not before its repetitions).
  template <class System>
  Status prepare(Evaluator<System>& f, double t, Vector const& y) {
    if (std::exchange(has_end_slope_, false)) {
      k1_.swap(k7_);
      return Status::ok;
    }
    return f.derivative(t, y, k1_);
  }

  Vector const& slope() const { return k1_; }

  /// Difference of the two solutions, states only.
  Vector const& error() const { return error_; }

  template <class System>
  Status attempt(Evaluator<System>& f, Step const& s, Vector const& y, Vector& y_new) {
    double const h = s.h;
    has_polynomial_ = false;
    has_end_slope_ = false;
    stage_ = y + (h / 5) * k1_;
    if (auto e = f.derivative(s.t + h / 5, stage_, k2_); e != Status::ok) return e;
    stage_ = y + h * (3.0 / 40 * k1_ + 9.0 / 40 * k2_);
    if (auto e = f.derivative(s.t + 0.3 * h, stage_, k3_); e != Status::ok) return e;
    stage_ = y + h * (44.0 / 45 * k1_ - 56.0 / 15 * k2_ + 32.0 / 9 * k3_);
    if (auto e = f.derivative(s.t + 0.8 * h, stage_, k4_); e != Status::ok) return e;
    stage_ = y + h * (19372.0 / 6561 * k1_ - 25360.0 / 2187 * k2_ + 64448.0 / 6561 * k3_ - 212.0 / 729 * k4_);
    if (auto e = f.derivative(s.t + 8.0 / 9 * h, stage_, k5_); e != Status::ok) return e;
    stage_ = y + h * (9017.0 / 3168 * k1_ - 355.0 / 33 * k2_ + 46732.0 / 5247 * k3_ + 49.0 / 176 * k4_ -
                      5103.0 / 18656 * k5_);
    if (auto e = f.derivative(s.end, stage_, k6_); e != Status::ok) return e;
    y_new = y + h * (35.0 / 384 * k1_ + 500.0 / 1113 * k3_ + 125.0 / 192 * k4_ - 2187.0 / 6784 * k5_ + 11.0 / 84 * k6_);
    if (auto e = f.derivative(s.end, y_new, k7_); e != Status::ok) return e;
    error_ = h * (71.0 / 57600 * k1_ - 71.0 / 16695 * k3_ + 71.0 / 1920 * k4_ - 17253.0 / 339200 * k5_ +
                  22.0 / 525 * k6_ - 1.0 / 40 * k7_)
                     .head(states_);
    has_end_slope_ = true;
    return Status::ok;
  }

  /// y(t + theta h) of the last attempted step.
  void interpolate(double theta, double h, Vector const& y, Vector const& y_new, Vector& out) {
    if (!std::exchange(has_polynomial_, true)) {
      bend_ = h * k1_ - (y_new - y);
      quartic_ = h * (-12715105075.0 / 11282082432 * k1_ + 87487479700.0 / 32700410799 * k3_ -
                      10690763975.0 / 1880347072 * k4_ + 701980252875.0 / 199316789632 * k5_ -
                      1453857185.0 / 822651844 * k6_ + 69997945.0 / 29380423 * k7_);
    }
    double const rest = 1 - theta;
    double const w = theta * rest;
    // y + theta (dy + rest (bend + theta (dy - h k7 - bend + rest quartic)))
    out = y + theta * (y_new - y) + w * bend_ + (w * theta) * (y_new - y - h * k7_ - bend_) + (w * w) * quartic_;
  }

 private:
  int states_;
  Vector k1_, k2_, k3_, k4_, k5_, k6_, k7_, stage_, error_, bend_, quartic_;
  bool has_end_slope_ = false;
  bool has_polynomial_ = false;
};

}  // namespace rollerrig::integrate
