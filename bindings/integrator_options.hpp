// bindings/integrator_options.hpp - the settings of an integrator, by the names that Python knows.
#pragma once
#include <algorithm>
#include <array>
#include <string>

#include "convert.hpp"
#include "rollerrig/integrate/options.hpp"

inline constexpr std::array<char const*, 5> method_names{"rk4", "exponential_rk4", "exponential_adams",
                                                         "dormand_prince", "rodas4"};  ///< of integrate::Method

inline rollerrig::integrate::Method method_named(std::string const& name) {
  auto const found = std::find(method_names.begin(), method_names.end(), name);
  if (found == method_names.end())
    throw nb::value_error("unknown method; known: rk4, exponential_rk4, exponential_adams, dormand_prince, rodas4");
  return static_cast<rollerrig::integrate::Method>(found - method_names.begin());
}

/// Outputs are the caller's matter.
inline rollerrig::integrate::Options integrator_options(std::string const& method, double step, double relative,
                                                        std::vector<double> const& absolute, double initial_step,
                                                        double maximum_step, double final_time,
                                                        std::vector<double> const& breakpoints) {
  rollerrig::integrate::Options options;
  options.method = method_named(method);
  options.step = step;
  options.relative_tolerance = relative;
  options.absolute_tolerance = absolute;
  options.initial_step = initial_step;
  options.maximum_step = maximum_step;
  options.final_time = final_time;
  options.breakpoints = breakpoints;
  return options;
}
