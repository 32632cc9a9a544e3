// integrate/options.hpp - what a user may choose, and what a run has cost.
#pragma once
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "rollerrig/fields.hpp"

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
  double step = 0, relative_tolerance = 1e-6;
  std::vector<double> absolute_tolerance = {1e-9};
  double initial_step = 0, maximum_step = std::numeric_limits<double>::infinity();
  double final_time = std::numeric_limits<double>::infinity(), output_step = 0;
  std::vector<double> breakpoints = {};
  std::int64_t max_steps = 100'000'000;  ///< accepted and rejected together

  static constexpr auto fields() {
    using P = Options;
    return members(
        Member{"method", &P::method},
        Member{"step", &P::step, "s", "fixed step; 0 lets the error choose it", not_negative},
        Member{"relative_tolerance", &P::relative_tolerance, "1", "relative tolerance of each state", positive},
        Member{"absolute_tolerance", &P::absolute_tolerance, "m, rad, m/s, rad/s",
               "tolerance of all states, or of each", Range{1e-30, largest_number, "1e-30 or more"}},
        Member{"initial_step", &P::initial_step, "s", "first step; 0 lets the integrator guess", not_negative},
        Member{"maximum_step", &P::maximum_step, "s", "longest step", positive_or_infinite},
        Member{"final_time", &P::final_time, "s", "end of the run, hit exactly",
               Range{0.0, largest_number, "a time", false, true, true}},
        Member{"output_step", &P::output_step, "s", "interval of the outputs; 0: each step's end", not_negative},
        Member{"breakpoints", &P::breakpoints, "s", "times of kinks and jumps of inputs, hit exactly"});
  }
  void check() const {
    need(method >= Method::rk4 && method <= Method::rodas4,
         "unknown method; known: rk4, exponential_rk4, exponential_adams, dormand_prince, rodas4");
  }
};

/// Throws std::invalid_argument for what no integrator of so many states can do.
inline void check_options(Options const& o, int states) {
  check_fields(o, "integrator");
  auto const tolerances = static_cast<int>(o.absolute_tolerance.size());
  o.check();
  bool const free = o.method == Method::dormand_prince || o.method == Method::rodas4;
  need(o.step > 0 || free, "methods rk4, exponential_rk4 and exponential_adams need a step");
  need(tolerances == 1 || tolerances == states, "absolute_tolerance must hold one value, or one per state");
}

/// Counts of one run.  Tests assert them, so that a slower integrator fails a test.
struct Statistics {
  std::int64_t steps = 0;           ///< accepted
  std::int64_t rejected_steps = 0;  ///< error too large, or the system could not be evaluated
  std::int64_t coarse_steps = 0;    ///< kept although the error is too large: a method's shortest one
  std::int64_t derivative_calls = 0;
  std::int64_t jacobian_calls = 0;
  std::int64_t factorisations = 0;
  double smallest_step = std::numeric_limits<double>::infinity();  ///< [s] accepted
  double largest_step = 0;                                         ///< [s] accepted
  double largest_error = 0;                                        ///< of a coarse step, over what is allowed

  static constexpr auto fields() {
    using P = Statistics;
    return members(Member{"steps", &P::steps}, Member{"rejected_steps", &P::rejected_steps},
                   Member{"coarse_steps", &P::coarse_steps}, Member{"derivative_calls", &P::derivative_calls},
                   Member{"jacobian_calls", &P::jacobian_calls}, Member{"factorisations", &P::factorisations},
                   Member{"smallest_step", &P::smallest_step}, Member{"largest_step", &P::largest_step},
                   Member{"largest_error", &P::largest_error});
  }
  void state(auto& archive) {
    for (std::int64_t* count :
         {&steps, &rejected_steps, &coarse_steps, &derivative_calls, &jacobian_calls, &factorisations})
      archive.within(*count, std::int64_t{0}, std::int64_t{1} << 60);
    archive.time(smallest_step);
    archive(largest_step, largest_error);
  }
};

}  // namespace rollerrig::integrate
