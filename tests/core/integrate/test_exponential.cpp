// The exponential method: order 4 soft and stiff, exact decay, and the classical method where nothing relaxes.
#include <doctest/doctest.h>

#include "integrate/problems.hpp"
#include "rollerrig/integrate/amplification.hpp"

using namespace rollerrig;
using namespace rollerrig::test;
using integrate::LinearSystem;
using integrate::PhiFunctions;

TEST_CASE("phi functions against their defining integrals, on both sides of the change of formula") {
  // phi_k(z) = integral over theta of e^((1 - theta) z) theta^(k-1) / (k-1)!, by Simpson's rule with 4000 panels
  for (double z : {0.0, -1e-9, -0.3, -0.999999, -1.000001, -4.0, -40.0}) {
    double sum[3] = {};
    int const n = 8000;
    for (int i = 0; i <= n; ++i) {
      double const theta = static_cast<double>(i) / n;
      double const w = (i == 0 || i == n ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) / (3.0 * n) * std::exp((1 - theta) * z);
      sum[0] += w, sum[1] += w * theta, sum[2] += w * theta * theta / 2;
    }
    PhiFunctions const p(z);
    CHECK(p.phi1 == doctest::Approx(sum[0]).epsilon(1e-11));
    CHECK(p.phi2 == doctest::Approx(sum[1]).epsilon(1e-11));
    CHECK(p.phi3 == doctest::Approx(sum[2]).epsilon(1e-11));
  }
}

TEST_CASE("exponential_rk4 has order 4 in states, quadratures and output") {
  // The slopes are means over four halvings; 0.2 below the theory allows for the next term of the error.
  Errors const e = errors_of_halved_steps(ExactRelaxation{}, Method::exponential_rk4, 5, 9);
  CHECK(slope(e.state) > 3.8);
  CHECK(slope(e.quadrature) > 3.8);
  CHECK(slope(e.between) > 3.8);
}

TEST_CASE("exponential_rk4 falls to order 2 where the decay is far too fast for a classical step, but no lower") {
  // h times rate from 6000 to 40: N = rate * target grows with the rate, and a stage knows the target of the one before.
  Errors const e = errors_of_halved_steps(ExactRelaxation{{1e5, 1e4}, 1}, Method::exponential_rk4, 5, 9);
  CHECK(slope(e.state) > 1.8);
  CHECK(slope(e.quadrature) > 1.8);
  CHECK(slope(e.between) > 1.8);
  CHECK(e.state.back() < 1e-4);
}

TEST_CASE("exponential_rk4 goes on where rk4 is unstable") {
  ExactRelaxation problem{{300, 300}, 1};
  auto const error = [&](Method method, double step) {
    Integrator integrator(problem, fixed(method, step, 2));
    integrator.start(0, problem.start());
    if (integrator.advance(2) != Status::ok) return 1e9;
    return std::abs(integrator.states()[0] - std::cos(2.0)) + std::abs(integrator.states()[1] - std::sin(4.0));
  };
  CHECK(error(Method::exponential_rk4, 1.0 / 120) < 1e-5);  // h times rate 2.5
  CHECK(error(Method::rk4, 1.0 / 60) > 1.0);
  CHECK(error(Method::exponential_rk4, 1.0 / 60) < 1e-3);
}

TEST_CASE("a decay towards a parabola of time is exact at any step, output included") {
  // N = lambda p(t) with p = 2 + t - 3 t^2: the three quadrature nodes of the method see all of it.
  struct Decay {
    double rate[1] = {700};
    Sizes sizes() const { return {1, 0}; }
    StiffModes stiff_modes() const { return {1, 1, 0}; }
    bool renew_stiff_modes(StiffModes const& now, StiffModes& next) const {
      if (now.size() == 1) return false;
      next.clear();
      next.begin(rate[0], 0.0);
      next.add(0, 1.0, 1.0);
      return true;
    }
    Status derivative(double t, double const* x, double* x_dot, double*) const {
      x_dot[0] = rate[0] * (2 + t - 3 * t * t - x[0]);
      return Status::ok;
    }
    double exact(double t) const {  // particular parabola a + b t - 3 t^2, and what is left of the start
      double const r = rate[0], b = 1 + 6 / r, a = 2 - b / r;
      return a + b * t - 3 * t * t + (5 - a) * std::exp(-r * t);
    }
  } problem;
  Options o = fixed(Method::exponential_rk4, 0.1, 1);
  o.output_step = 0.013;
  Integrator integrator(problem, o);
  integrator.start(0, {5});
  int shown = 0;
  auto const check = [&](double t, double const* x, double const*) {
    CHECK(x[0] == doctest::Approx(problem.exact(t)).epsilon(1e-13));
    ++shown;
  };
  REQUIRE(integrator.advance(1, check) == Status::ok);
  CHECK(shown == 77);
}

TEST_CASE("where nothing relaxes exponential_rk4 is rk4 to the last bit") {
  ExactOscillation problem;
  std::vector<double> ends;
  for (Method method : {Method::rk4, Method::exponential_rk4}) {
    Integrator integrator(problem, fixed(method, 0.013, 3));
    integrator.start(0, problem.start());
    REQUIRE(integrator.advance(3) == Status::ok);
    for (double v : {integrator.states()[0], integrator.states()[1], integrator.quadratures()[0]}) ends.push_back(v);
  }
  for (std::size_t i = 0; i < 3; ++i) CHECK(ends[i] == ends[i + 3]);
}

TEST_CASE("amplification of one step: R(z) of rk4, and exact decay of the exponential form") {
  // A mass on a spring, and a damper's inner node between them that relaxes at 4000 1/s, uncoupled.
  Eigen::MatrixXd a(3, 3);
  a << 0, 1, 0, -1e4, -2, 0, 0, 0, -4000;
  double const h = 2e-3;
  Eigen::Matrix3d const z = h * a;
  Eigen::Matrix3d const one = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d const polynomial = one + z * (one + z / 2 * (one + z / 3 * (one + z / 4)));
  Eigen::MatrixXd const classical = amplification(LinearSystem{a}, Method::rk4, h);
  CHECK((classical - polynomial).cwiseAbs().maxCoeff() < 1e-13 * polynomial.cwiseAbs().maxCoeff());
  CHECK(std::abs(classical(2, 2)) > 1);
  StiffModes node(1, 1, 0);
  node.begin(4000, 0.0);
  node.add(2, 1.0, 1.0);
  Eigen::MatrixXd const exponential = amplification(LinearSystem{a, node}, Method::exponential_rk4, h);
  CHECK((exponential.topLeftCorner(2, 2) - polynomial.topLeftCorner(2, 2)).norm() < 1e-12);
  CHECK(exponential(2, 2) == doctest::Approx(std::exp(-8.0)).epsilon(1e-12));
}

// ------------------------------------------------------------------------------------------- slip as a direction

TEST_CASE("slip against a saturating force: order 4 where it is not stiff") {
  // Rate 170 1/s: from 1.3 to 0.2 times the step.
  Errors const e = errors_of_halved_steps(ExactSlip{20, 1}, Method::exponential_rk4, 8, 11);
  CHECK(slope(e.state) > 3.8);
  CHECK(slope(e.quadrature) > 3.8);
  CHECK(slope(e.between) > 3.7);
}

TEST_CASE("slip against a force far too stiff for a classical step: order 2, and order 1 where it saturates") {
  // Rate 8.5e5 1/s: from 53000 to 3300 times the step. Between a wrong rate and the true one stands the error of the slip
  // at the stages, of order h: the slip that drives it moves by 5 per second.
  ExactSlip hardly{1e5, 50}, half{1e5, 5};  // the slip reaches 2.6
  Errors const e = errors_of_halved_steps(hardly, Method::exponential_rk4, 5, 9);
  CHECK(slope(e.state) > 1.7);
  CHECK(slope(e.quadrature) > 1.7);
  CHECK(e.state.back() < 1e-6);
  Errors const saturated = errors_of_halved_steps(half, Method::exponential_rk4, 5, 9);
  CHECK(slope(saturated.state) > 0.9);
  CHECK(saturated.state.back() < 2e-4);
  CHECK(saturated.between.back() < 4e-4);
  Integrator classical(hardly, fixed(Method::rk4, 1.0 / 256, 2));
  classical.start(0, ExactSlip::start());
  classical.advance(2);
  CHECK(std::abs(classical.states()[1] - ExactSlip::exact(2)[1]) > 1.0);
}

TEST_CASE("what the slip follows may run away: the drift takes the error of a late guess out") {
  ExactSlip with{1e4, 5}, without{1e4, 5};
  without.drifts = false;
  double const error_with = errors_of_halved_steps(with, Method::exponential_rk4, 7, 7).state[0];
  double const error_without = errors_of_halved_steps(without, Method::exponential_rk4, 7, 7).state[0];
  CHECK(error_with < 0.7 * error_without);
}

TEST_CASE("a rate judged wrongly costs accuracy, not stability") {
  for (double judged : {0.65, 0.8, 1.5, 3.0}) {
    ExactSlip problem{1e5, 50};  // hardly saturated: the secant is the true rate
    problem.judged = judged;
    CHECK(errors_of_halved_steps(problem, Method::exponential_rk4, 9, 9).state[0] < 0.05);
  }
}

TEST_CASE("a wheel that slides sticks again without chatter") {
  // Friction of 30 m/s^2 that grows at 1e4 1/s out of stick, against a constant push of 10 m/s^2; from 0.5 m/s.
  struct Block {
    mutable double secant = 0;
    Sizes sizes() const { return {1, 0}; }
    StiffModes stiff_modes() const { return {1, 1, 0}; }
    bool renew_stiff_modes(StiffModes const&, StiffModes& next) const {
      next.clear();
      next.begin(secant, 0.0);
      next.add(0, 1.0, 1.0);
      return true;
    }
    Status derivative(double, double const* v, double* v_dot, double*) const {
      secant = 1e4 / std::sqrt(1 + std::pow(v[0] / 3e-3, 2));
      v_dot[0] = 10 - secant * v[0];
      return Status::ok;
    }
  } block;
  Integrator integrator(block, fixed(Method::exponential_rk4, 1e-3, 0.1));
  integrator.start(0, {0.5});
  REQUIRE(integrator.advance(0.02) == Status::ok);
  CHECK(integrator.states()[0] == doctest::Approx(0.5 - 0.02 * 20).epsilon(2e-3));  // it slides on
  REQUIRE(integrator.advance(0.05) == Status::ok);
  double const stuck = 1e-3 / std::sqrt(1 - 1.0 / 9.0);  // where secant v = 10
  CHECK(integrator.states()[0] == doctest::Approx(stuck).epsilon(1e-6));
}

TEST_CASE("directions are moved along, not across, and steps do not depend on when outputs are asked for") {
  StiffModes r(2, 4, 0);
  r.begin(10, 0.0);
  r.add(0, 1.0, 0.5), r.add(2, 1.0, 0.5);
  r.begin(20, 0.0);
  r.add(0, 1.0, 0.5), r.add(2, -1.0, -0.5);
  double x[] = {1, 7, 2};
  r.move(0, 3.0, x);
  CHECK(r.along(0, x) == doctest::Approx(6.0));
  CHECK(r.along(1, x) == doctest::Approx(-1.0));
  CHECK(x[1] == 7);
  std::vector<double> ends;
  for (double output : {0.0, 0.003}) {
    ExactSlip problem{300, 0.5};
    Options o = fixed(Method::exponential_rk4, 0.01, 1);
    o.output_step = output;
    Integrator integrator(problem, o);
    integrator.start(0, ExactSlip::start());
    // An observer that looks at the system elsewhere, as a recorder does.
    REQUIRE(integrator.advance(1, [&](double t, double const* v, double const*) {
      double v_dot[2];
      problem.derivative(t, v, v_dot, nullptr);
    }) == Status::ok);
    ends.push_back(integrator.states()[0]);
  }
  CHECK(ends[0] == ends[1]);
}
