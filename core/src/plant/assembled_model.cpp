#include "rollerrig/plant/assembled_model.hpp"

#include <stdexcept>

#include "rollerrig/simulate/driver.hpp"

namespace rollerrig {
namespace {

constexpr Range within_reach{0.0, 1e5, "within 1e5 m, rad, m/s, rad/s", false, false, true};

}  // namespace

void check_assembled(AssembledModel const& assembled) {
  auto const need = [](bool condition, char const* message) {
    if (!condition) throw std::invalid_argument(message);
  };
  PartNames const& names = assembled.names;
  need(assembled.model != nullptr, "assembled model: there is no model");
  Model const& model = *assembled.model;
  need(names.bodies.size() == model.bodies.size(), "assembled model: names: needed is one per body");
  need(names.elements.size() == model.elements.size(), "assembled model: names: needed is one per element");
  need(names.axles.size() == (assembled.setup ? assembled.setup->axles.size() : 0),
       "assembled model: names: needed is one per axle");
  if (assembled.setup) check_setup(*assembled.setup, model);
  check_value(assembled.start, within_reach, "assembled model", "x0");
  need(static_cast<int>(assembled.start.size()) == model.map.states(), "assembled model: x0: needed is one per state");
  check_disturbances(assembled.disturbances, model);
  integrate::check_options(assembled.options, model.map.states(), true);
  check_settings(assembled.options, assembled.start_time, assembled.setup ? assembled.setup->step : 0.0);
}

}  // namespace rollerrig
