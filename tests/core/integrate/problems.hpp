// Problems with exact or published solutions, shared by the tests of the integrators.
#pragma once
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "rollerrig/integrate/integrator.hpp"

namespace rollerrig::test {

using integrate::Method;
using integrate::Options;

/// Any system, by reference, as one type: the integrator and its methods take longest to compile, problems.cpp does it once.
/// What a system lacks has no effect here.
struct AnySystem {
  std::function<Sizes()> sizes;
  std::function<Status(double, double const*, double*, double*)> derivative;
  std::function<Status(double, double const*, JacobianData&)> jacobian = [](auto&&...) { return Status::not_finite; };
  std::function<Status(double, double const*)> accept = [](auto...) { return Status::ok; };
  std::function<int()> kinematic_states = [] { return 0; };
  std::function<int(int)> velocity_column;
  std::function<StiffModes()> stiff_modes = [] { return StiffModes(); };
  std::function<bool(StiffModes const&, StiffModes&)> renew_stiff_modes = [](auto&...) { return false; };

  template <class S>
  AnySystem(S& s) : sizes{[&s] { return s.sizes(); }}, derivative{[&s](auto... a) { return s.derivative(a...); }} {
    if constexpr (requires { &S::jacobian; })
      jacobian = [&s](double t, auto x, auto& j) { return s.jacobian(t, x, j); };
    if constexpr (requires { &S::accept; }) accept = [&s](double t, auto x) { return s.accept(t, x); };
    if constexpr (requires { &S::kinematic_states; }) {
      kinematic_states = [&s] { return s.kinematic_states(); };
      velocity_column = [&s](int i) { return s.velocity_column(i); };
    }
    if constexpr (requires { &S::stiff_modes; }) {
      stiff_modes = [&s] { return s.stiff_modes(); };
      renew_stiff_modes = [&s](auto& now, auto& next) { return s.renew_stiff_modes(now, next); };
    }
  }
};

/// integrate::Integrator of any system.
class Integrator : AnySystem, public integrate::Integrator<AnySystem> {
 public:
  using Observer = std::function<void(double, double const*, double const*)>;

  Integrator(AnySystem system, Options options);
  Integrator(Integrator const&) = delete;
  ~Integrator();
  Status start(double t0, std::vector<double> const& x0);
  Status advance(double t_stop, Observer const& observer = [](auto...) {});
  void sample(double t, double* x, double* z);
};

/// x = (cos t, sin 2t) solves a nonlinear, non-autonomous, coupled system; z accumulates t x0^2 + x1.
/// `stiffness` [1/s] is the rate at which x0 is pulled to its solution: the idea of Prothero and Robinson (1974).
struct ExactOscillation {
  double stiffness = 0;

  Sizes sizes() const { return {2, 1}; }

  Status derivative(double t, double const* x, double* x_dot, double* z_dot) const {
    double const e0 = x[0] - std::cos(t);
    double const e1 = x[1] - std::sin(2 * t);
    x_dot[0] = -std::sin(t) + x[0] * x[1] - std::cos(t) * std::sin(2 * t) - stiffness * e0 * (1 + x[1] * x[1]);
    x_dot[1] = 2 * std::cos(2 * t) - e0 * x[1] + 0.3 * e1 * e1;
    if (z_dot != nullptr) z_dot[0] = t * x[0] * x[0] + x[1];
    return Status::ok;
  }

  Status jacobian(double t, double const* x, JacobianData& j) const {
    double const c = std::cos(t), s = std::sin(t), c2 = std::cos(2 * t), s2 = std::sin(2 * t);
    double const e0 = x[0] - c;
    double const e1 = x[1] - s2;
    j.a << x[1] - stiffness * (1 + x[1] * x[1]), x[0] - 2 * stiffness * e0 * x[1], -x[1], -e0 + 0.6 * e1;
    j.f_t << -c + s * s2 - 2 * c * c2 - stiffness * s * (1 + x[1] * x[1]), -4 * s2 - s * x[1] - 1.2 * e1 * c2;
    j.g << 2 * t * x[0], 1;
    j.g_t << x[0] * x[0];
    return Status::ok;
  }

  static std::vector<double> start() { return {1, 0}; }
  static double x0(double t) { return std::cos(t); }
  static double x1(double t) { return std::sin(2 * t); }
  static std::vector<double> exact(double t) { return {x0(t), x1(t)}; }

  /// Integral of t cos^2 t + sin 2t from 0.
  static double z(double t) {
    return t * t / 4 + t * std::sin(2 * t) / 4 + (std::cos(2 * t) - 1) / 8 + (1 - std::cos(2 * t)) / 2;
  }
};

/// x'' = -omega^2 x, of which the first state is declared kinematic unless told otherwise.
struct Oscillator {
  double omega = 1;  // [rad/s]
  bool declare_kinematic = true;

  Sizes sizes() const { return {2, 0}; }
  int kinematic_states() const { return declare_kinematic ? 1 : 0; }
  int velocity_column(int) const { return 1; }

  Status derivative(double, double const* x, double* x_dot, double*) const {
    x_dot[0] = x[1];
    x_dot[1] = -omega * omega * x[0];
    return Status::ok;
  }
  Status jacobian(double, double const*, JacobianData& j) const {
    j.a << 0, 1, -omega * omega, 0;
    return Status::ok;
  }
  double energy(double const* x) const { return (x[1] * x[1] + omega * omega * x[0] * x[0]) / 2; }
};

/// x' = (real + i imaginary) x as two real states.
struct Spiral {
  double real, imaginary;
  Sizes sizes() const { return {2, 0}; }
  Status derivative(double, double const* x, double* x_dot, double*) const {
    x_dot[0] = real * x[0] - imaginary * x[1];
    x_dot[1] = imaginary * x[0] + real * x[1];
    return Status::ok;
  }
  Status jacobian(double, double const*, JacobianData& j) const {
    j.a << real, -imaginary, imaginary, real;
    return Status::ok;
  }
};

/// eps x'' = (1 - x^2) x' - x.  For eps = 1e-6 and x = (2, 0) the solution at t = 2 is published:
/// Test Set for IVP Solvers (CWI Amsterdam, University of Bari), problem VDPOL.
struct VanDerPol {
  double epsilon = 1;
  static constexpr double published_x0 = 1.706167732170483;
  static constexpr double published_x1 = -0.8928097010247975;

  Sizes sizes() const { return {2, 0}; }
  Status derivative(double, double const* x, double* x_dot, double*) const {
    x_dot[0] = x[1];
    x_dot[1] = ((1 - x[0] * x[0]) * x[1] - x[0]) / epsilon;
    return Status::ok;
  }
  Status jacobian(double, double const* x, JacobianData& j) const {
    j.a << 0, 1, (-2 * x[0] * x[1] - 1) / epsilon, (1 - x[0] * x[0]) / epsilon;
    return Status::ok;
  }
};

/// One state whose rate is a function of time and state; the Jacobian is given as numbers.
struct Scalar1 {
  std::function<double(double, double)> rate;  // (t, x) -> x'
  double dfdx = 0;
  double dfdt = 0;

  Sizes sizes() const { return {1, 0}; }
  Status derivative(double t, double const* x, double* x_dot, double*) {
    x_dot[0] = rate(t, x[0]);
    return Status::ok;
  }
  Status jacobian(double, double const*, JacobianData& j) const {
    j.a << dfdx;
    j.f_t << dfdt;
    return Status::ok;
  }
};

inline Options fixed(Method method, double step, double final_time) {
  Options o;
  o.method = method;
  o.step = step;
  o.final_time = final_time;
  return o;
}

inline Options adaptive(Method method, double tolerance, double final_time) {
  Options o;
  o.method = method;
  o.relative_tolerance = tolerance;
  o.absolute_tolerance = {tolerance};
  o.final_time = final_time;
  return o;
}

inline constexpr Method all_methods[] = {Method::rk4, Method::exponential_rk4, Method::exponential_adams,
                                         Method::dormand_prince, Method::rodas4};

/// rk4 and its exponential form have no error estimate; exponential_adams goes below a step, not above.
inline bool needs_step(Method method) {
  return method == Method::rk4 || method == Method::exponential_rk4 || method == Method::exponential_adams;
}

/// exponential_adams begins with an eighth of its step, and halves one that fails.
inline bool keeps_its_step(Method method) { return method != Method::exponential_adams; }

/// x = (cos t, sin 2t, 1 + sin 3t, cos t): the last two relax at given rates [1/s] towards functions of the others and of
/// time, and push them back. z accumulates x0 x2.
struct ExactRelaxation {
  double rates[2] = {5, 20};
  double back = 1;  ///< how strongly the relaxing states push the others [1/s]

  Sizes sizes() const { return {4, 1}; }
  StiffModes stiff_modes() const { return {2, 2, 0}; }
  bool renew_stiff_modes(StiffModes const& now, StiffModes& next) const {
    if (now.size() == 2) return false;
    next.clear();
    for (int i = 0; i < 2; ++i) {
      next.begin(rates[i], 0.0);
      next.add(2 + i, 1.0, 1.0);
    }
    return true;
  }

  Status derivative(double t, double const* x, double* x_dot, double* z_dot) const {
    double const e0 = x[0] - std::cos(t), e1 = x[1] - std::sin(2 * t);
    double const e2 = x[2] - x2(t), e3 = x[3] - std::cos(t);
    x_dot[0] = -std::sin(t) + x[0] * e1 - e0 * (1 + x[1] * x[1]) + back * e2;
    x_dot[1] = 2 * std::cos(2 * t) - e0 * x[1] + back * (e3 - e2);
    x_dot[2] = 3 * std::cos(3 * t) + rates[0] * ((1 + x[1]) * (1 + e0) - 1 - std::sin(2 * t) - e2);
    x_dot[3] = -std::sin(t) + rates[1] * (x[0] + e1 * x[1] - x[3]);
    if (z_dot != nullptr) z_dot[0] = x[0] * x[2];
    return Status::ok;
  }
  static double x2(double t) { return 1 + std::sin(3 * t); }
  static std::vector<double> start() { return {1, 0, 1, 1}; }
  static std::vector<double> exact(double t) { return {std::cos(t), std::sin(2 * t), x2(t), std::cos(t)}; }
  /// Integral of cos t (1 + sin 3t) from 0.
  static double z(double t) { return std::sin(t) + (1 - std::cos(4 * t)) / 8 + (1 - std::cos(2 * t)) / 4; }
};

/// Two masses that slip on a belt: M v' = p(t) - d T(s), s = d . v - V(t), with T(s) = viscosity s / sqrt(1 + (s/s_0)^2) that
/// saturates. p is such that v = (cos t, V/2 + sin 2t) with V = -3 t. z accumulates v0 v1.
struct ExactSlip {
  double viscosity = 100, saturation_slip = 1;
  double judged = 1;  ///< declared rate over the secant of T
  bool drifts = true;
  mutable double last_secant = 0;  ///< as derivative() found it last
  static constexpr double mass[2] = {2, 0.5}, d[2] = {1, 2}, belt = -3;

  Sizes sizes() const { return {2, 1}; }
  double traction(double s) const { return viscosity * s / std::sqrt(1 + s * s / (saturation_slip * saturation_slip)); }
  Status derivative(double t, double const* v, double* v_dot, double* z_dot) const {
    double const s = d[0] * v[0] + d[1] * v[1] - belt * t;
    double const exact_slip = std::cos(t) + 2 * std::sin(2 * t);
    double const force = traction(s) - traction(exact_slip);
    v_dot[0] = -std::sin(t) - d[0] / mass[0] * force;
    v_dot[1] = belt / 2 + 2 * std::cos(2 * t) - d[1] / mass[1] * force;
    if (z_dot != nullptr) z_dot[0] = v[0] * v[1];
    last_secant = traction(s + 1e-9) / (s + 1e-9);
    return Status::ok;
  }
  StiffModes stiff_modes() const { return {1, 2, 1}; }
  bool renew_stiff_modes(StiffModes const&, StiffModes& next) const {
    double const inverse_mass = d[0] * d[0] / mass[0] + d[1] * d[1] / mass[1];
    next.clear();
    next.begin(judged * last_secant * inverse_mass, drifts ? belt : 0.0);
    for (int i = 0; i < 2; ++i) next.add(i, d[i], d[i] / mass[i] / inverse_mass);
    return true;
  }
  static std::vector<double> start() { return {1, 0}; }
  static std::vector<double> exact(double t) { return {std::cos(t), belt * t / 2 + std::sin(2 * t)}; }
  static double z(double t) {
    return belt / 2 * (t * std::sin(t) + std::cos(t) - 1) + 2.0 / 3.0 * (1 - std::pow(std::cos(t), 3));
  }
};

struct Errors {
  std::vector<double> state, quadrature, between;  // at the end, at the end, largest on a fine output grid
  double evaluations = 0;                          // per step, of the finest
};

/// Over 2 s, in 2^coarsest to 2^finest steps.
///
/// @param tolerance  of the coarsest steps; a 32nd of it with each halving, as the error of a step; 0: as the method has it
template <class Problem>
Errors errors_of_halved_steps(Problem problem, Method method, int coarsest, int finest, double tolerance = 0) {
  Errors errors;
  double const end = 2;
  for (int k = coarsest; k <= finest; ++k) {
    Options o = fixed(method, end / (1 << k), end);
    if (tolerance > 0)
      o.absolute_tolerance = {std::ldexp(tolerance, -5 * (k - coarsest))}, o.relative_tolerance = 1e-16;
    o.output_step = o.step / 3.7;  // never at the ends of steps
    Integrator integrator(problem, o);
    REQUIRE(integrator.start(0, problem.start()) == Status::ok);
    auto const largest = [&](double t, double const* x) {
      auto const exact = problem.exact(t);
      double e = 0;
      for (std::size_t i = 0; i < exact.size(); ++i) e = std::max(e, std::abs(x[i] - exact[i]));
      return e;
    };
    double between = 0;
    auto const compare = [&](double t, double const* x, double const*) { between = std::max(between, largest(t, x)); };
    REQUIRE(integrator.advance(end, compare) == Status::ok);
    REQUIRE(integrator.time() == end);
    errors.state.push_back(largest(end, integrator.states()));
    errors.quadrature.push_back(std::abs(integrator.quadratures()[0] - problem.z(end)));
    errors.between.push_back(between);
    auto const& statistics = integrator.statistics();
    CHECK(statistics.rejected_steps == 0);
    errors.evaluations = static_cast<double>(statistics.derivative_calls) / static_cast<double>(statistics.steps);
  }
  return errors;
}

/// Order seen when the step is halved from one entry to the next.
inline double slope(std::vector<double> const& errors) {
  return std::log2(errors.front() / errors.back()) / static_cast<double>(errors.size() - 1);
}

}  // namespace rollerrig::test
