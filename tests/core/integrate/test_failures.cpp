// How a run ends early: named, in time, with everything up to there kept.
#include <doctest/doctest.h>

#include <set>

#include "integrate/problems.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

/// x' = rate until x reaches a wall behind which nothing can be evaluated.
struct Wall {
  double wall = 1;
  double rate = 1;
  Status beyond = Status::off_profile;
  double accepted_until = 1e9;
  int accepted_calls = 0;

  Sizes sizes() const { return {1, 1}; }
  Status derivative(double, double const* x, double* x_dot, double* z_dot) const {
    if (x[0] > wall) return beyond;
    x_dot[0] = rate;
    if (z_dot != nullptr) z_dot[0] = x[0];
    return Status::ok;
  }
  Status jacobian(double, double const*, JacobianData& j) const {
    j.a << 0;
    j.g << 1;
    return Status::ok;
  }
  Status accept(double, double const* x) {
    ++accepted_calls;
    return x[0] > accepted_until ? Status::derailed : Status::ok;
  }
};

}  // namespace

TEST_CASE("a system that cannot be evaluated ends the run with its own status, close to where it is") {
  for (Method method : {Method::dormand_prince, Method::rodas4}) {
    Wall problem;
    Options o = adaptive(method, 1e-6, 5);
    o.output_step = 0.25;
    Integrator integrator(problem, o);
    integrator.start(0, {0});
    int outputs = 0;
    auto const count = [&](double, double const*, double const*) { ++outputs; };
    CHECK(integrator.advance(5, count) == Status::off_profile);
    // Halving ends below 16 units in the last place of 1 s.
    CHECK(integrator.time() == doctest::Approx(1).epsilon(1e-13));
    CHECK(integrator.time() <= 1);
    CHECK(outputs >= 4);                                  // 0, 0.25, 0.5, 0.75, and 1 if the last step came that near
    CHECK(integrator.advance(5) == Status::off_profile);  // and stays so
    CHECK(integrator.status() == Status::off_profile);
  }
}

TEST_CASE("fixed steps end before the step that fails") {
  for (Method method : all_methods) {
    Wall problem;
    Integrator integrator(problem, fixed(method, 0.3, 5));
    integrator.start(0, {0});
    CHECK(integrator.advance(5) == Status::off_profile);
    if (keeps_its_step(method))
      CHECK(integrator.time() == doctest::Approx(0.9));
    else
      CHECK(integrator.time() > 0.9);
    CHECK(integrator.time() <= 1.0);
  }
}

TEST_CASE("a trial stage behind the wall is only a rejected step when the solution stays in front") {
  // A stiff pull to x = 0.5 from 0, tried with a first step of 1 s: the explicit stages overshoot far.
  struct Pull : Wall {
    Status derivative(double, double const* x, double* x_dot, double* z_dot) const {
      if (x[0] > wall) return Status::contact_lost;
      x_dot[0] = -100 * (x[0] - 0.5);
      z_dot[0] = 0;
      return Status::ok;
    }
  } problem;
  Options o = adaptive(Method::dormand_prince, 1e-6, 2);
  o.initial_step = 1;
  Integrator integrator(problem, o);
  integrator.start(0, {0});
  CHECK(integrator.advance(2) == Status::ok);
  CHECK(integrator.statistics().rejected_steps > 0);
  CHECK(integrator.states()[0] == doctest::Approx(0.5).epsilon(1e-6));
}

TEST_CASE("the system's own check after a step ends the run and keeps the step") {
  for (Method method : all_methods) {
    Wall problem;
    problem.accepted_until = 0.5;
    problem.wall = 100;
    Options o = fixed(method, 0.2, 5);
    Integrator integrator(problem, o);
    integrator.start(0, {0});
    CHECK(problem.accepted_calls == 1);  // the start is checked too
    CHECK(integrator.advance(5) == Status::derailed);
    CHECK(integrator.time() == doctest::Approx(0.6));
    CHECK(integrator.states()[0] == doctest::Approx(0.6));
    if (keeps_its_step(method)) CHECK(problem.accepted_calls == 4);
  }
}

TEST_CASE("a state that is not a number is noticed at the step where it appears") {
  auto rate = [](double t, double) { return t < 0.5 ? 1.0 : NAN; };
  for (Method method : all_methods) {
    Scalar1 problem{rate};
    Integrator integrator(problem, needs_step(method) ? fixed(method, 0.01, 1) : adaptive(method, 1e-6, 1));
    integrator.start(0, {0});
    CHECK(integrator.advance(1) == Status::not_finite);
    CHECK(integrator.time() <= 0.5);
    CHECK(integrator.time() > 0.48);
  }
  Oscillator problem;
  Integrator integrator(problem, Options{});
  CHECK(integrator.start(0, {1, NAN}) == Status::not_finite);
}

TEST_CASE("a solution that goes to infinity ends at its pole, in steps that are too small or not finite") {
  // x' = x^2, x(0) = 1 has its pole at t = 1.
  struct Pole {
    Sizes sizes() const { return {1, 0}; }
    Status derivative(double, double const* x, double* x_dot, double*) const {
      x_dot[0] = x[0] * x[0];
      return Status::ok;
    }
    Status jacobian(double, double const* x, JacobianData& j) const {
      j.a << 2 * x[0];
      return Status::ok;
    }
  } problem;
  for (Method method : {Method::dormand_prince, Method::rodas4}) {
    Integrator integrator(problem, adaptive(method, 1e-8, 2));
    integrator.start(0, {1});
    Status const end = integrator.advance(2);
    CHECK((end == Status::not_finite || end == Status::step_too_small));
    CHECK(integrator.time() == doctest::Approx(1).epsilon(1e-6));
  }
}

TEST_CASE("a rate that turns round faster than time can be told ends with a step that is too small, where it begins") {
  auto rate = [](double t, double x) { return t < 0.5 ? 0.0 : x < 0.0 ? 1e20 : -1e20; };
  for (Method method : {Method::dormand_prince, Method::rodas4}) {
    Scalar1 problem{rate};
    Integrator integrator(problem, adaptive(method, 1e-6, 1));
    integrator.start(0, {0});
    CHECK(integrator.advance(1) == Status::step_too_small);
    CHECK(integrator.time() == doctest::Approx(0.5).epsilon(1e-13));
  }
}

TEST_CASE("the budget of steps is kept") {
  Oscillator problem;
  Options o = fixed(Method::rk4, 0.01, 10);
  o.max_steps = 37;
  Integrator integrator(problem, o);
  integrator.start(0, {1, 0});
  CHECK(integrator.advance(10) == Status::too_many_steps);
  CHECK(integrator.statistics().steps == 37);
}

TEST_CASE("an integrator can be started again and forgets its past") {
  VanDerPol problem{.epsilon = 1e-2};
  Integrator integrator(problem, adaptive(Method::rodas4, 1e-6, 1));
  double first[2];
  for (int i : {0, 1}) {
    integrator.start(0, {2, -0.66});
    REQUIRE(integrator.advance(1) == Status::ok);
    first[i] = integrator.states()[0];
  }
  CHECK(first[0] == first[1]);
}

TEST_CASE("every status has its own sentence, with a remedy") {
  std::set<std::string_view> sentences;
  for (int i = 0; i <= static_cast<int>(Status::interrupted); ++i) {
    std::string_view const sentence = status_sentence(static_cast<Status>(i));
    CHECK(sentence.ends_with('.'));
    CHECK(sentence.find("Unknown") == std::string_view::npos);
    sentences.insert(sentence);
  }
  CHECK(sentences.size() == static_cast<std::size_t>(Status::interrupted) + 1);
}
