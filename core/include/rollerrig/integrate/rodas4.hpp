// integrate/rodas4.hpp - the Rosenbrock method RODAS, order 4(3), 6 stages, L-stable, stiffly accurate: one
// exact Jacobian and one factorisation per step, no iteration.
//
// Each stage solves, with gamma = 1/4 (HW II, IV.7 (7.25)),
//
//     (I / (h gamma) - J) u_i = f(t + alpha_i h, y + sum_j a_ij u_j) + sum_j c_ij u_j / h + w_i h df/dt
//
// Dense output of order 3 (local error h^4 where the solution is smooth and the step resolves the stiff modes).
// Source  Hairer, Wanner, Solving ODEs II (1996), IV.7 and VI.4.
#pragma once
#include <utility>
#include <vector>

#include "rollerrig/integrate/evaluator.hpp"
#include "rollerrig/integrate/rodas4_tableau.hpp"
#include "rollerrig/integrate/shifted_solver.hpp"

namespace rollerrig::integrate {

class Rodas4 {
 public:
  static constexpr int order = 4;
  static constexpr int error_order = 4;  // the embedded solution is of order 3
  static constexpr bool implicit = true;

  template <class System>
  explicit Rodas4(Evaluator<System> const& f)
      : states_{f.sizes().states}, jacobian_(f.sizes()), solver_(f.sizes(), velocity_columns(f.system())) {
    auto const size = f.sizes().states + f.sizes().quadratures;
    for (Vector* v : {&f0_, &f_t_, &stage_, &bend_, &cubic_}) v->setZero(size);
    for (Vector& u : u_) u.setZero(size);
    error_.setZero(states_);
  }

  void restart() {}

  /// Once before each new step (not before its repetitions): f and J at its start.
  template <class System>
  Status prepare(Evaluator<System>& f, double t, Vector const& y) {
    if (auto e = f.derivative(t, y, f0_); e != Status::ok) return e;
    if (auto e = f.jacobian(t, y, jacobian_); e != Status::ok) return e;
    f_t_.head(states_) = jacobian_.f_t;
    f_t_.tail(f_t_.size() - states_) = jacobian_.g_t;
    return Status::ok;
  }

  Vector const& slope() const { return f0_; }

  /// The last stage, states only: the difference to the embedded solution.
  Vector const& error() const { return error_; }

  template <class System>
  Status attempt(Evaluator<System>& f, Step const& s, Vector const& y, Vector& y_new) {
    using namespace rodas4_tableau;
    double const t = s.t;
    double const h = s.h;
    double const r = 1 / h;
    auto& u = u_;
    has_polynomial_ = false;
    ++f.statistics.factorisations;
    solver_.factor(jacobian_, 1 / (gamma * h));

    for (int i = 0; i < stages; ++i) {
      if (i == 0) {
        u[0] = f0_;
      } else {
        if (i + 1 < stages) {
          stage_ = y;
          for (int j = 0; j < i; ++j) stage_ += a[i][j] * u[j];
        } else {
          stage_ += u[i - 1];  // row 5 is row 4 and u_4: the embedded solution
        }
        double const time = alpha[i] == 1.0 ? s.end : t + alpha[i] * h;
        if (auto e = f.derivative(time, stage_, u[i]); e != Status::ok) return e;
        for (int j = 0; j < i; ++j) u[i] += (r * c[i][j]) * u[j];
      }
      if (time_weight[i] != 0.0) u[i] += (h * time_weight[i]) * f_t_;
      solver_.solve(u[i]);
    }
    y_new = stage_ + u[5];
    error_ = u[5].head(states_);
    return Status::ok;
  }

  /// y(t + theta h) of the last attempted step; HW II, VI.4 (4.22).
  void interpolate(double theta, double, Vector const& y, Vector const& y_new, Vector& out) {
    if (!std::exchange(has_polynomial_, true)) {
      using namespace rodas4_tableau;
      bend_ = bend[0] * u_[0];
      cubic_ = cubic[0] * u_[0];
      for (int j = 1; j + 1 < stages; ++j) bend_ += bend[j] * u_[j], cubic_ += cubic[j] * u_[j];
    }
    double const rest = 1 - theta;
    out = rest * y + theta * y_new + (theta * rest) * (bend_ + theta * cubic_);
  }

  /// Everything that changes in a run, for plant/state_archive.hpp.
  void state(auto& archive) { archive(jacobian_, u_, f0_, f_t_, stage_, error_, bend_, cubic_, has_polynomial_); }

 private:
  template <class System>
  static std::vector<int> velocity_columns(System const& system) {
    std::vector<int> columns;
    if constexpr (HasKinematicStates<System>) {
      for (int i = 0; i < system.kinematic_states(); ++i) columns.push_back(system.velocity_column(i));
    }
    return columns;
  }

  int states_;
  JacobianData jacobian_;
  ShiftedSolver solver_;
  Vector u_[rodas4_tableau::stages];
  Vector f0_, f_t_, stage_, error_, bend_, cubic_;
  bool has_polynomial_ = false;
};

}  // namespace rollerrig::integrate
