// math/lu.hpp - Eigen's LU decomposition with partial pivoting: one compiled copy of what takes longest to compile.
#pragma once
#include <Eigen/LU>

extern template void Eigen::PartialPivLU<Eigen::MatrixXd>::compute();
