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
#include "rollerrig/plant/continuous_plant.hpp"
#include "rollerrig/plant/controller_plant.hpp"
#include "rollerrig/plant/model_file.hpp"

using namespace nb::literals;
using namespace rollerrig;

namespace {

constexpr char const* causalities[] = {"input", "output", "parameter", "local"};
constexpr char const* variabilities[] = {"fixed", "tunable", "discrete", "continuous"};

nb::bytes bytes_of(std::vector<std::byte> const& bytes) { return nb::bytes(bytes.data(), bytes.size()); }
std::span<std::byte const> span_of(nb::bytes const& bytes) {
  return {static_cast<std::byte const*>(bytes.data()), bytes.size()};
}

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

void bind_assembled(nb::module_& m) {
  bind_struct<PartNames>(m, "PartNames", "Names of a model's parts, in the order of its indices.");
  bind_struct<integrate::Options>(m, "Options", "How a run is integrated, until when, and what it shows.");
  bind_struct<AssembledModel>(m, "AssembledModel", "What a run needs, and the names of its parts.");
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
      "write_model", [](AssembledModel const& assembled) { return bytes_of(write_model(assembled)); }, "assembled"_a,
      "The bytes of a model file.");
  m.def(
      "read_model", [](nb::bytes const& content) { return read_model(span_of(content)); }, "content"_a,
      "The model in a model file; ValueError says what is wrong with it.");
  m.def(
      "model_token", [](nb::bytes const& content) { return model_token(span_of(content)); }, "content"_a,
      "The checksum of the file of a model or a controller as text.");
  m.attr("model_layout") = model_layout();
}

void bind_part(nb::module_& m) {
  bind_struct<ControllerPart>(m, "ControllerPart", "One controller of a case alone, with what it starts from.");
  m.def(
      "write_part", [](ControllerPart const& part) { return bytes_of(write_part(part)); }, "part"_a,
      "The bytes of a controller for an FMU of it alone.");
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
          "save", [](Plant& self) { return bytes_of(self.save()); }, "The complete state of the run.")
      .def(
          "restore",
          [](Plant& self, nb::bytes const& state) {
            if (!self.restore(span_of(state)))
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
