// integrate/runge_kutta_4.hpp - the classical Runge-Kutta method, order 4, for fixed steps.
//
// Dense output: the cubic Hermite polynomial through both ends and their slopes, order 3 (local
// error h^4).  The slope at the end is the next step's first stage, so it costs nothing.
// Source  Kutta (1901); Hairer, Norsett, Wanner, Solving ODEs I (1993), II.1 table 1.2 and II.6 (6.7).
#pragma once
#include <utility>

#include "rollerrig/integrate/evaluator.hpp"

namespace rollerrig::integrate {

class RungeKutta4 {
 public:
  static constexpr int order = 4;
  static constexpr int error_order = 4;  // no estimate: fixed steps only
  static constexpr bool implicit = false;

  template <class System>
  explicit RungeKutta4(Evaluator<System> const& f) {
    auto const size = f.sizes().states + f.sizes().quadratures;
    for (Vector* v : {&k1_, &k2_, &k3_, &k4_, &k_end_, &stage_}) v->setZero(size);
    error_.setZero(f.sizes().states);
  }

  void restart() { has_end_slope_ = false; }

  /// Once before each new step (not before its repetitions).
  template <class System>
  Status prepare(Evaluator<System>& f, double t, Vector const& y) {
    if (std::exchange(has_end_slope_, false)) {
      k1_.swap(k_end_);
      return Status::ok;
    }
    return f.derivative(t, y, k1_);
  }

  Vector const& slope() const { return k1_; }
  /// Zero: the method has no estimate, and the constructor of Integrator asks for a fixed step.
  Vector const& error() const { return error_; }

  template <class System>
  Status attempt(Evaluator<System>& f, Step const& s, Vector const& y, Vector& y_new) {
    double const middle = s.t + 0.5 * s.h;
    stage_ = y + (0.5 * s.h) * k1_;
    if (auto e = f.derivative(middle, stage_, k2_); e != Status::ok) return e;
    stage_ = y + (0.5 * s.h) * k2_;
    if (auto e = f.derivative(middle, stage_, k3_); e != Status::ok) return e;
    stage_ = y + s.h * k3_;
    if (auto e = f.derivative(s.end, stage_, k4_); e != Status::ok) return e;
    y_new = y + (s.h / 6) * (k1_ + 2 * k2_ + 2 * k3_ + k4_);
    if (auto e = f.derivative(s.end, y_new, k_end_); e != Status::ok) return e;
    has_end_slope_ = true;
    return Status::ok;
  }

  /// y(t + theta h) of the last attempted step; HNW I (6.7).
  void interpolate(double theta, double h, Vector const& y, Vector const& y_new, Vector& out) {
    double const rest = 1 - theta;
    out = rest * y + theta * y_new -
          (theta * rest) * ((1 - 2 * theta) * (y_new - y) - (rest * h) * k1_ + (theta * h) * k_end_);
  }

  /// Everything that changes in a run, for plant/state_archive.hpp.
  void state(auto& archive) { archive(k1_, k2_, k3_, k4_, k_end_, stage_, error_, has_end_slope_); }

 private:
  Vector k1_, k2_, k3_, k4_, k_end_, stage_, error_;
  bool has_end_slope_ = false;
};

}  // namespace rollerrig::integrate
