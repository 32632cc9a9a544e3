// rodas4: its numbers against the order conditions, to round-off; what makes it the method for stiff contacts, L-stability and
// published stiff solutions at modest cost.
//
// Source  Hairer, Wanner, Solving ODEs II (1996), IV.7 table 7.1 and (7.15); VI.4 table 4.1 for index-1 equations.
#include <doctest/doctest.h>

#include <algorithm>

#include "integrate/problems.hpp"

namespace tableau = rollerrig::integrate::rodas4_tableau;
using namespace rollerrig;
using namespace rollerrig::test;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

namespace {

// The sums below have about 20 terms of size up to 30 and end at 5e-15.
constexpr double round_off = 2e-14;

/// The method in the textbook's form: k_i = h f(y + sum alpha_ij k_j) + h J sum gamma_ij k_j, y_new = y + sum b_i k_i.
struct Textbook {
  Matrix6 gamma, alpha, beta, omega;  // omega = beta^-1
  Vector6 alpha_sum, beta_sum, gamma_sum;

  Textbook() {
    Matrix6 a = Matrix6::Zero(), c = Matrix6::Zero();
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < std::min(i, 5); ++j) {
        a(i, j) = tableau::a[i][j];
        c(i, j) = tableau::c[i][j];
      }
    }
    auto const inverse = [](Matrix6 const& lower) -> Matrix6 {
      return lower.triangularView<Eigen::Lower>().solve(Matrix6::Identity());
    };
    gamma = inverse(Matrix6::Identity() / tableau::gamma - c);  // (7.24)
    alpha = a * gamma;
    beta = alpha + gamma;
    omega = inverse(beta);
    alpha_sum = alpha.rowwise().sum();
    beta_sum = beta.rowwise().sum();
    gamma_sum = gamma.rowwise().sum();
  }

  /// Weights b of a result y + sum m_j u_j.
  Vector6 weights(Vector6 const& m) const { return gamma.transpose() * m; }
};

Vector6 embedded_sum() {
  Vector6 m = Vector6::Zero();
  for (int j = 0; j < 5; ++j) m[j] = tableau::a[5][j];
  return m;
}

Vector6 solution_sum() { return embedded_sum() + Vector6::Unit(5); }

Textbook const method;
Vector6 const squares = method.alpha_sum.cwiseAbs2();

/// Largest violation of the conditions of order 3 by the solution at theta.
double order_3_defect(Vector6 const& b, double theta = 1) {
  auto const& m = method;
  double const conditions[] = {
      b.sum() - theta,
      b.dot(m.beta_sum) - theta * theta / 2,
      b.dot(squares) - std::pow(theta, 3) / 3,
      b.dot(m.beta * m.beta_sum) - std::pow(theta, 3) / 6,
  };
  return Eigen::Map<Eigen::Vector4d const>(conditions).cwiseAbs().maxCoeff();
}

double order_4_defect(Vector6 const& b) {
  auto const& m = method;
  double const conditions[] = {
      b.dot(squares.cwiseProduct(m.alpha_sum)) - 1.0 / 4,
      b.dot(m.alpha_sum.cwiseProduct(m.alpha * m.beta_sum)) - 1.0 / 8,
      b.dot(m.beta * squares) - 1.0 / 12,
      b.dot(m.beta * (m.beta * m.beta_sum)) - 1.0 / 24,
  };
  return Eigen::Map<Eigen::Vector4d const>(conditions).cwiseAbs().maxCoeff();
}

/// Modulus of the stability function of rodas4 at a + i b.
double amplification(double a, double b) {
  Spiral problem{a, b};
  Integrator integrator(problem, fixed(Method::rodas4, 1, 1));
  integrator.start(0, {1, 0});
  REQUIRE(integrator.advance(1) == Status::ok);
  return std::hypot(integrator.states()[0], integrator.states()[1]);
}

}  // namespace

TEST_CASE("the stage times and time weights of RODAS are the row sums of its matrices") {
  for (int i = 0; i < 6; ++i) {
    CHECK(method.alpha_sum[i] == doctest::Approx(tableau::alpha[i]).epsilon(round_off));
    CHECK(std::abs(method.gamma_sum[i] - tableau::time_weight[i]) < round_off);
  }
}

TEST_CASE("the numbers of RODAS satisfy every condition of order 4") {
  Vector6 const b = method.weights(solution_sum());
  CHECK(order_3_defect(b) < round_off);
  CHECK(order_4_defect(b) < round_off);
}

TEST_CASE("the embedded solution of RODAS is of order 3 and not of order 4") {
  Vector6 const b = method.weights(embedded_sum());
  CHECK(order_3_defect(b) < round_off);
  CHECK(order_4_defect(b) > 1e-2);  // else the difference would estimate nothing
}

TEST_CASE("the dense output of RODAS is of order 3 at every point of the step") {
  for (double theta : {0.1, 0.3, 0.5, 0.8}) {
    Vector6 m = theta * solution_sum();
    for (int j = 0; j < 5; ++j) m[j] += theta * (1 - theta) * (tableau::bend[j] + theta * tableau::cubic[j]);
    CHECK(order_3_defect(method.weights(m), theta) < round_off);
  }
}

TEST_CASE("RODAS is stiffly accurate and keeps order 4 for algebraic equations of index 1") {
  auto const& m = method;
  Vector6 const b = m.weights(solution_sum());
  // Stiffly accurate: b is the last row of beta, so the result satisfies the algebraic equation's linearisation.
  CHECK((b - m.beta.row(5).transpose()).cwiseAbs().maxCoeff() < round_off);
  // Conditions of the algebraic variable, VI.4 table 4.1.
  Eigen::RowVectorXd const b_omega = b.transpose() * m.omega;
  Vector6 const omega_squares = m.omega * squares;
  CHECK(std::abs(b_omega.dot(squares) - 1) < round_off);
  CHECK(std::abs(b_omega.dot(squares.cwiseProduct(m.alpha_sum)) - 1) < round_off);
  CHECK(std::abs(b_omega.dot(m.alpha_sum.cwiseProduct(m.alpha * m.beta_sum)) - 0.5) < round_off);
  CHECK(std::abs(b_omega.dot(m.alpha_sum.cwiseProduct(m.alpha * omega_squares)) - 1) < round_off);
  CHECK(std::abs(b.dot(m.alpha_sum.cwiseProduct(m.alpha * omega_squares)) - 0.25) < round_off);
}

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
  for (double tolerance : {1e-4, 1e-6, 1e-8}) {
    Integrator integrator(problem, adaptive(Method::rodas4, tolerance, 2));
    integrator.start(0, {2, 0});
    REQUIRE(integrator.advance(2) == Status::ok);
    // The limit cycle is attracting: errors of the steps do not pile up.
    CHECK(integrator.states()[0] == doctest::Approx(VanDerPol::published_x0).epsilon(tolerance));
    CHECK(integrator.states()[1] == doctest::Approx(VanDerPol::published_x1).epsilon(tolerance));
  }
}

TEST_CASE("the cost of the published van der Pol problem is what it was") {
  // Counts, not time.  Another compiler may round a step's error to the other side of 1: 3 % margin.
  VanDerPol problem{.epsilon = 1e-6};
  Integrator integrator(problem, adaptive(Method::rodas4, 1e-4, 2));
  integrator.start(0, {2, 0});
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
  Integrator a(plain, fixed(Method::rodas4, 0.05, 10));
  Integrator b(structured, fixed(Method::rodas4, 0.05, 10));
  a.start(0, {1, -0.5});
  b.start(0, {1, -0.5});
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
