// integrate/shifted_solver.hpp - (s I - J) k = r for the Jacobian J of states and quadratures.
//
//         [ kinematic states q  ]   0     S     0        S selects the velocity of each q
//     J = [ other states     v  ]   A_vq  A_vv  0
//         [ quadratures      z  ]   G_q   G_v   0
//
// Only a matrix of the size of v is factored: q and z are eliminated exactly,
//
//     (s I - A_vv - A_vq S / s) k_v = r_v + A_vq r_q / s
//     k_q = (r_q + S k_v) / s,      k_z = (r_z + G (k_q, k_v)) / s.
//
// A system without kinematic states is the case of an empty q.
// Source  block elimination; Hairer, Wanner, Solving ODEs II (1996), IV.8 "second order equations".
#pragma once
#include <Eigen/Core>
#include <cassert>
#include <utility>
#include <vector>

#include "rollerrig/integrate/differential_equation.hpp"
#include "rollerrig/math/lu.hpp"

namespace rollerrig::integrate {

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

}  // namespace rollerrig::integrate
