// integrate/rodas4.hpp - the Rosenbrock method RODAS, order 4(3), 6 stages, L-stable, stiffly
// accurate: one exact Jacobian and one factorisation per step, no iteration.
//
// Each stage solves, with gamma = 1/4 (Hairer, Wanner II, IV.7 (7.25), in the variables u_i):
//
//     (I / (h gamma) - J) u_i = f(t + c_i h, y + sum_j a_ij u_j) + sum_j (C_ij / h) u_j + d_i h f_t
//
// Dense output of order 3 (local error h^4) from the same stages.
// Source  Hairer, Wanner, Solving ODEs II (1996), IV.7 and VI.4 (4.15-4.22); digits of the set METH = 1
//         of their code RODAS (28 October 1996).
#pragma once
#include <utility>
#include <vector>

#include "rig/integrate/evaluator.hpp"
#include "rig/integrate/shifted_solver.hpp"

namespace rig::integrate {

class Rodas4 {
 public:
  static constexpr int order = 4;
  static constexpr int error_order = 4;  // the embedded solution is of order 3
  static constexpr bool implicit = true;
  static constexpr bool has_error_estimate = true;

  template <class System>
  explicit Rodas4(Evaluator<System> const& f)
      : states_{f.sizes().states}, jacobian_(f.sizes()), solver_(f.sizes(), velocity_columns(f.system())) {
    auto const size = f.sizes().states + f.sizes().quadratures;
    for (Vector* v : {&f0_, &f_t_, &u1_, &u2_, &u3_, &u4_, &u5_, &u6_, &stage_, &bend_, &cubic_}) v->setZero(size);
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
    double const t = s.t;
    double const h = s.h;
    double const r = 1 / h;
    has_polynomial_ = false;
    ++f.statistics.factorisations;
    solver_.factor(jacobian_, 1 / (gamma * h));

    u1_ = f0_ + (h * d1) * f_t_;
    solver_.solve(u1_);

    stage_ = y + a21 * u1_;
    if (auto e = f.derivative(t + c2 * h, stage_, u2_); e != Status::ok) return e;
    u2_ += (r * c21) * u1_ + (h * d2) * f_t_;
    solver_.solve(u2_);

    stage_ = y + a31 * u1_ + a32 * u2_;
    if (auto e = f.derivative(t + c3 * h, stage_, u3_); e != Status::ok) return e;
    u3_ += (r * c31) * u1_ + (r * c32) * u2_ + (h * d3) * f_t_;
    solver_.solve(u3_);

    stage_ = y + a41 * u1_ + a42 * u2_ + a43 * u3_;
    if (auto e = f.derivative(t + c4 * h, stage_, u4_); e != Status::ok) return e;
    u4_ += (r * c41) * u1_ + (r * c42) * u2_ + (r * c43) * u3_ + (h * d4) * f_t_;
    solver_.solve(u4_);

    stage_ = y + a51 * u1_ + a52 * u2_ + a53 * u3_ + a54 * u4_;
    if (auto e = f.derivative(s.end, stage_, u5_); e != Status::ok) return e;
    u5_ += (r * c51) * u1_ + (r * c52) * u2_ + (r * c53) * u3_ + (r * c54) * u4_;
    solver_.solve(u5_);

    stage_ += u5_;  // the embedded solution, order 3
    if (auto e = f.derivative(s.end, stage_, u6_); e != Status::ok) return e;
    u6_ += (r * c61) * u1_ + (r * c62) * u2_ + (r * c63) * u3_ + (r * c64) * u4_ + (r * c65) * u5_;
    solver_.solve(u6_);

    y_new = stage_ + u6_;
    error_ = u6_.head(states_);
    return Status::ok;
  }

  /// y(t + theta h) of the last attempted step; HW II, VI.4 (4.22) in the form of Hairer's CONTRO.
  void interpolate(double theta, double, Vector const& y, Vector const& y_new, Vector& out) {
    if (!has_polynomial_) {
      bend_ = d21 * u1_ + d22 * u2_ + d23 * u3_ + d24 * u4_ + d25 * u5_;
      cubic_ = d31 * u1_ + d32 * u2_ + d33 * u3_ + d34 * u4_ + d35 * u5_;
      has_polynomial_ = true;
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

  static constexpr double gamma = 0.25;
  static constexpr double c2 = 0.386, c3 = 0.21, c4 = 0.63;
  static constexpr double d1 = 0.25, d2 = -0.1043, d3 = 0.1035, d4 = -0.03620000000000023;
  static constexpr double a21 = 1.544;
  static constexpr double a31 = 0.9466785280815826, a32 = 0.2557011698983284;
  static constexpr double a41 = 3.314825187068521, a42 = 2.896124015972201, a43 = 0.9986419139977817;
  static constexpr double a51 = 1.221224509226641, a52 = 6.019134481288629, a53 = 12.53708332932087,
                          a54 = -0.6878860361058950;
  static constexpr double c21 = -5.6688;
  static constexpr double c31 = -2.430093356833875, c32 = -0.2063599157091915;
  static constexpr double c41 = -0.1073529058151375, c42 = -9.594562251023355, c43 = -20.47028614809616;
  static constexpr double c51 = 7.496443313967647, c52 = -10.24680431464352, c53 = -33.99990352819905,
                          c54 = 11.70890893206160;
  static constexpr double c61 = 8.083246795921522, c62 = -7.981132988064893, c63 = -31.52159432874371,
                          c64 = 16.31930543123136, c65 = -6.058818238834054;
  static constexpr double d21 = 10.12623508344586, d22 = -7.487995877610167, d23 = -34.80091861555747,
                          d24 = -7.992771707568823, d25 = 1.025137723295662;
  static constexpr double d31 = -0.6762803392801253, d32 = 6.087714651680015, d33 = 16.43084320892478,
                          d34 = 24.76722511418386, d35 = -6.594389125716872;

  int states_;
  JacobianData jacobian_;
  ShiftedSolver solver_;
  Vector f0_, f_t_, u1_, u2_, u3_, u4_, u5_, u6_, stage_, error_, bend_, cubic_;
  bool has_polynomial_ = false;
};

}  // namespace rig::integrate
