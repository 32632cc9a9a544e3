// The exponential method: order 4 soft and stiff, exact decay, and the classical method where nothing relaxes.
#include <doctest/doctest.h>

#include "integrate/problems.hpp"
#include "rig/integrate/amplification.hpp"

using namespace rig;
using namespace rig::test;
using integrate::LinearSystem;
using integrate::PhiFunctions;

namespace {

struct Errors {
  std::vector<double> state, quadrature, between;  // at the end, at the end, largest on a fine output grid
};

Errors errors_of_halved_steps(ExactRelaxation problem, int coarsest, int finest) {
  Errors errors;
  double const end = 2;
  for (int k = coarsest; k <= finest; ++k) {
    Options o = fixed(Method::exponential_rk4, end / (1 << k), end);
    o.output_step = o.step / 3.7;  // never at the ends of steps
    Integrator integrator(problem, o);
    REQUIRE(integrator.start(0, problem.start().data()) == Status::ok);
    auto const largest = [&](double t, double const* x) {
      auto const exact = problem.exact(t);
      double e = 0;
      for (std::size_t i = 0; i < exact.size(); ++i) e = std::max(e, std::abs(x[i] - exact[i]));
      return e;
    };
    double between = 0;
    auto const compare = [&](double t, double const* x, double const*) { between = std::max(between, largest(t, x)); };
    REQUIRE(integrator.advance(end, compare) == Status::ok);
    errors.state.push_back(largest(end, integrator.states()));
    errors.quadrature.push_back(std::abs(integrator.quadratures()[0] - problem.z(end)));
    errors.between.push_back(between);
  }
  return errors;
}

}  // namespace

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
  Errors const e = errors_of_halved_steps({}, 5, 9);
  CHECK(slope(e.state) > 3.8);
  CHECK(slope(e.quadrature) > 3.8);
  CHECK(slope(e.between) > 3.8);
}

TEST_CASE("exponential_rk4 falls to order 2 where the decay is far too fast for a classical step, but no lower") {
  // h times rate from 6000 to 40: N = rate * target grows with the rate, and a stage knows the target of the one before.
  Errors const e = errors_of_halved_steps({{1e5, 1e4}, 1}, 5, 9);
  CHECK(slope(e.state) > 1.8);
  CHECK(slope(e.quadrature) > 1.8);
  CHECK(slope(e.between) > 1.8);
  CHECK(e.state.back() < 1e-4);
}

TEST_CASE("exponential_rk4 goes on where rk4 is unstable") {
  ExactRelaxation problem{{300, 300}, 1};
  auto const error = [&](Method method, double step) {
    Integrator integrator(problem, fixed(method, step, 2));
    integrator.start(0, problem.start().data());
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
    int first_relaxing_state() const { return 0; }
    std::span<double const> relaxation_rates() const { return rate; }
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
  double const x0 = 5;
  integrator.start(0, &x0);
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
    integrator.start(0, problem.start().data());
    REQUIRE(integrator.advance(3) == Status::ok);
    for (double v : {integrator.states()[0], integrator.states()[1], integrator.quadratures()[0]}) ends.push_back(v);
  }
  for (std::size_t i = 0; i < 3; ++i) CHECK(ends[i] == ends[i + 3]);
}

TEST_CASE("amplification of one step: R(z) of rk4, and exact decay of the exponential form") {
  // A mass on a spring, and a damper's inner node between them that relaxes at 4000 1/s, uncoupled.
  Eigen::MatrixXd a(3, 3);
  a << 0, 1, 0, -1e4, -2, 0, 0, 0, -4000;
  double const rate[] = {4000};
  double const h = 2e-3;
  Eigen::MatrixXd const z = h * a;
  Eigen::MatrixXd const one = Eigen::MatrixXd::Identity(3, 3);
  Eigen::MatrixXd const polynomial = one + z * (one + z / 2 * (one + z / 3 * (one + z / 4)));
  Eigen::MatrixXd const classical = amplification(LinearSystem{a}, Method::rk4, h);
  CHECK((classical - polynomial).cwiseAbs().maxCoeff() < 1e-13 * polynomial.cwiseAbs().maxCoeff());
  CHECK(std::abs(classical(2, 2)) > 1);
  Eigen::MatrixXd const exponential = amplification(LinearSystem{a, 2, rate}, Method::exponential_rk4, h);
  CHECK((exponential.topLeftCorner(2, 2) - polynomial.topLeftCorner(2, 2)).norm() < 1e-12);
  CHECK(exponential(2, 2) == doctest::Approx(std::exp(-8.0)).epsilon(1e-12));
}
