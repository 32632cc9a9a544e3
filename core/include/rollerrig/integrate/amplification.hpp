// integrate/amplification.hpp - what one step of a method does to a small deviation.
//
//   A = df/dx -> [one step per unit vector, by the method itself] -> G with dx_new = G dx
//
// Eigenvalues of G outside the unit circle that belong to no growing motion of x' = A x are the method's own: the step is
// too long. For a Runge-Kutta method G = R(h A); an exponential method has no such function, so the method is run.
#pragma once
#include <algorithm>

#include "rollerrig/integrate/exponential_runge_kutta_4.hpp"

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
inline Eigen::MatrixXd amplification(LinearSystem system, Method method, double step) {
  need(method == Method::rk4 || method == Method::exponential_rk4, "method must be rk4 or exponential_rk4");
  need(step > 0 && std::isfinite(step), "step must be positive and finite");
  Evaluator f(system);
  ExponentialRungeKutta4 one(f, method == Method::exponential_rk4);
  auto const n = system.a.rows();
  Eigen::MatrixXd g(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    Vector const unit = Vector::Unit(n + system.quadratures, i);
    Vector end = unit;
    one.restart();
    one.prepare(f, 0.0, unit);
    one.attempt(f, {0.0, step, step}, unit, end);
    g.col(i) = end.head(n);
  }
  return g;
}

}  // namespace rollerrig::integrate
