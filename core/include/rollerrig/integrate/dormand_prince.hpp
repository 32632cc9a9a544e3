// integrate/dormand_prince.hpp - the explicit pair of Dormand and Prince, order 5(4), 7 stages of
// which the last is the next step's first.
//
// Dense output of order 4 (local error h^5) from the same stages.
// Source  Dormand, Prince (1980); Hairer, Norsett, Wanner, Solving ODEs I (1993), II.5 table 5.2 and
//         II.6 (6.13); the form of the dense output is that of Hairer's DOPRI5.
#pragma once
#include <utility>

#include "rollerrig/integrate/differential_equation.hpp"

namespace rollerrig::integrate {

namespace dormand_prince_tableau {

inline constexpr int stages = 7;

/// Times of the stages, in steps.
inline constexpr double c[stages] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1};

/// Argument of stage i: y + h sum_j a[i][j] k_j. The last row is the solution.
inline constexpr double a[stages][6] = {
    {},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
};

/// Difference to the embedded solution: h sum_j error[j] k_j.
inline constexpr double error[stages] = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                         -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

/// Last term of the dense output: h sum_j quartic[j] k_j.
inline constexpr double quartic[stages] = {-12715105075.0 / 11282082432,  0,
                                           87487479700.0 / 32700410799,   -10690763975.0 / 1880347072,
                                           701980252875.0 / 199316789632, -1453857185.0 / 822651844,
                                           69997945.0 / 29380423};

}  // namespace dormand_prince_tableau

class DormandPrince {
 public:
  static constexpr int order = 5;
  static constexpr int error_order = 5;
  static constexpr bool implicit = false;

  template <class System>
  explicit DormandPrince(Evaluator<System> const& f) : states_{f.sizes().states} {
    auto const size = f.sizes().states + f.sizes().quadratures;
    for (Vector& k : k_) k.setZero(size);
    for (Vector* v : {&bend_, &quartic_}) v->setZero(size);
    error_.setZero(states_);
  }

  void restart() { has_end_slope_ = false; }

  /// Once before each new step (not before its repetitions).
  template <class System>
  Status prepare(Evaluator<System>& f, double t, Vector const& y) {
    if (std::exchange(has_end_slope_, false)) {
      k_[0].swap(k_[6]);
      return Status::ok;
    }
    return f.derivative(t, y, k_[0]);
  }

  Vector const& slope() const { return k_[0]; }

  /// Difference of the two solutions, states only.
  Vector const& error() const { return error_; }

  template <class System>
  Status attempt(Evaluator<System>& f, Step const& s, Vector const& y, Vector& y_new) {
    using namespace dormand_prince_tableau;
    double const h = s.h;
    has_polynomial_ = false;
    has_end_slope_ = false;
    for (int i = 1; i < stages; ++i) {
      y_new = y;
      add(a[i], i, h, y_new);
      double const time = c[i] == 1.0 ? s.end : s.t + c[i] * h;
      if (auto e = f.derivative(time, y_new, k_[i]); e != Status::ok) return e;
    }
    error_.setZero();
    for (int j = 0; j < stages; ++j) error_ += (h * dormand_prince_tableau::error[j]) * k_[j].head(states_);
    has_end_slope_ = true;
    return Status::ok;
  }

  /// y(t + theta h) of the last attempted step.
  void interpolate(double theta, double h, Vector const& y, Vector const& y_new, Vector& out) {
    if (!std::exchange(has_polynomial_, true)) {
      bend_ = h * k_[0] - (y_new - y);
      quartic_.setZero();
      add(dormand_prince_tableau::quartic, dormand_prince_tableau::stages, h, quartic_);
    }
    double const rest = 1 - theta;
    double const w = theta * rest;
    // y + theta (dy + rest (bend + theta (dy - h k7 - bend + rest quartic)))
    out = y + theta * (y_new - y) + w * bend_ + (w * theta) * (y_new - y - h * k_[6] - bend_) + (w * w) * quartic_;
  }

  void state(auto& archive) { archive(k_, error_, bend_, quartic_, has_end_slope_, has_polynomial_); }

 private:
  /// out += h sum_j weight[j] k_j.
  void add(double const* weight, int count, double h, Vector& out) const {
    for (int j = 0; j < count; ++j)
      if (weight[j] != 0.0) out += (h * weight[j]) * k_[j];
  }

  int states_;
  Vector k_[dormand_prince_tableau::stages];
  Vector error_, bend_, quartic_;
  bool has_end_slope_ = false;
  bool has_polynomial_ = false;
};

}  // namespace rollerrig::integrate
