// What makes rodas4 the method for stiff contacts: L-stability, and published stiff solutions at modest cost.
#include <doctest/doctest.h>

#include "integrate/problems.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

/// Modulus of the stability function of rodas4 at a + i b.
double amplification(double a, double b) {
  Spiral problem{a, b};
  Integrator integrator(problem, fixed(Method::rodas4, 1, 1));
  double const x0[] = {1, 0};
  integrator.start(0, x0);
  REQUIRE(integrator.advance(1) == Status::ok);
  return std::hypot(integrator.states()[0], integrator.states()[1]);
}

}  // namespace

TEST_CASE("rodas4 wipes out an infinitely fast decay in one step") {
  // |R(z)| falls as 1/|z|, with a constant below 10.
  for (double rate : {1e4, 1e8, 1e12}) CHECK(amplification(-rate, 0) < 10 / rate);
}

TEST_CASE("rodas4 amplifies no oscillation, however coarse the step") {
  for (double phase : {0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 10.0, 100.0, 1e4, 1e8}) {
    CHECK(amplification(0, phase) <= 1 + 1e-14);  // round-off of a few operations
    CHECK(amplification(-0.1 * phase, phase) < 1);
  }
}

TEST_CASE("rodas4 reproduces the published van der Pol solution within the tolerance") {
  VanDerPol problem{.epsilon = 1e-6};
  double const start[] = {2, 0};
  for (double tolerance : {1e-4, 1e-6, 1e-8}) {
    Integrator integrator(problem, adaptive(Method::rodas4, tolerance, 2));
    integrator.start(0, start);
    REQUIRE(integrator.advance(2) == Status::ok);
    // The limit cycle is attracting: errors of the steps do not pile up.
    CHECK(integrator.states()[0] == doctest::Approx(VanDerPol::published_x0).epsilon(tolerance));
    CHECK(integrator.states()[1] == doctest::Approx(VanDerPol::published_x1).epsilon(tolerance));
  }
}

TEST_CASE("the cost of the published van der Pol problem is what it was") {
  // Counts, not time.  Another compiler may round a step's error to the other side of 1: 3 % margin.
  VanDerPol problem{.epsilon = 1e-6};
  double const start[] = {2, 0};
  Integrator integrator(problem, adaptive(Method::rodas4, 1e-4, 2));
  integrator.start(0, start);
  REQUIRE(integrator.advance(2) == Status::ok);
  auto const& s = integrator.statistics();
  CHECK(s.steps == doctest::Approx(311).epsilon(0.03));
  CHECK(s.rejected_steps <= 18);
  CHECK(s.jacobian_calls == s.steps);                                   // one per step, none for a repetition
  CHECK(s.factorisations == s.steps + s.rejected_steps);                // one per attempt
  CHECK(s.derivative_calls == 6 * s.steps + 5 * s.rejected_steps + 1);  // + 1: guess of the first step
  CHECK(s.smallest_step < 1e-6);                                        // the fast phases ...
  CHECK(s.largest_step > 1e-2);                                         // ... and the slow ones
}

TEST_CASE("declaring kinematic states changes the cost of a step but not its result") {
  Oscillator plain{.omega = 3, .declare_kinematic = false};
  Oscillator structured{.omega = 3, .declare_kinematic = true};
  double const start[] = {1, -0.5};
  Integrator a(plain, fixed(Method::rodas4, 0.05, 10));
  Integrator b(structured, fixed(Method::rodas4, 0.05, 10));
  a.start(0, start);
  b.start(0, start);
  REQUIRE(a.advance(10) == Status::ok);
  REQUIRE(b.advance(10) == Status::ok);
  // Exact elimination: only the round-off of 200 steps differs.
  CHECK(a.states()[0] == doctest::Approx(b.states()[0]).epsilon(1e-12));
  CHECK(a.states()[1] == doctest::Approx(b.states()[1]).epsilon(1e-12));
}

TEST_CASE("the block elimination solves the full system of states and quadratures") {
  int const n = 7, m = 2, q = 3;
  JacobianData j({n, m});
  j.a.setRandom();
  j.g.setRandom();
  j.a.topRows(q).setZero();
  std::vector<int> const columns = {5, 3, 6};  // in no particular order
  for (int i = 0; i < q; ++i) j.a(i, columns[i]) = 1;

  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(n + m, n + m);
  full.topLeftCorner(n, n) = j.a;
  full.bottomLeftCorner(m, n) = j.g;
  double const shift = 40;
  Eigen::VectorXd const right = Eigen::VectorXd::Random(n + m);
  for (auto const& eliminated : {columns, std::vector<int>{}}) {
    integrate::ShiftedSolver solver({n, m}, eliminated);
    solver.factor(j, shift);
    Eigen::VectorXd k = right;
    solver.solve(k);
    CHECK((shift * k - full * k - right).norm() < 1e-14);  // round-off of numbers of size 1
  }
}
