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

    u[0] = f0_ + (h * time_weight[0]) * f_t_;
    solver_.solve(u[0]);

    stage_ = y + a[1][0] * u[0];
    if (auto e = f.derivative(t + alpha[1] * h, stage_, u[1]); e != Status::ok) return e;
    u[1] += (r * c[1][0]) * u[0] + (h * time_weight[1]) * f_t_;
    solver_.solve(u[1]);

    stage_ = y + a[2][0] * u[0] + a[2][1] * u[1];
    if (auto e = f.derivative(t + alpha[2] * h, stage_, u[2]); e != Status::ok) return e;
    u[2] += (r * c[2][0]) * u[0] + (r * c[2][1]) * u[1] + (h * time_weight[2]) * f_t_;
    solver_.solve(u[2]);

    stage_ = y + a[3][0] * u[0] + a[3][1] * u[1] + a[3][2] * u[2];
    if (auto e = f.derivative(t + alpha[3] * h, stage_, u[3]); e != Status::ok) return e;
    u[3] += (r * c[3][0]) * u[0] + (r * c[3][1]) * u[1] + (r * c[3][2]) * u[2] + (h * time_weight[3]) * f_t_;
    solver_.solve(u[3]);

    stage_ = y + a[4][0] * u[0] + a[4][1] * u[1] + a[4][2] * u[2] + a[4][3] * u[3];
    if (auto e = f.derivative(s.end, stage_, u[4]); e != Status::ok) return e;
    u[4] += (r * c[4][0]) * u[0] + (r * c[4][1]) * u[1] + (r * c[4][2]) * u[2] + (r * c[4][3]) * u[3];
    solver_.solve(u[4]);

    stage_ += u[4];  // the embedded solution
    if (auto e = f.derivative(s.end, stage_, u[5]); e != Status::ok) return e;
    u[5] += (r * c[5][0]) * u[0] + (r * c[5][1]) * u[1] + (r * c[5][2]) * u[2] + (r * c[5][3]) * u[3] +
            (r * c[5][4]) * u[4];
    solver_.solve(u[5]);

    y_new = stage_ + u[5];
    error_ = u[5].head(states_);
    return Status::ok;
  }

  /// y(t + theta h) of the last attempted step; HW II, VI.4 (4.22).
  void interpolate(double theta, double, Vector const& y, Vector const& y_new, Vector& out) {
    if (!std::exchange(has_polynomial_, true)) {
      using namespace rodas4_tableau;
      bend_ = bend[0] * u_[0] + bend[1] * u_[1] + bend[2] * u_[2] + bend[3] * u_[3] + bend[4] * u_[4];
      cubic_ = cubic[0] * u_[0] + cubic[1] * u_[1] + cubic[2] * u_[2] + cubic[3] * u_[3] + cubic[4] * u_[4];
    }
    double const rest = 1 - theta;
    out = rest * y + theta * y_new + (theta * rest) * (bend_ + theta * cubic_);
  }

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
