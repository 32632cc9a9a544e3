// Each method against exact solutions: the error must fall with its order when the step is halved.
#include <doctest/doctest.h>

#include <algorithm>

#include "integrate/problems.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

// The slopes are means over three or four halvings; 0.2 below the theory allows for the next term of the error.

TEST_CASE("rk4 has order 4 in states and quadratures, and its Hermite output too") {
  Errors const e = errors_of_halved_steps(ExactOscillation{}, Method::rk4, 4, 8);
  CHECK(slope(e.state) > 3.8);
  CHECK(slope(e.quadrature) > 3.8);
  CHECK(slope(e.between) > 3.8);
}

TEST_CASE("dormand_prince has order 5 in states and quadratures, and its output of order 4 keeps up") {
  Errors const e = errors_of_halved_steps(ExactOscillation{}, Method::dormand_prince, 3, 6);
  CHECK(slope(e.state) > 4.8);
  CHECK(slope(e.quadrature) > 4.8);
  CHECK(slope(e.between) > 4.8);
}

TEST_CASE("rodas4 has order 4 in states and quadratures, and its output of order 3 keeps up") {
  Errors const e = errors_of_halved_steps(ExactOscillation{}, Method::rodas4, 4, 8);
  CHECK(slope(e.state) > 3.8);
  CHECK(slope(e.quadrature) > 3.8);
  CHECK(slope(e.between) > 3.8);
}

TEST_CASE("rodas4 keeps order 4 in the stiff limit, its output between the steps order 3") {
  // h times stiffness > 1e4 throughout: the problem acts as a differential-algebraic one of index 1.
  Errors const e = errors_of_halved_steps(ExactOscillation{.stiffness = 1e7}, Method::rodas4, 4, 8);
  CHECK(slope(e.state) > 3.8);
  CHECK(slope(e.quadrature) > 3.8);
  CHECK(slope(e.between) > 2.8);
}

TEST_CASE("rodas4 between soft and stiff loses order in the stiff state only, at small errors") {
  // h times stiffness from 600 to 40: every Rosenbrock method with classical order conditions loses order here
  // (Hairer, Wanner II, IV.15).  The error is of size 1 / stiffness times a small power of h; what the stiff state
  // drives, here the quadrature, hardly notices.
  Errors const e = errors_of_halved_steps(ExactOscillation{.stiffness = 1e4}, Method::rodas4, 5, 9);
  CHECK(slope(e.state) > 1.2);
  CHECK(e.state.front() < 1e-6);
  CHECK(slope(e.quadrature) > 3.5);
}

TEST_CASE("rodas4 has order 4 on the van der Pol oscillator") {
  VanDerPol problem{.epsilon = 1e-2};
  auto const solve = [&](Options const& o) {
    Integrator integrator(problem, o);
    integrator.start(0, {2, -0.66});
    REQUIRE(integrator.advance(0.5) == Status::ok);
    return integrator.states()[0];
  };
  double const reference = solve(adaptive(Method::rodas4, 1e-13, 0.5));
  std::vector<double> errors;
  for (int k = 5; k <= 8; ++k)
    errors.push_back(std::abs(solve(fixed(Method::rodas4, 0.5 / (1 << k), 0.5)) - reference));
  CHECK(slope(errors) > 3.7);
}

TEST_CASE("all methods integrate a cubic in time exactly") {
  // The conditions of the bushy trees, to round-off: 20 steps of numbers below 5.
  struct Cubic : Scalar1 {
    Status jacobian(double t, double const*, JacobianData& j) const {
      j.a << 0;
      j.f_t << 12 * t * t - 6 * t;
      return Status::ok;
    }
  };
  for (Method method : all_methods) {
    Cubic problem{{[](double t, double) { return 4 * t * t * t - 3 * t * t + 1; }}};
    Integrator integrator(problem, fixed(method, 0.1, 2));
    integrator.start(0, {1});
    REQUIRE(integrator.advance(2) == Status::ok);
    CHECK(integrator.states()[0] == doctest::Approx(1 + 16 - 8 + 2).epsilon(1e-14));
  }
}

TEST_CASE("a tighter tolerance gives a smaller error, in proportion") {
  for (Method method : {Method::dormand_prince, Method::rodas4}) {
    for (double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
      ExactOscillation problem;
      Integrator integrator(problem, adaptive(method, tolerance, 10));
      integrator.start(0, problem.start());
      REQUIRE(integrator.advance(10) == Status::ok);
      // The control bounds the error of a step; the problem is neutral to mildly unstable over 10 s, so the error
      // of the run is that of a step times a moderate factor.
      CHECK(std::abs(integrator.states()[0] - problem.x0(10)) < 100 * tolerance);
      CHECK(std::abs(integrator.quadratures()[0] - problem.z(10)) < 1000 * tolerance);
    }
  }
}
