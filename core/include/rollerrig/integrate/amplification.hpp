// integrate/amplification.hpp - what one step of a method does to a small deviation.
//
//   A = df/dx -> [one step per unit vector, by the method itself] -> G with dx_new = G dx
//
// Eigenvalues of G outside the unit circle that belong to no growing motion of x' = A x are the method's own: the step is
// too long. For a Runge-Kutta method G = R(h A); an exponential method has no such function, so the method is run.
#pragma once
#include <algorithm>

#include "rollerrig/integrate/differential_equation.hpp"

namespace rollerrig::integrate {

/// x' = A x; the stiff modes are those of the system that A belongs to.
struct LinearSystem {
  Eigen::MatrixXd const& a;
  StiffModes modes{};
  int quadratures{0};  ///< that the modes reach; they stay as they are

  Sizes sizes() const { return {static_cast<int>(a.rows()), quadratures}; }
  StiffModes stiff_modes() const { return modes; }
  bool renew_stiff_modes(StiffModes const& now, StiffModes& next) const {
    if (now.size() == modes.size()) return false;
    next = modes;
    return true;
  }
  Status derivative(double, double const* x, double* x_dot, double* z_dot) const {
    if (z_dot != nullptr) std::fill_n(z_dot, quadratures, 0.0);
    Eigen::Map<Eigen::VectorXd>(x_dot, a.rows()).noalias() = a * Eigen::Map<Eigen::VectorXd const>(x, a.rows());
    return Status::ok;
  }
};

/// G of one step [s] of rk4 or exponential_rk4, (n, n).
Eigen::MatrixXd amplification(LinearSystem system, Method method, double step);

}  // namespace rollerrig::integrate
