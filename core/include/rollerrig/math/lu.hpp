// math/lu.hpp - solutions of linear systems: one compiled copy of Eigen's decompositions, which take longest to compile.
#pragma once
#include <Eigen/LU>
#include <memory>

extern template void Eigen::PartialPivLU<Eigen::MatrixXd>::compute();

namespace rollerrig {

/// min |x| over all x that minimise |A x - b|, by a complete orthogonal decomposition of A, for one b after the other.
class LeastNorm {
 public:
  /// @param threshold  pivots below this over the largest count as zero; 0: as rounding asks
  explicit LeastNorm(Eigen::MatrixXd const& A, double threshold = 0.0);
  ~LeastNorm();
  LeastNorm(LeastNorm&&) noexcept;
  LeastNorm& operator=(LeastNorm&&) noexcept;

  Eigen::VectorXd solve(Eigen::VectorXd const& b) const;
  Eigen::Index rank() const;

 private:
  struct Decomposition;
  std::unique_ptr<Decomposition> decomposition_;
};

}  // namespace rollerrig
