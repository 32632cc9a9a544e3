// math/least_norm.hpp - the smallest vector that solves a linear system as well as it can be solved.
//
// One compiled copy: Eigen's decomposition takes longer to compile than to write down.
#pragma once
#include <Eigen/Core>

namespace rollerrig {

struct LeastNorm {
  Eigen::VectorXd x;
  Eigen::Index rank{0};
};

/// min |x| over all x that minimise |A x - b|, by a complete orthogonal decomposition.
///
/// @param threshold  pivots below this over the largest count as zero; 0: as rounding asks
LeastNorm least_norm(Eigen::MatrixXd const& A, Eigen::VectorXd const& b, double threshold = 0.0);

}  // namespace rollerrig
