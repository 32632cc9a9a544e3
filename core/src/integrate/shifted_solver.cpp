#include "rollerrig/integrate/shifted_solver.hpp"

namespace rollerrig::integrate {

void ShiftedSolver::factor(JacobianData const& j, double shift) {
  j_ = &j;
  inverse_shift_ = 1 / shift;
  matrix_ = -j.a.bottomRightCorner(v_, v_);
  matrix_.diagonal().array() += shift;
  for (int i = 0; i < q_; ++i) matrix_.col(columns_[i] - q_) -= inverse_shift_ * j.a.col(i).tail(v_);
  lu_.compute(matrix_);
}

void ShiftedSolver::solve(Eigen::VectorXd& r) {
  right_ = r.segment(q_, v_);
  if (q_ > 0) right_.noalias() += inverse_shift_ * (j_->a.bottomLeftCorner(v_, q_) * r.head(q_));
  r.segment(q_, v_) = lu_.solve(right_);
  for (int i = 0; i < q_; ++i) r[i] = inverse_shift_ * (r[i] + r[columns_[i]]);
  if (z_ > 0) {
    r.tail(z_).noalias() += j_->g * r.head(q_ + v_);
    r.tail(z_) *= inverse_shift_;
  }
}

}  // namespace rollerrig::integrate
