#include "rollerrig/math/lu.hpp"

#include <Eigen/QR>

template void Eigen::PartialPivLU<Eigen::MatrixXd>::compute();

namespace rollerrig {

struct LeastNorm::Decomposition {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> of;
};

LeastNorm::LeastNorm(Eigen::MatrixXd const& A, double threshold) : decomposition_(std::make_unique<Decomposition>()) {
  if (threshold > 0.0) decomposition_->of.setThreshold(threshold);
  decomposition_->of.compute(A);
}

LeastNorm::~LeastNorm() = default;
LeastNorm::LeastNorm(LeastNorm&&) noexcept = default;
LeastNorm& LeastNorm::operator=(LeastNorm&&) noexcept = default;

Eigen::VectorXd LeastNorm::solve(Eigen::VectorXd const& b) const { return decomposition_->of.solve(b); }

Eigen::Index LeastNorm::rank() const { return decomposition_->of.rank(); }

}  // namespace rollerrig
