// Stepping must not allocate: a run's time is its own, and its memory is flat.
//
// glibc lets a program replace malloc; ours counts and passes on.  operator new and Eigen end here as well.
// Sanitizers bring their own malloc, other C libraries know no __libc_malloc: there the count stays 0.
#include <doctest/doctest.h>

#include <cstdlib>

#include "integrate/problems.hpp"
#include "rollerrig/simulate/recorder.hpp"
#include "system/models.hpp"

namespace {
thread_local long allocations = 0;
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
constexpr bool malloc_is_counted = true;
extern "C" {
void* __libc_malloc(std::size_t);
void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
}
#else
constexpr bool malloc_is_counted = false;
#endif

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

/// A chain of bodies between springs and dampers: enough states that Eigen takes its blocked paths.
struct Chain {
  static constexpr int bodies = 26;
  Sizes sizes() const { return {2 * bodies, 3}; }
  int kinematic_states() const { return declare_kinematic ? bodies : 0; }
  int velocity_column(int i) const { return bodies + i; }
  bool declare_kinematic = true;

  Status derivative(double, double const* x, double* x_dot, double* z_dot) const {
    for (int i = 0; i < bodies; ++i) {
      double const left = i == 0 ? 0.0 : x[i - 1];
      double const right = i == bodies - 1 ? 0.0 : x[i + 1];
      x_dot[i] = x[bodies + i];
      x_dot[bodies + i] = 1e4 * (left - 2 * x[i] + right) - 5 * x[bodies + i];
    }
    if (z_dot != nullptr) z_dot[0] = x[0], z_dot[1] = x[1], z_dot[2] = x[2];
    return Status::ok;
  }
  Status jacobian(double, double const*, JacobianData& j) const {
    j.a.setZero();
    j.g.setZero();
    for (int i = 0; i < bodies; ++i) {
      j.a(i, bodies + i) = 1;
      j.a(bodies + i, i) = -2e4;
      if (i > 0) j.a(bodies + i, i - 1) = 1e4;
      if (i < bodies - 1) j.a(bodies + i, i + 1) = 1e4;
      j.a(bodies + i, bodies + i) = -5;
    }
    for (int i = 0; i < 3; ++i) j.g(i, i) = 1;
    return Status::ok;
  }
};

}  // namespace

TEST_CASE("the counter of allocations counts") {
  long const before = allocations;
  Eigen::VectorXd const probe = Eigen::VectorXd::Zero(100);
  std::vector<double> const other(100);
  CHECK(probe[99] + other[99] == 0);
  CHECK(allocations - before == (malloc_is_counted ? 2 : 0));
}

TEST_CASE("starting, stepping, breakpoints and outputs allocate nothing") {
  std::vector<double> start(2 * Chain::bodies, 0.0);
  start[3] = 0.01;
  for (Method method : all_methods) {
    for (bool declare_kinematic : {false, true}) {
      for (double step : {0.0, 1e-3}) {
        if (needs_step(method) && step == 0) continue;
        Chain problem;
        problem.declare_kinematic = declare_kinematic;
        Options o = fixed(method, step, 0.2);
        o.output_step = 7e-4;
        o.breakpoints = {0.05, 0.1};
        Integrator integrator(problem, o);
        double sum = 0;
        auto const observe = [&](double, double const* x, double const* z) { sum += x[0] + z[0]; };

        long const before = allocations;
        Status const status_at_start = integrator.start(0, start);
        Status const status = integrator.advance(0.2, observe);
        long const during = allocations - before;

        REQUIRE(status_at_start == Status::ok);
        REQUIRE(status == Status::ok);
        CHECK(during == 0);
      }
    }
  }
}

TEST_CASE("a wheelset that runs on rollers, its contact search and its recorder allocate nothing") {
  auto const model = wheelset_model({});
  Dynamics dynamics(model), observed(model);
  Recorder const recorder(*model);
  std::vector<double> row(static_cast<std::size_t>(recorder.width()));
  auto const start = solve_equilibrium(dynamics, 20.0, 0.0, {{0, coord_y, 2e-3}});  // released 2 mm aside
  REQUIRE(start.converged);
  for (Method method : all_methods) {
    Options o = fixed(method, needs_step(method) ? 1e-4 : 0.0, 0.2);
    o.output_step = 7e-4;
    Integrator integrator(dynamics, o);
    Integrator::Observer const observe = [&](double t, double const* x, double const* z) {
      recorder.record(observed, t, x, z, row.data());
    };

    long const before = allocations;
    Status const status_at_start = integrator.start(0, start.x);
    Status const status = integrator.advance(0.2, observe);
    long const during = allocations - before;

    REQUIRE(status_at_start == Status::ok);
    REQUIRE(status == Status::ok);
    CHECK(during == 0);
  }
}
