// integrate/exponential_runge_kutta_4.hpp - the exponential Runge-Kutta method of Krogstad, order 4, for fixed steps; without
// stiff modes the classical one.
//
//     x' = f(t, x);   along the stiff modes   s_i = d_i . x,   s_i' = N_i(t, x) - lambda_i s_i
//
// The decay is integrated exactly, N by the classical method: neither a damper's inner node between a stiff spring and its
// dashpot nor the creep of a slow wheel limits the step. Everything across these modes, and everything where lambda = 0,
// is the classical Runge-Kutta method to the last bit; it is written as that, and x is then moved along u_i to the s_i below.
//
// lambda is constant over a step. It is the system's guess at the step's start, and need not be exact: N takes up the rest. So
// that N is small where s follows something that runs away in time, s is counted from a start that runs along (`trend`).
//
// With z = -lambda h and  phi_1 = (e^z - 1)/z,  phi_2 = (phi_1 - 1)/z,  phi_3 = (phi_2 - 1/2)/z:
//
//     a = e^(z/2) s + h/2 phi_1(z/2) N(x)
//     b = e^(z/2) s + h [(phi_1(z/2)/2 - phi_2(z/2)) N(x) + phi_2(z/2) N(a)]
//     c = e^z     s + h [(phi_1 - 2 phi_2) N(x) + 2 phi_2 N(b)]
//     s_new = e^z s + h [(phi_1 - 3 phi_2 + 4 phi_3) N(x) + (2 phi_2 - 4 phi_3)(N(a) + N(b)) + (4 phi_3 - phi_2) N(c)]
//
// Dense output: the cubic Hermite polynomial through both ends and their slopes, order 3 (local error h^4); the slope at the
// end is the next step's first stage, so it costs nothing. Along the stiff modes it is the same formula as for s_new with
// theta h in place of h, so that no decay is ever faster than what is shown.
// Source  Kutta (1901); Hairer, Norsett, Wanner, Solving ODEs I (1993), II.1 table 1.2 and II.6 (6.7); Krogstad,
//         Generalized integrating factor methods for stiff PDEs, J. Comput. Phys. 203 (2005); Cox, Matthews, Exponential time
//         differencing for stiff systems, J. Comput. Phys. 176 (2002); Hochbruck, Ostermann, Exponential integrators,
//         Acta Numerica 19 (2010).
#pragma once
#include <cmath>
#include <utility>
#include <vector>

#include "rollerrig/integrate/differential_equation.hpp"

namespace rollerrig::integrate {

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
  ExponentialRungeKutta4(Evaluator<System> const& f, bool with_stiff_modes) : with_stiff_modes_{with_stiff_modes} {
    now_ = f.system().stiff_modes();
    next_ = f.system().stiff_modes();
    modes_.reserve(now_.capacity());
    auto const size = f.sizes().states + f.sizes().quadratures;
    for (Vector* v : {&k1_, &k2_, &k3_, &k4_, &k_end_, &stage_}) v->setZero(size);
    error_.setZero(f.sizes().states);
  }

  void restart() { has_end_slope_ = false; }

  template <class System>
  Status prepare(Evaluator<System>& f, double t, Vector const& y) {
    if (std::exchange(has_end_slope_, false)) {
      k1_.swap(k_end_);
    } else {
      if (auto e = f.derivative(t, y, k1_); e != Status::ok) return e;
      now_.clear();
      renewed_ = renew(f);
    }
    if (std::exchange(renewed_, false)) std::swap(now_, next_);
    return Status::ok;
  }

  Vector const& slope() const { return k1_; }
  /// Zero: the method has no estimate, and the constructor of Integrator asks for a fixed step.
  Vector const& error() const { return error_; }

  template <class System>
  Status attempt(Evaluator<System>& f, Step const& s, Vector const& y, Vector& y_new) {
    double const h = s.h;
    double const middle = s.t + 0.5 * h;
    begin(h, y);
    drive(k1_, &ModeState::n1);
    stage_ = y + (0.5 * h) * k1_;
    decay(stage_, 0.5 * h, [](ModeState const& r) { return r.w.decay_half * r.start + r.w.half * r.n1; });
    if (auto e = f.derivative(middle, stage_, k2_); e != Status::ok) return e;
    drive(k2_, &ModeState::n2);
    stage_ = y + (0.5 * h) * k2_;
    decay(stage_, 0.5 * h, [](ModeState const& r) { return r.w.decay_half * r.start + r.w.b1 * r.n1 + r.w.b2 * r.n2; });
    if (auto e = f.derivative(middle, stage_, k3_); e != Status::ok) return e;
    drive(k3_, &ModeState::n3);
    stage_ = y + h * k3_;
    decay(stage_, h, [](ModeState const& r) { return r.w.decay * r.start + r.w.c1 * r.n1 + r.w.c3 * r.n3; });
    if (auto e = f.derivative(s.end, stage_, k4_); e != Status::ok) return e;
    drive(k4_, &ModeState::n4);
    y_new = y + (h / 6) * (k1_ + 2 * k2_ + 2 * k3_ + k4_);
    decay(y_new, h, [](ModeState const& r) {
      return r.w.decay * r.start + r.w.d1 * r.n1 + r.w.d2 * (r.n2 + r.n3) + r.w.d4 * r.n4;
    });
    if (auto e = f.derivative(s.end, y_new, k_end_); e != Status::ok) return e;
    has_end_slope_ = true;
    renewed_ = renew(f);  // now: until the next step the system may be asked for outputs elsewhere
    return Status::ok;
  }

  /// y(t + theta h) of the last attempted step; HNW I (6.7) across the stiff modes.
  void interpolate(double theta, double h, Vector const& y, Vector const& y_new, Vector& out) const {
    double const rest = 1 - theta;
    out = rest * y + theta * y_new -
          (theta * rest) * ((1 - 2 * theta) * (y_new - y) - (rest * h) * k1_ + (theta * h) * k_end_);
    for (std::size_t i = 0; i < modes_.size(); ++i) {
      // N as a parabola in time through its values at both ends and the mean of those at the middle.
      ModeState const& r = modes_[i];
      double const middle = 0.5 * (r.n2 + r.n3);
      double const linear = -3.0 * r.n1 + 4.0 * middle - r.n4;
      double const square = 2.0 * r.n1 - 4.0 * middle + 2.0 * r.n4;
      PhiFunctions const p(-r.w.rate * theta * h);
      double const there = p.exponential * r.start +
                           h * theta * (p.phi1 * r.n1 + theta * (p.phi2 * linear + 2.0 * theta * p.phi3 * square));
      now_.move(i, there + theta * h * now_.trend(i) - now_.along(i, out.data()), out.data());
    }
  }

  void state(auto& archive) {
    for (StiffModes* modes : {&now_, &next_}) modes->state(archive, static_cast<int>(k1_.size()));
    archive.list(modes_, now_.size());
    archive(renewed_, k1_, k2_, k3_, k4_, k_end_, stage_, error_, has_end_slope_);
  }

 private:
  /// What multiplies N of each stage, step included [s].
  struct Weights {
    double rate{-1.0}, step{0.0};  // that they belong to
    double decay_half, decay;
    double half, b1, b2, c1, c3, d1, d2, d4;
    void state(auto& archive) { archive(rate, step, decay_half, decay, half, b1, b2, c1, c3, d1, d2, d4); }
  };
  struct ModeState {
    Weights w;
    double start, now;  ///< s at the step's start, and at the last stage less the trend until then
    double n1, n2, n3, n4;
    void state(auto& archive) { archive(w, start, now, n1, n2, n3, n4); }
  };

  static void weigh(double rate, double h, Weights& w) {
    if (rate == w.rate && h == w.step) return;
    PhiFunctions const p(-0.5 * rate * h), q(-rate * h);
    w = {rate,
         h,
         p.exponential,
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

  template <class System>
  bool renew(Evaluator<System> const& f) {
    return with_stiff_modes_ && f.system().renew_stiff_modes(now_, next_);
  }

  void begin(double h, Vector const& y) {
    modes_.resize(now_.size());
    for (std::size_t i = 0; i < modes_.size(); ++i) {
      weigh(now_.rate(i), h, modes_[i].w);
      modes_[i].start = modes_[i].now = now_.along(i, y.data());
    }
  }

  /// N = s' + lambda s.
  void drive(Vector const& slope, double ModeState::* n) {
    for (std::size_t i = 0; i < modes_.size(); ++i)
      modes_[i].*n = now_.along(i, slope.data()) - now_.trend(i) + modes_[i].w.rate * modes_[i].now;
  }

  template <class Target>
  void decay(Vector& stage, double elapsed, Target const& target) {
    for (std::size_t i = 0; i < modes_.size(); ++i) {
      modes_[i].now = target(modes_[i]);
      now_.move(i, modes_[i].now + elapsed * now_.trend(i) - now_.along(i, stage.data()), stage.data());
    }
  }

  bool with_stiff_modes_;
  StiffModes now_, next_;
  bool renewed_ = false;  // next_ is for the next step
  std::vector<ModeState> modes_;
  Vector k1_, k2_, k3_, k4_, k_end_, stage_, error_;
  bool has_end_slope_ = false;
};

}  // namespace rollerrig::integrate
