#include "rollerrig/math/lu.hpp"

template void Eigen::PartialPivLU<Eigen::MatrixXd>::compute();
