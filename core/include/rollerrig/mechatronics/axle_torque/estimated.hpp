// mechatronics/axle_torque/estimated.hpp - the axle's torque as the estimator finds it, late by the estimator's lag.
#pragma once
#include <string_view>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/axle_torque/torque_sample.hpp"

namespace rollerrig {

struct EstimatedTorque {
  static constexpr char const* name = "estimated";
  static constexpr auto fields() { return members(); }

  struct State {};

  double step(State& /*state*/, TorqueSample const& now, double /*period*/) const { return now.estimate; }
};

}  // namespace rollerrig
