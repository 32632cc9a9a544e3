#include "rollerrig/math/least_norm.hpp"

#include <Eigen/QR>

namespace rollerrig {

LeastNorm least_norm(Eigen::MatrixXd const& A, Eigen::VectorXd const& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  if (threshold > 0.0) solver.setThreshold(threshold);
  solver.compute(A);
  return {solver.solve(b), solver.rank()};
}

}  // namespace rollerrig
