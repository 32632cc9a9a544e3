// integrate/exponential_runge_kutta_4.hpp - the exponential Runge-Kutta method of Krogstad, order 4, for fixed steps.
//
//     x' = f(t, x);   for the relaxing states   x_i' = N_i(t, x) - lambda_i x_i,   lambda_i constant
//
// The decay is integrated exactly, N by the classical method: a damper's inner node between a stiff spring and its
// dashpot limits the step no more. Every other state is a relaxing one with lambda = 0, for which the method is the
// classical Runge-Kutta method to the last bit; it is written as that, and the relaxing states are put in place after.
//
// With z = -lambda h and  phi_1 = (e^z - 1)/z,  phi_2 = (phi_1 - 1)/z,  phi_3 = (phi_2 - 1/2)/z:
//
//     a = e^(z/2) x + h/2 phi_1(z/2) N(x)
//     b = e^(z/2) x + h [(phi_1(z/2)/2 - phi_2(z/2)) N(x) + phi_2(z/2) N(a)]
//     c = e^z     x + h [(phi_1 - 2 phi_2) N(x) + 2 phi_2 N(b)]
//     x_new = e^z x + h [(phi_1 - 3 phi_2 + 4 phi_3) N(x) + (2 phi_2 - 4 phi_3)(N(a) + N(b)) + (4 phi_3 - phi_2) N(c)]
//
// Dense output: the cubic Hermite polynomial of order 3 as in the classical method; for the relaxing states the same
// formula as for x_new with theta h in place of h, so that no decay is ever faster than what is shown.
// Source  Krogstad, Generalized integrating factor methods for stiff PDEs, J. Comput. Phys. 203 (2005); Cox, Matthews,
//         Exponential time differencing for stiff systems, J. Comput. Phys. 176 (2002); Hochbruck, Ostermann,
//         Exponential integrators, Acta Numerica 19 (2010).
#pragma once
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "rig/integrate/evaluator.hpp"

namespace rig::integrate {

/// phi_1, phi_2 and phi_3 at z <= 0, and e^z.
struct PhiFunctions {
  double exponential, phi1, phi2, phi3;

  explicit PhiFunctions(double z) : exponential{std::exp(z)} {
    if (z < -1.0) {  // the recursion loses nothing here
      phi1 = (exponential - 1.0) / z;
      phi2 = (phi1 - 1.0) / z;
      phi3 = (phi2 - 0.5) / z;
      return;
    }
    double sum = 0.0;  // phi_3 = sum of z^k / (k + 3)!
    double term = 1.0 / 6.0;
    for (int k = 1; k <= 18; ++k) {
      sum += term;
      term *= z / (k + 3);
    }
    phi3 = sum;
    phi2 = 0.5 + z * phi3;
    phi1 = 1.0 + z * phi2;
  }
};

class ExponentialRungeKutta4 {
 public:
  static constexpr int order = 4;
  static constexpr int error_order = 4;  // no estimate: fixed steps only
  static constexpr bool implicit = false;

  template <class System>
  explicit ExponentialRungeKutta4(Evaluator<System> const& f) {
    if constexpr (HasRelaxation<System>) {
      first_ = f.system().first_relaxing_state();
      rates_ = f.system().relaxation_rates();
    }
    auto const size = f.sizes().states + f.sizes().quadratures;
    for (Vector* v : {&k1_, &k2_, &k3_, &k4_, &k_end_, &stage_}) v->setZero(size);
    error_.setZero(f.sizes().states);
    for (Vector* v : {&n1_, &n2_, &n3_, &n4_}) v->setZero(count());
    weights_.resize(rates_.size());
  }

  void restart() { has_end_slope_ = false; }

  /// Once before each new step (not before its repetitions).
  template <class System>
  Status prepare(Evaluator<System>& f, double t, Vector const& y) {
    if (std::exchange(has_end_slope_, false)) {
      k1_.swap(k_end_);
      return Status::ok;
    }
    return f.derivative(t, y, k1_);
  }

  Vector const& slope() const { return k1_; }
  /// Zero: the method has no estimate, and the constructor of Integrator asks for a fixed step.
  Vector const& error() const { return error_; }

  template <class System>
  Status attempt(Evaluator<System>& f, Step const& s, Vector const& y, Vector& y_new) {
    double const h = s.h;
    double const middle = s.t + 0.5 * h;
    prepare_weights(h);
    driving(y, k1_, n1_);
    stage_ = y + (0.5 * h) * k1_;
    relax(y, stage_, [&](Weights const& w, auto i) { return w.half * n1_[i]; }, &Weights::decay_half);
    if (auto e = f.derivative(middle, stage_, k2_); e != Status::ok) return e;
    driving(stage_, k2_, n2_);
    stage_ = y + (0.5 * h) * k2_;
    relax(y, stage_, [&](Weights const& w, auto i) { return w.b1 * n1_[i] + w.b2 * n2_[i]; }, &Weights::decay_half);
    if (auto e = f.derivative(middle, stage_, k3_); e != Status::ok) return e;
    driving(stage_, k3_, n3_);
    stage_ = y + h * k3_;
    relax(y, stage_, [&](Weights const& w, auto i) { return w.c1 * n1_[i] + w.c3 * n3_[i]; }, &Weights::decay);
    if (auto e = f.derivative(s.end, stage_, k4_); e != Status::ok) return e;
    driving(stage_, k4_, n4_);
    y_new = y + (h / 6) * (k1_ + 2 * k2_ + 2 * k3_ + k4_);
    auto const end = [&](Weights const& w, auto i) { return w.d1 * n1_[i] + w.d2 * (n2_[i] + n3_[i]) + w.d4 * n4_[i]; };
    relax(y, y_new, end, &Weights::decay);
    if (auto e = f.derivative(s.end, y_new, k_end_); e != Status::ok) return e;
    has_end_slope_ = true;
    return Status::ok;
  }

  /// y(t + theta h) of the last attempted step; HNW I (6.7) for the states that do not relax.
  void interpolate(double theta, double h, Vector const& y, Vector const& y_new, Vector& out) const {
    double const rest = 1 - theta;
    out = rest * y + theta * y_new -
          (theta * rest) * ((1 - 2 * theta) * (y_new - y) - (rest * h) * k1_ + (theta * h) * k_end_);
    for (Eigen::Index i = 0; i < count(); ++i) {
      // N as a parabola in time through its values at both ends and the mean of those at the middle.
      double const middle = 0.5 * (n2_[i] + n3_[i]);
      double const linear = -3.0 * n1_[i] + 4.0 * middle - n4_[i];
      double const square = 2.0 * n1_[i] - 4.0 * middle + 2.0 * n4_[i];
      PhiFunctions const p(-rates_[static_cast<std::size_t>(i)] * theta * h);
      out[first_ + i] = p.exponential * y[first_ + i] +
                        h * theta * (p.phi1 * n1_[i] + theta * (p.phi2 * linear + 2.0 * theta * p.phi3 * square));
    }
  }

 private:
  /// What multiplies N of each stage, step included [s].
  struct Weights {
    double decay_half, decay;
    double half, b1, b2, c1, c3, d1, d2, d4;
  };

  Eigen::Index count() const { return static_cast<Eigen::Index>(rates_.size()); }

  void prepare_weights(double h) {
    if (h == weights_step_) return;
    weights_step_ = h;
    for (std::size_t i = 0; i < rates_.size(); ++i) {
      PhiFunctions const p(-0.5 * rates_[i] * h), q(-rates_[i] * h);
      weights_[i] = {p.exponential,
                     q.exponential,
                     0.5 * h * p.phi1,
                     h * (0.5 * p.phi1 - p.phi2),
                     h * p.phi2,
                     h * (q.phi1 - 2.0 * q.phi2),
                     h * 2.0 * q.phi2,
                     h * (q.phi1 - 3.0 * q.phi2 + 4.0 * q.phi3),
                     h * (2.0 * q.phi2 - 4.0 * q.phi3),
                     h * (4.0 * q.phi3 - q.phi2)};
    }
  }

  /// N = x' + lambda x of the relaxing states.
  void driving(Vector const& state, Vector const& slope, Vector& n) const {
    for (Eigen::Index i = 0; i < count(); ++i)
      n[i] = slope[first_ + i] + rates_[static_cast<std::size_t>(i)] * state[first_ + i];
  }

  template <class Sum>
  void relax(Vector const& y, Vector& stage, Sum const& sum, double Weights::* decay) const {
    for (Eigen::Index i = 0; i < count(); ++i) {
      Weights const& w = weights_[static_cast<std::size_t>(i)];
      stage[first_ + i] = w.*decay * y[first_ + i] + sum(w, i);
    }
  }

  int first_ = 0;
  std::span<double const> rates_;
  std::vector<Weights> weights_;
  double weights_step_ = -1.0;
  Vector k1_, k2_, k3_, k4_, k_end_, stage_, error_;
  Vector n1_, n2_, n3_, n4_;
  bool has_end_slope_ = false;
};

}  // namespace rig::integrate
