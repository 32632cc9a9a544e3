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
#include <cassert>
#include <utility>
#include <vector>

#include "rollerrig/integrate/differential_equation.hpp"
#include "rollerrig/math/lu.hpp"

namespace rollerrig::integrate::rodas4_tableau {

/// The numbers of RODAS, set METH = 1 of Hairer and Wanner's code.
///
/// They hold in the variables u of HW II, IV.7 (7.25).  A test proves with them, to round-off, the order
/// conditions of order 4 (also those of index-1 algebraic equations: no order is lost in the stiff limit),
/// of the embedded solution and of the dense output (order 3 each).  Indices start at 0.
/// Source  Hairer, Wanner, Solving ODEs II (1996), VI.4 (4.15)-(4.22) and their code RODAS of 28 October 1996.
inline constexpr int stages = 6;

/// Diagonal of the method: 1/(h gamma) is the shift of every linear solve.
inline constexpr double gamma = 0.25;

/// Times of the stages, in steps.
inline constexpr double alpha[stages] = {0, 0.386, 0.21, 0.63, 1, 1};

/// Weight of h df/dt in each stage.
inline constexpr double time_weight[stages] = {0.25, -0.1043, 0.1035, -0.03620000000000023, 0, 0};

/// Argument of stage i: y + sum_j a[i][j] u_j.  Row 5, the embedded solution, is row 4 plus u_4.
inline constexpr double a[stages][5] = {
    {},
    {1.544},
    {0.9466785280815826, 0.2557011698983284},
    {3.314825187068521, 2.896124015972201, 0.9986419139977817},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1},
};

/// Right-hand side of stage i: + sum_j c[i][j] u_j / h.
inline constexpr double c[stages][5] = {
    {},
    {-5.6688},
    {-2.430093356833875, -0.2063599157091915},
    {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
    {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
    {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054},
};

/// Dense output: y (1-s) + s (y_new + (1-s) (sum_j bend[j] u_j + s sum_j cubic[j] u_j)).
inline constexpr double bend[5] = {10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823,
                                   1.025137723295662};
inline constexpr double cubic[5] = {-0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386,
                                    -6.594389125716872};

}  // namespace rollerrig::integrate::rodas4_tableau

namespace rollerrig::integrate {

/// (s I - J) k = r for the Jacobian J of states and quadratures.
///
///         [ kinematic states q  ]   0     S     0        S selects the velocity of each q
///     J = [ other states     v  ]   A_vq  A_vv  0
///         [ quadratures      z  ]   G_q   G_v   0
///
/// Only a matrix of the size of v is factored: q and z are eliminated exactly,
///
///     (s I - A_vv - A_vq S / s) k_v = r_v + A_vq r_q / s
///     k_q = (r_q + S k_v) / s,      k_z = (r_z + G (k_q, k_v)) / s.
///
/// A system without kinematic states is the case of an empty q.
/// Source  block elimination; Hairer, Wanner, Solving ODEs II (1996), IV.8 "second order equations".
class ShiftedSolver {
 public:
  /// @param velocity_columns  for each kinematic state the index of its velocity in x
  ShiftedSolver(Sizes sizes, std::vector<int> velocity_columns)
      : columns_{std::move(velocity_columns)},
        q_{static_cast<int>(columns_.size())},
        v_{sizes.states - q_},
        z_{sizes.quadratures},
        matrix_(v_, v_),
        right_(v_),
        lu_(v_) {
    for ([[maybe_unused]] int c : columns_) assert(c >= q_ && c < sizes.states);
  }

  /// Factor for shift s [1/s]; J must stay alive and unchanged until the last solve.
  void factor(JacobianData const& j, double shift);

  /// r -> k in place, r = (r_q, r_v, r_z).
  void solve(Eigen::VectorXd& r);

 private:
  std::vector<int> columns_;
  int q_, v_, z_;
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd right_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  JacobianData const* j_ = nullptr;
  double inverse_shift_ = 0;  // [s]
};

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

  void state(auto& archive) { archive(jacobian_, u_, f0_, f_t_, stage_, error_, bend_, cubic_, has_polynomial_); }

 private:
  template <class System>
  static std::vector<int> velocity_columns(System const& system) {
    std::vector<int> columns;
    for (int i = 0; i < system.kinematic_states(); ++i) columns.push_back(system.velocity_column(i));
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
