// math/least_norm.hpp - the smallest vector that solves a linear system as well as it can be solved.
//
// One compiled copy: Eigen's decomposition takes longer to compile than to write down.
#pragma once
#include <Eigen/Core>
#include <memory>

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
