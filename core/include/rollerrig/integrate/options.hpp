// integrate/options.hpp - what a user may choose, and what a run has cost.
#pragma once
#include <cstdint>
#include <limits>
#include <vector>

namespace rollerrig::integrate {

enum class Method : int {
  rk4,                ///< classical Runge-Kutta, fixed step
  exponential_rk4,    ///< the same with exact decay of stiff modes (series dampers, creep), fixed step
  exponential_adams,  ///< multistep, exact along a kept Jacobian, steps of one length and its halves: smooth contacts
  dormand_prince,     ///< explicit 5(4), adaptive or fixed step: for tight tolerances on soft systems
  rodas4,             ///< Rosenbrock 4(3), L-stable, adaptive or fixed step: for stiff contacts
};

struct Options {
  Method method = Method::rodas4;
  double step = 0;                                                ///< [s] fixed step; 0 lets the error choose it
  double relative_tolerance = 1e-6;                               ///< [-] of each state
  std::vector<double> absolute_tolerance = {1e-9};                ///< [unit of the state] one, or one per state
  double initial_step = 0;                                        ///< [s] 0 lets the integrator guess
  double maximum_step = std::numeric_limits<double>::infinity();  ///< [s]
  double final_time = std::numeric_limits<double>::infinity();    ///< [s] hit exactly
  double output_step = 0;                                         ///< [s] grid of outputs; 0: every step's end
  std::vector<double> breakpoints = {};                           ///< [s] hit exactly: kinks and jumps of inputs
  std::int64_t max_steps = 100'000'000;                           ///< accepted and rejected together
};

/// Counts of one run.  Tests assert them, so that a slower integrator fails a test.
struct Statistics {
  std::int64_t steps = 0;           ///< accepted
  std::int64_t rejected_steps = 0;  ///< error too large, or the system could not be evaluated
  std::int64_t derivative_calls = 0;
  std::int64_t jacobian_calls = 0;
  std::int64_t factorisations = 0;
  double smallest_step = std::numeric_limits<double>::infinity();  ///< [s] accepted
  double largest_step = 0;                                         ///< [s] accepted
};

}  // namespace rollerrig::integrate
