// The exponential multistep method: order 4 with any Jacobian it keeps, exact where the system is linear, two evaluations a step or one.
#include <doctest/doctest.h>

#include "integrate/problems.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

constexpr Method adams = Method::exponential_adams;

/// Options under which no step is ever halved for its error.
Options without_control(double step, double end) {
  Options o = fixed(adams, step, end);
  o.absolute_tolerance = {1e9};
  return o;
}

/// ExactOscillation whose Jacobian is wrong: a part of the true one at the start of the run.
struct KeptPart : ExactOscillation {
  double part = 1;
  Status jacobian(double t, double const* x, JacobianData& j) const {
    ExactOscillation::jacobian(t, x, j);
    j.a *= part;
    j.g *= part;
    return Status::ok;
  }
};

/// x' = A x with positions first, z' = G x; A has a fast oscillation, a fast decay and a slow motion.
struct Linear {
  Eigen::Matrix4d a{{0, 0, 1, 0}, {0, 0, 0, 1}, {-1e6, 3e5, -50, 0}, {2e5, -4e5, 0, -5e3}};
  Eigen::RowVector4d g{3e4, -1e4, 20, 7};
  Sizes sizes() const { return {4, 1}; }
  int kinematic_states() const { return 2; }
  int velocity_column(int i) const { return 2 + i; }
  Status derivative(double, double const* x, double* x_dot, double* z_dot) const {
    Eigen::Map<Eigen::Vector4d const> const v(x);
    Eigen::Map<Eigen::Vector4d>(x_dot, 4) = a * v;
    if (z_dot != nullptr) z_dot[0] = g * v;
    return Status::ok;
  }
  Status jacobian(double, double const*, JacobianData& j) const {
    j.a = a;
    j.g = g;
    return Status::ok;
  }
};

}  // namespace

TEST_CASE("exponential_adams has order 4 in states, quadratures and output, whatever part of the Jacobian it keeps") {
  for (double part : {1.0, 0.5, 0.0}) {
    CAPTURE(part);
    for (bool corrected : {true, false}) {
      CAPTURE(corrected);
      Errors const e = errors_of_halved_steps(KeptPart{{}, part}, adams, 5, 9, corrected ? 1e-6 : 1e9);
      CHECK(slope(e.state) > 3.8);
      CHECK(slope(e.quadrature) > 3.8);
      CHECK(slope(e.between) > 3.8);
      CHECK(e.evaluations == doctest::Approx(corrected ? 2.0 : 1.05).epsilon(0.005));
    }
  }
}

TEST_CASE("exponential_adams solves a linear system exactly at any step: stiff decay, oscillation and quadrature") {
  Linear problem;
  using Matrix = Eigen::Matrix<long double, 5, 5>;
  Matrix all = Matrix::Zero();
  all.topLeftCorner(4, 4) = problem.a.cast<long double>();
  all.bottomLeftCorner(1, 4) = problem.g.cast<long double>();
  Eigen::Vector<double, 5> const start(1e-3, -2e-3, 0.5, 1, 0);
  double const end = 0.2;
  Matrix term = Matrix::Identity(), exponential = term;  // Taylor's series of a 2^20th of the time, squared
  for (int k = 1; k < 20; ++k) exponential += term = std::ldexp(end, -20) / k * all * term;
  for (int k = 0; k < 20; ++k) exponential = (exponential * exponential).eval();
  Eigen::Vector<double, 5> const exact = (exponential * start.cast<long double>()).cast<double>();
  for (double step : {1e-4, 1e-3, 0.01, 0.2}) {
    Integrator integrator(problem, without_control(step, end));
    integrator.start(0, {start.data(), start.data() + 4});
    REQUIRE(integrator.advance(end) == Status::ok);
    // Round-off of the doublings, of a phase of 200 rad.
    for (int i = 0; i < 4; ++i) CHECK(std::abs(integrator.states()[i] - exact[i]) < 1e-10 * std::abs(start[i]));
    CHECK(integrator.quadratures()[0] == doctest::Approx(exact[4]).epsilon(1e-10));
    CHECK(integrator.statistics().jacobian_calls == 1);
  }
}

TEST_CASE(
    "exponential_adams wipes out an infinitely fast decay and amplifies no oscillation, however coarse the step") {
  auto const left = [](double real, double imaginary) {
    Spiral problem{real, imaginary};
    Integrator integrator(problem, without_control(1, 20));
    integrator.start(0, {1, 0});
    REQUIRE(integrator.advance(20) == Status::ok);
    return std::hypot(integrator.states()[0], integrator.states()[1]);
  };
  for (double rate : {1e2, 1e4, 1e8}) CHECK(left(-rate, 0) < 1e-12);
  // Round-off of f - L x, which is of the size of a rate times 1e-16, over twenty steps.
  for (double phase : {0.1, 1.0, 3.0, 10.0, 100.0, 1e3}) CHECK(left(0, phase) <= 1 + 1e-12 * (1 + phase));
}

TEST_CASE("what is a linear invariant of the system stays one, to round-off, where forces are nonlinear") {
  // v' = F(x, v) / m, z' = F: m v - z is constant, as work of a drive against momentum.
  struct Driven {
    Sizes sizes() const { return {2, 1}; }
    static double force(double x, double v) { return -1e6 * x - 3e11 * x * x * x - 20 * std::tanh(v); }
    Status derivative(double, double const* x, double* x_dot, double* z_dot) const {
      x_dot[0] = x[1];
      x_dot[1] = force(x[0], x[1]) / 3.0;
      if (z_dot != nullptr) z_dot[0] = force(x[0], x[1]);
      return Status::ok;
    }
    Status jacobian(double, double const* x, JacobianData& j) const {
      double const kx = -1e6 - 9e11 * x[0] * x[0], kv = -20 / std::pow(std::cosh(x[1]), 2);
      j.a << 0, 1, kx / 3.0, kv / 3.0;
      j.g << kx, kv;
      return Status::ok;
    }
  } problem;
  Integrator integrator(problem, without_control(5e-4, 0.5));
  integrator.start(0, {1e-3, 0});
  REQUIRE(integrator.advance(0.5) == Status::ok);
  CHECK(std::abs(3.0 * integrator.states()[1] - integrator.quadratures()[0]) < 1e-11);
  CHECK(std::hypot(integrator.states()[1], 600 * integrator.states()[0]) > 1e-2);  // it still moves
}

TEST_CASE("a step is halved where the force has a kink and doubled behind it; the error follows the tolerance") {
  Scalar1 problem{[](double t, double x) { return -x + std::abs(t - 0.5137); }, -1};
  auto const exact = [](double t) {  // from x = 0
    double const k = 0.5137;
    auto const before = [&](double s) { return (k + 1) - s - (k + 1) * std::exp(-s); };
    return t < k ? before(t) : (before(k) + 1) * std::exp(-(t - k)) + (t - k) - 1;
  };
  for (double tolerance : {1e-2, 1e-5, 1e-7}) {
    Options o = fixed(adams, 0.02, 1);
    o.relative_tolerance = tolerance;
    o.absolute_tolerance = {tolerance};
    Integrator integrator(problem, o);
    integrator.start(0, {0});
    REQUIRE(integrator.advance(1) == Status::ok);
    CHECK(std::abs(integrator.states()[0] - exact(1)) < 10 * tolerance);
    CHECK(integrator.statistics().largest_step == doctest::Approx(0.02));
    CHECK((integrator.statistics().rejected_steps > 0) == (tolerance < 1e-3));
    CHECK(integrator.statistics().coarse_steps == 0);
  }
  Options o = fixed(adams, 0.02, 1);
  o.relative_tolerance = 1e-12;
  o.absolute_tolerance = {1e-12};
  Integrator integrator(problem, o);
  integrator.start(0, {0});
  REQUIRE(integrator.advance(1) == Status::ok);
  CHECK(integrator.statistics().coarse_steps > 0);  // a 32nd is kept, and counted
  CHECK(integrator.statistics().largest_error > 1.0);
  CHECK(integrator.statistics().smallest_step == doctest::Approx(0.02 / 32));
}

TEST_CASE("a Jacobian that has become wrong is renewed, and the long step comes back") {
  // Stiffness drifts from 1 to 30 times: N = (k(t) - k(0)) x is soon too fast for the step.
  struct Hardening {
    Sizes sizes() const { return {2, 0}; }
    static double stiffness(double t) { return 1e4 * (1 + 29 * std::min(t, 1.0)); }
    Status derivative(double t, double const* x, double* x_dot, double*) const {
      x_dot[0] = x[1];
      x_dot[1] = -stiffness(t) * x[0] - 20 * x[1] + 100 * std::cos(5 * t);
      return Status::ok;
    }
    Status jacobian(double t, double const*, JacobianData& j) const {
      j.a << 0, 1, -stiffness(t), -20;
      return Status::ok;
    }
  } problem;
  Options o = fixed(adams, 4e-3, 8);
  o.relative_tolerance = 1e-4;
  o.absolute_tolerance = {1e-8, 1e-6};
  Integrator integrator(problem, o);
  integrator.start(0, {0, 0});
  REQUIRE(integrator.advance(8) == Status::ok);
  auto const& s = integrator.statistics();
  CHECK(s.jacobian_calls > 1);
  CHECK(s.jacobian_calls < 12);
  CHECK(integrator.time() - integrator.step_start() == doctest::Approx(4e-3));
  double const k = Hardening::stiffness(8) - 25, c = 20 * 5;  // forced oscillation
  double const x = 100 * (k * std::cos(40.0) + c * std::sin(40.0)) / (k * k + c * c);
  CHECK(integrator.states()[0] == doctest::Approx(x).epsilon(1e-4));
}

TEST_CASE("creep that stiffens as a train slows: the Jacobian is renewed before the corrections grow, and seldom") {
  auto const rate_at = [](double t) { return 300 + 3000 * t; };  // [1/s]
  struct Creep : Scalar1 {
    Status jacobian(double t, double const*, JacobianData& j) const {
      j.a << -(300 + 3000 * t);
      return Status::ok;
    }
  };
  Creep problem{{[=](double t, double x) { return -rate_at(t) * (x - std::cos(3 * t)); }}};
  Options o = fixed(adams, 1e-3, 10);
  o.relative_tolerance = 1e-3;
  o.absolute_tolerance = {1e-3};
  Integrator integrator(problem, o);
  integrator.start(0, {1});
  double largest = 0;
  REQUIRE(integrator.advance(10, [&](double t, double const* x, double const*) {
    double const r = rate_at(t);  // x = cos - (cos)' / r + O(1 / r^2)
    if (t > 0.1) largest = std::max(largest, std::abs(x[0] - std::cos(3 * t) - 3 * std::sin(3 * t) / r));
  }) == Status::ok);
  auto const& s = integrator.statistics();
  CHECK(s.rejected_steps == 0);
  CHECK(s.jacobian_calls > 5);
  CHECK(s.jacobian_calls < 20);
  // Tolerance 1e-3: without renewal a burst reaches it and fails the step.
  CHECK(largest < 1e-4);
}

TEST_CASE("a step costs one evaluation where the prediction serves, and the Jacobian is that of the start") {
  ExactOscillation problem;
  Integrator integrator(problem, without_control(0.01, 2));
  integrator.start(0, problem.start());
  REQUIRE(integrator.advance(2) == Status::ok);
  auto const& s = integrator.statistics();
  CHECK(s.jacobian_calls == 1);
  CHECK(s.rejected_steps == 0);
  CHECK(s.steps < 200 + 16);                             // eighths, quarters and halves at the start
  CHECK(s.derivative_calls <= s.steps + 3 * 3 + 1 + 1);  // three single steps of four, the first slope, a look at L
  CHECK(s.smallest_step == doctest::Approx(0.01 / 8));
}

TEST_CASE("steps of exponential_adams reach breakpoints and the end in whole steps") {
  ExactOscillation problem;
  Options o = without_control(0.03, 1);
  o.breakpoints = {0.2, 0.55};
  Integrator integrator(problem, o);
  integrator.start(0, problem.start());
  std::vector<double> ends;
  REQUIRE(integrator.advance(1, [&](double t, double const*, double const*) { ends.push_back(t); }) == Status::ok);
  for (double b : {0.2, 0.55, 1.0}) CHECK(std::count(ends.begin(), ends.end(), b) == 1);
  CHECK(integrator.statistics().largest_step <= 0.03 * (1 + 1e-9));
  CHECK(integrator.statistics().jacobian_calls == 3);
  CHECK(std::abs(integrator.states()[0] - problem.x0(1)) < 2e-6);
}
