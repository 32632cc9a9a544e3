// bindings/plant.cpp - an assembled model, and the plant that other tools drive.
#include "rollerrig/plant/plant.hpp"

#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>

#include <cmath>
#include <limits>
#include <map>

#include "arguments.hpp"
#include "fields.hpp"
#include "integrator_options.hpp"
#include "rollerrig/plant/continuous_plant.hpp"
#include "rollerrig/plant/controller_plant.hpp"
#include "rollerrig/plant/model_file.hpp"

using namespace nb::literals;
using namespace rollerrig;

namespace {

constexpr char const* causalities[] = {"input", "output", "parameter", "local"};
constexpr char const* variabilities[] = {"fixed", "tunable", "discrete", "continuous"};

void bind_variable(nb::module_& m) {
  nb::class_<Variable>(m, "Variable", "A number of a plant that a tool may set or read.")
      .def_ro("name", &Variable::name)
      .def_ro("unit", &Variable::unit)
      .def_ro("description", &Variable::description)
      .def_prop_ro("causality", [](Variable const& v) { return causalities[static_cast<int>(v.causality)]; })
      .def_prop_ro("variability", [](Variable const& v) { return variabilities[static_cast<int>(v.variability)]; })
      .def_ro("start", &Variable::start)
      .def_ro("least", &Variable::least)
      .def_ro("most", &Variable::most)
      .def_ro("whole", &Variable::whole);
}

nb::dict settings(AssembledModel const& self) {
  auto const& o = self.options;
  nb::dict d;
  d["method"] = method_names[static_cast<std::size_t>(o.method)];
  d["step"] = o.step;
  d["relative_tolerance"] = o.relative_tolerance;
  d["absolute_tolerance"] = o.absolute_tolerance;
  d["initial_step"] = o.initial_step;
  d["maximum_step"] = o.maximum_step;
  d["final_time"] = o.final_time;
  d["breakpoints"] = o.breakpoints;
  return d;
}

void bind_assembled(nb::module_& m) {
  bind_struct<PartNames>(m, "PartNames", "Names of a model's parts, in the order of its indices.");
  nb::class_<AssembledModel>(m, "AssembledModel", "What a run needs, and the names of its parts.")
      .def(
          "__init__",
          [](AssembledModel* self, std::string const& name, std::shared_ptr<Model const> const& model,
             std::optional<MechatronicSetup> const& setup, PartNames const& names, std::string const& method,
             double step, double relative, std::vector<double> const& absolute, double initial_step,
             double maximum_step, double final_time, std::vector<double> const& breakpoints, double t0,
             std::vector<double> const& x0, std::vector<Disturbance> const& disturbances) {
            check_value(final_time, finite_number, "AssembledModel", "final_time");
            auto options = integrator_options(method, step, relative, absolute, initial_step, maximum_step, final_time,
                                              breakpoints);
            AssembledModel assembled{name, model, setup, names, std::move(options), t0, x0, disturbances};
            check_assembled(assembled);
            new (self) AssembledModel(std::move(assembled));
          },
          nb::kw_only(), "name"_a, "model"_a, "setup"_a.none(), "names"_a, "method"_a, "step"_a, "relative_tolerance"_a,
          "absolute_tolerance"_a, "initial_step"_a, "maximum_step"_a, "final_time"_a, "breakpoints"_a, "t0"_a, "x0"_a,
          "disturbances"_a)
      .def_ro("name", &AssembledModel::name)
      .def_ro("names", &AssembledModel::names)
      .def_ro("model", &AssembledModel::model)
      .def_ro("setup", &AssembledModel::setup)
      .def_ro("t0", &AssembledModel::start_time)
      .def_ro("x0", &AssembledModel::start)
      .def_ro("disturbances", &AssembledModel::disturbances)
      .def_prop_ro("settings", &settings, "Of the integrator, as Simulation.start() takes them.");
  m.def(
      "continuous_variables",
      [](AssembledModel const& assembled) {
        ContinuousVariables const all = list_continuous_variables(assembled);
        return nb::make_tuple(all.states, all.rates, all.indicators);
      },
      "assembled"_a,
      "What model exchange adds to the variables of a plant: states (most: nominal value), their rates, event "
      "indicators.");
  m.def(
      "write_model",
      [](AssembledModel const& assembled) {
        auto const bytes = write_model(assembled);
        return nb::bytes(bytes.data(), bytes.size());
      },
      "assembled"_a, "The bytes of a model file.");
  m.def(
      "read_model",
      [](nb::bytes const& content) {
        return read_model({static_cast<std::byte const*>(content.data()), content.size()});
      },
      "content"_a, "The model in a model file; ValueError says what is wrong with it.");
  m.def(
      "model_token",
      [](nb::bytes const& content) {
        return model_token({static_cast<std::byte const*>(content.data()), content.size()});
      },
      "content"_a, "The checksum of the file of a model or a controller as text.");
  m.attr("model_layout") = model_layout();
}

void bind_part(nb::module_& m) {
  bind_struct<ControllerPart>(m, "ControllerPart", "One controller of a case alone, with what it starts from.");
  m.def(
      "write_part",
      [](ControllerPart const& part) {
        auto const bytes = write_part(part);
        return nb::bytes(bytes.data(), bytes.size());
      },
      "part"_a, "The bytes of a controller for an FMU of it alone.");
}

std::vector<Variable> variables_of(auto const& plant) {
  auto const all = plant.variables();
  return {all.begin(), all.end()};
}

/// Why a variable was not set.
[[noreturn]] void refuse(auto const& self, char const* what, int index, double value, Causality causality) {
  auto const all = self.variables();
  bool const known = index >= 0 && index < static_cast<int>(all.size());
  if (!known || all[static_cast<std::size_t>(index)].causality != causality)
    throw nb::value_error((std::string(what) + ": index must be that of " +
                           (causality == Causality::input ? "an " : "a ") + causalities[static_cast<int>(causality)] +
                           ", got " + std::to_string(index))
                              .c_str());
  Variable const& variable = all[static_cast<std::size_t>(index)];
  if (variable.allows(value))
    throw nb::value_error((std::string(what) + ": " + variable.name +
                           (causality == Causality::input ? ": start() has not been called"
                                                          : " is fixed in a run: set it before start()"))
                              .c_str());
  Range const range{variable.least, variable.most, variable.whole ? "a whole number in its limits" : "in its limits"};
  refuse_value(value, range, what, ("value of " + variable.name).c_str());
}

template <class P>
void set_input(P& self, int index, double value) {
  if (!self.set_input(index, value)) refuse(self, "set_input", index, value, Causality::input);
}

void set_parameter(Plant& self, int index, double value) {
  if (!self.set_parameter(index, value)) refuse(self, "set_parameter", index, value, Causality::parameter);
}

template <class P>
int advance(P& self, double t) {
  if (std::isnan(t)) throw nb::value_error("advance: t must be a time, got nan");
  return static_cast<int>(self.advance(t));
}

void bind_controller_plant(nb::module_& m) {
  nb::class_<ControllerPlant>(m, "ControllerPlant", "One controller alone as other tools drive it; SI.")
      .def(nb::init<ControllerPart>(), "part"_a)
      .def_prop_ro("variables", [](ControllerPlant const& self) { return variables_of(self); })
      .def("start", [](ControllerPlant& self) { return static_cast<int>(self.start(0.0)); })
      .def("advance", &advance<ControllerPlant>, "t"_a, "With a sample at every sample time before t.")
      .def("set_input", &set_input<ControllerPlant>, "index"_a, "value"_a, "Holds from the next sample on.")
      .def(
          "get",
          [](ControllerPlant& self, int index) {
            bool const known = index >= 0 && index < static_cast<int>(self.variables().size());
            return known ? self.get(index) : std::numeric_limits<double>::quiet_NaN();
          },
          "index"_a)
      .def(
          "jacobian",
          [](ControllerPlant& self, std::vector<std::pair<int, double>> const& moves) {
            auto const all = self.variables();
            for (auto const& [index, by] : moves)
              if (index < 0 || index >= static_cast<int>(all.size()) || !(by > 0.0 && std::isfinite(by)) ||
                  all[static_cast<std::size_t>(index)].causality != Causality::input)
                throw nb::value_error("jacobian: moves must be indices of inputs and positive numbers");
            auto found = self.jacobian(moves);
            return owned_array<nb::ndim<2>>(std::move(found.matrix), {found.rows, found.columns});
          },
          "moves"_a,
          "Matrix of one sample in small motions about the present: rows states, then commands; columns states, then "
          "inputs, each of which is varied by so much.")
      .def_prop_ro(
          "estimates",
          [](ControllerPlant const& self) {
            std::map<std::string, std::vector<double>> found;
            for (std::size_t i = 0; i < self.part().axles.size(); ++i)
              if (auto const* axle = self.axle(i)) {
                found["estimated_force"].push_back(axle->estimate.force);
                found["estimated_torque"].push_back(axle->estimate.torque);
                found["feed_forward"].push_back(axle->feed_forward);
              }
            return found;
          },
          "What the rig's controller finds, per axle, by the names of `measurement_fields`; of another controller "
          "nothing.")
      .def_prop_ro("period", &ControllerPlant::period);
}

}  // namespace

void bind_plant(nb::module_& m) {
  bind_variable(m);
  bind_assembled(m);
  bind_part(m);
  bind_controller_plant(m);
  nb::class_<Plant>(m, "Plant", "An assembled model as other tools take it; SI.")
      .def(nb::init<AssembledModel>(), "assembled"_a)
      .def_prop_ro("variables", [](Plant const& self) { return variables_of(self); })
      .def(
          "find", [](Plant const& self, std::string const& name) { return self.find(name); }, "name"_a)
      .def(
          "start", [](Plant& self, double final_time) { return static_cast<int>(self.start(final_time)); },
          "final_time"_a = std::numeric_limits<double>::infinity())
      .def("advance", &advance<Plant>, "t"_a, "To the last sampling step at or before t; without sampled blocks to t.")
      .def("set_input", &set_input<Plant>, "index"_a, "value"_a, "Holds from the present time on.")
      .def("set_parameter", &set_parameter, "index"_a, "value"_a,
           "A fixed one before start(), which then looks for the equilibrium; a tunable one at any time.")
      .def("get", &Plant::get, "index"_a)
      .def(
          "save",
          [](Plant& self) {
            auto const bytes = self.save();
            return nb::bytes(bytes.data(), bytes.size());
          },
          "The complete state of the run.")
      .def(
          "restore",
          [](Plant& self, nb::bytes const& state) {
            if (!self.restore({static_cast<std::byte const*>(state.data()), state.size()}))
              throw nb::value_error("restore: state must be what save() of a plant of this model returned");
          },
          "state"_a, "Goes on from a saved state, of this plant or of another one of the same model.")
      .def(
          "values",
          [](Plant& self, std::vector<int> const& indices) {
            std::vector<double> values;
            for (int const index : indices) values.push_back(self.get(index));
            return owned_array<nb::ndim<1>>(std::move(values), {indices.size()});
          },
          "indices"_a)
      .def_prop_ro("time", &Plant::time)
      .def_prop_ro("sampling_step", &Plant::sampling_step)
      .def_prop_ro("failed_wheel", [](Plant const& self) { return std::string(self.failed_wheel()); });
}
