#include "rollerrig/integrate/matrix_phi_functions.hpp"

#include <algorithm>
#include <cmath>

#include "rollerrig/integrate/amplification.hpp"
#include "rollerrig/integrate/exponential_runge_kutta_4.hpp"
#include "rollerrig/integrate/rodas4.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig::integrate {

void MatrixPhiFunctions::compute(JacobianData const& j, double h, std::vector<StepWeights>& weights) {
  units_.head(kinematic_).setConstant(h);
  for (Eigen::Index i = 0; i < j.g.rows(); ++i) {
    double const most = h * (j.g.row(i) * units_.head(states_).asDiagonal()).cwiseAbs().sum();
    units_[states_ + i] = std::max(1.0, most);
  }
  scaled_.setZero();
  scaled_.topLeftCorner(states_, states_) = h * j.a;
  scaled_.bottomLeftCorner(j.g.rows(), states_) = h * j.g;
  scaled_ = units_.cwiseInverse().asDiagonal() * scaled_ * units_.asDiagonal();
  double const size = scaled_.cwiseAbs().colwise().sum().maxCoeff();
  auto const wanted = static_cast<int>(weights.size()) - 1;
  int const halvings = std::max(wanted, static_cast<int>(std::ceil(std::log2(std::max(size, 1.0)))));
  scaled_ *= std::exp2(-halvings);
  series();
  for (int k = halvings; k >= 0; --k) {
    if (k < static_cast<int>(weights.size())) store(weights[at(k)]);
    if (k > 0) double_step();
  }
}

void MatrixPhiFunctions::series() {
  auto const n = scaled_.rows();
  auto& last = phi_[highest];
  double inverse = 1.0;  // 1 / (k + 4)! of the term k
  for (int k = 2; k < series_terms + highest; ++k) inverse /= k;
  last = inverse * Eigen::MatrixXd::Identity(n, n);
  for (int k = series_terms - 1; k > 0; --k) {
    inverse *= k + highest;
    product_.noalias() = scaled_ * last;
    last = product_;
    last.diagonal().array() += inverse;
  }
  double factorial = 6.0;
  for (int k = highest - 1; k >= 0; --k) {
    phi_[at(k)].noalias() = scaled_ * phi_[at(k) + 1];
    phi_[at(k)].diagonal().array() += 1.0 / factorial;
    factorial /= std::max(1, k);
  }
}

void MatrixPhiFunctions::double_step() {
  for (int k = highest; k >= 0; --k) {
    product_.noalias() = phi_[0] * phi_[at(k)];
    double factorial = 1.0;
    for (int j = k; j >= 1; --j) {
      product_ += (1.0 / factorial) * phi_[at(j)];
      factorial *= k - j + 1;
    }
    sum_ = std::exp2(-k) * product_;
    phi_[at(k)].swap(sum_);
  }
}

void MatrixPhiFunctions::store(StepWeights& w) {
  auto const put = [this](auto const& phi, Eigen::MatrixXd& out) {
    out = (units_.asDiagonal() * phi * units_.cwiseInverse().asDiagonal()).rightCols(out.cols());
  };
  put(phi_[1], w.slope);
  put(phi_[2], w.difference[0]);
  put(phi_[3] + 0.5 * phi_[2], w.difference[1]);
  put(phi_[4] + phi_[3] + (1.0 / 3.0) * phi_[2], w.difference[2]);
}

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

Eigen::MatrixXd amplification(LinearSystem system, Method method, double step) {
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
