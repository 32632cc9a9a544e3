// Where the steps fall: breakpoints, output grids, slices of a run, and how a run can end.
#include <doctest/doctest.h>

#include <algorithm>
#include <stdexcept>

#include "integrate/problems.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

using Record = std::vector<double>;  // t, x..., z... of every output, one after the other

template <class System>
auto recorder(System const& system, Record& record) {
  return
      [n = system.sizes().states, m = system.sizes().quadratures, &record](double t, double const* x, double const* z) {
        record.push_back(t);
        record.insert(record.end(), x, x + n);
        record.insert(record.end(), z, z + m);
      };
}

Options options_for(Method method, double final_time) {
  return needs_step(method) ? fixed(method, 0.013, final_time) : adaptive(method, 1e-6, final_time);
}

}  // namespace

TEST_CASE("slicing a run changes no bit of its outputs, its end or its cost") {
  ExactOscillation problem;
  for (Method method : all_methods) {
    Options o = options_for(method, 5);
    o.output_step = 0.1;
    o.breakpoints = {1.7, 3.3};

    Record whole, sliced;
    Integrator a(problem, o);
    a.start(0, problem.start());
    REQUIRE(a.advance(5, recorder(problem, whole)) == Status::ok);

    Integrator b(problem, o);
    b.start(0, problem.start());
    for (double stop : {0.0, 0.05, 0.1, 0.100001, 0.77, 1.7, 1.70001, 2.0, 2.0, 4.9999999, 5.0, 9.0})
      REQUIRE(b.advance(stop, recorder(problem, sliced)) == Status::ok);

    CHECK(whole.size() == 51 * 4);
    CHECK(whole == sliced);
    CHECK(std::equal(a.states(), a.states() + 2, b.states()));
    CHECK(a.quadratures()[0] == b.quadratures()[0]);
    CHECK(a.statistics().derivative_calls == b.statistics().derivative_calls);
  }
}

TEST_CASE("the output grid does not influence the steps") {
  ExactOscillation problem;
  for (Method method : all_methods) {
    std::vector<double> ends;
    for (double output_step : {0.0, 0.001, 0.37}) {
      Options o = options_for(method, 5);
      o.output_step = output_step;
      Integrator integrator(problem, o);
      integrator.start(0, problem.start());
      REQUIRE(integrator.advance(5) == Status::ok);
      ends.push_back(integrator.states()[0]);
    }
    CHECK(ends[0] == ends[1]);
    CHECK(ends[0] == ends[2]);
  }
}

TEST_CASE("an output step that is a multiple of a fixed step returns the steps themselves") {
  Oscillator problem;
  Options o = fixed(Method::rk4, 0.01, 1);
  Record every_step, grid;
  for (auto [output_step, record] : {std::pair{0.0, &every_step}, std::pair{0.05, &grid}}) {
    o.output_step = output_step;
    Integrator integrator(problem, o);
    integrator.start(0, {1, 0});
    REQUIRE(integrator.advance(1, recorder(problem, *record)) == Status::ok);
  }
  REQUIRE(every_step.size() == 101 * 3);
  REQUIRE(grid.size() == 21 * 3);
  for (int i = 0; i <= 20; ++i) {
    CHECK(grid[3 * i] == doctest::Approx(0.05 * i));
    CHECK(grid[3 * i + 1] == every_step[15 * i + 1]);  // bitwise
    CHECK(grid[3 * i + 2] == every_step[15 * i + 2]);
  }
}

TEST_CASE("breakpoints are hit exactly, and a jump there costs no accuracy") {
  // x' = 1 before 1/3, 3 between, -2 behind 0.71: integrated exactly by any method that never steps across a jump.
  auto rate = [](double t, double) { return t < 1.0 / 3 ? 1.0 : t < 0.71 ? 3.0 : -2.0; };
  double const exact = 1.0 / 3 + 3 * (0.71 - 1.0 / 3) - 2 * (1 - 0.71);
  for (Method method : all_methods) {
    for (double step : {0.0, 0.1}) {
      if (needs_step(method) && step == 0) continue;
      Scalar1 problem{rate};
      Options o = fixed(method, step, 1);
      o.breakpoints = {0.71, 1.0 / 3, 1.0 / 3, -5, 8};  // any order, double, outside
      Integrator integrator(problem, o);
      integrator.start(0, {0});
      std::vector<double> ends;
      REQUIRE(integrator.advance(1, [&](double t, double const*, double const*) { ends.push_back(t); }) == Status::ok);
      CHECK(std::count(ends.begin(), ends.end(), 1.0 / 3) == 1);
      CHECK(std::count(ends.begin(), ends.end(), 0.71) == 1);
      CHECK(ends.back() == 1);
      if (step > 0 && keeps_its_step(method))
        CHECK(integrator.statistics().steps == 12);  // the grid goes on behind the two extra ends
      CHECK(integrator.states()[0] == doctest::Approx(exact).epsilon(1e-14));
      CHECK(integrator.statistics().rejected_steps == 0);
    }
  }
}

TEST_CASE("a fixed step that does not divide the duration ends at the final time") {
  Oscillator problem;
  Integrator integrator(problem, fixed(Method::rk4, 0.3, 1));
  integrator.start(0, {1, 0});
  REQUIRE(integrator.advance(1e9) == Status::ok);
  CHECK(integrator.time() == 1);
  CHECK(integrator.statistics().steps == 4);
  CHECK(integrator.statistics().smallest_step == doctest::Approx(0.1));
  CHECK(integrator.statistics().largest_step == 0.3);
}

TEST_CASE("fixed steps do not drift off their grid in a long run") {
  Oscillator problem;
  Integrator integrator(problem, fixed(Method::rk4, 1e-3, 100));
  integrator.start(0, {1, 0});
  REQUIRE(integrator.advance(100) == Status::ok);
  CHECK(integrator.statistics().steps == 100'000);
  CHECK(integrator.statistics().smallest_step == 1e-3);
}

TEST_CASE("rk4 loses the energy of an oscillator as its stability function says") {
  // |R(i y)|^2 = 1 - y^6/72 + y^8/576 per step of phase y.
  Oscillator problem{.omega = 2};
  double const y = 0.2;
  int const steps = 500;
  Integrator integrator(problem, fixed(Method::rk4, y / problem.omega, steps * y / problem.omega));
  std::vector<double> const start = {1, 0};
  integrator.start(0, start);
  REQUIRE(integrator.advance(1e9) == Status::ok);
  double const expected = std::pow(1 - std::pow(y, 6) / 72 + std::pow(y, 8) / 576, steps);
  CHECK(problem.energy(integrator.states()) / problem.energy(start.data()) == doctest::Approx(expected).epsilon(1e-12));
}

TEST_CASE("adaptive methods keep the energy of an oscillator in proportion to the tolerance") {
  Oscillator problem{.omega = 2};
  std::vector<double> const start = {1, 0};
  for (Method method : {Method::dormand_prince, Method::rodas4}) {
    for (double tolerance : {1e-6, 1e-9}) {
      Integrator integrator(problem, adaptive(method, tolerance, 100));
      integrator.start(0, start);
      REQUIRE(integrator.advance(100) == Status::ok);
      double const drift = problem.energy(integrator.states()) / problem.energy(start.data()) - 1;
      // At most one tolerance per step, twice for energy, and each step advances the phase by 0.01 or more.
      CHECK(std::abs(drift) < 2 * tolerance * static_cast<double>(integrator.statistics().steps));
    }
  }
}

TEST_CASE("the largest step is respected") {
  Oscillator problem{.omega = 1e-3};
  Options o = adaptive(Method::rodas4, 1e-4, 10);
  o.maximum_step = 0.25;
  Integrator integrator(problem, o);
  integrator.start(0, {1, 0});
  REQUIRE(integrator.advance(10) == Status::ok);
  CHECK(integrator.statistics().largest_step <= 0.25);
  CHECK(integrator.statistics().steps < 55);  // 40 of full length and the growth from the first guess
}

TEST_CASE("each state can have its own absolute tolerance") {
  // The second state is tiny and must be resolved only where its own tolerance asks for it.
  ExactOscillation problem;
  Options loose = adaptive(Method::rodas4, 1e-8, 2), tight = loose;
  loose.absolute_tolerance = {1e-2, 1e-2};
  tight.absolute_tolerance = {1e-2, 1e-10};
  long steps[2];
  for (int i : {0, 1}) {
    Integrator integrator(problem, i == 0 ? loose : tight);
    integrator.start(0, problem.start());
    REQUIRE(integrator.advance(2) == Status::ok);
    steps[i] = integrator.statistics().steps;
  }
  CHECK(steps[1] > 3 * steps[0]);
}

TEST_CASE("the dense output can be asked anywhere in the last step") {
  ExactOscillation problem;
  Integrator integrator(problem, adaptive(Method::dormand_prince, 1e-8, 5));
  integrator.start(0, problem.start());
  REQUIRE(integrator.advance(3) == Status::ok);
  CHECK(integrator.time() >= 3);
  CHECK(integrator.step_start() < 3);
  double x[2], z;
  integrator.sample(3, x, &z);
  CHECK(x[0] == doctest::Approx(problem.x0(3)).epsilon(1e-6));
  CHECK(z == doctest::Approx(problem.z(3)).epsilon(1e-6));
  integrator.sample(integrator.time(), x, &z);
  CHECK(x[0] == integrator.states()[0]);
}

TEST_CASE("impossible options are refused by name") {
  Oscillator problem;
  auto const refused = [&](auto change) {
    Options o;
    change(o);
    CHECK_THROWS_AS(Integrator(problem, o), std::invalid_argument);
  };
  refused([](Options& o) { o.method = Method::rk4; });  // without a step
  refused([](Options& o) { o.step = -1; });
  refused([](Options& o) { o.relative_tolerance = 0; });
  refused([](Options& o) { o.absolute_tolerance = {}; });
  refused([](Options& o) { o.absolute_tolerance = {1, 1, 1}; });
  refused([](Options& o) { o.absolute_tolerance = {1, -1}; });
  refused([](Options& o) { o.maximum_step = 0; });
  refused([](Options& o) { o.breakpoints = {NAN}; });
}
