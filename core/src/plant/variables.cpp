#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <stdexcept>

#include "rollerrig/plant/variable.hpp"
#include "rollerrig/simulate/mechatronic_system.hpp"
#include "rollerrig/simulate/recorder.hpp"

namespace rollerrig {
namespace {

constexpr double any = std::numeric_limits<double>::infinity();
constexpr double largest_change = 9.0;   ///< of friction
constexpr double highest_speed = 200.0;  ///< [m/s]

bool has_command(MechatronicSetup const& setup, std::size_t axle, Command command) {
  AxleParts const& parts = setup.axles[axle];
  if (command == Command::dump_valve || command == Command::cylinder_pressure)
    return parts.brake != absent || parts.has_brake || setup.actuators.by_traction_motors;
  return command == Command::torque_factor ? parts.driven() : parts.roller_torque != absent;
}

/// Whether no controller of the setup gives a command.
bool is_open(MechatronicSetup const& setup, Command command) {
  for (auto const& [sampling, any_law] : setup.controllers)
    if (command_of(any_law) == command) return sampling.external;
  return command != Command::cylinder_pressure;  // without a controller the plant's own brake unit
}

void add_demands(MechatronicSetup const& setup, PartNames const& names, VariableList& list) {
  for (std::size_t i = 0; i < setup.axles.size(); ++i) {
    std::string const axle = names.axles[i] + ".";
    auto const add = [&](char const* name, char const* unit, char const* what, double limit, Place::Kind kind) {
      list.add({axle + name, unit, what, Causality::input, Variability::discrete, 0.0, -limit, limit}, {kind, i});
    };
    if (has_command(setup, i, Command::dump_valve))
      add("brake_demand", "Pa", "cylinder pressure demanded beside the demand of the case", highest_pressure,
          Place::brake_demand);
    if (setup.axles[i].driven())
      add("motor_torque", "N m",
          "torque demanded of the traction motor beside the demand of the case, positive forward", any,
          Place::motor_torque);
  }
  for (std::size_t c = 0; c < std::size(command_fields); ++c)
    for (std::size_t i = 0; i < setup.axles.size() && is_open(setup, static_cast<Command>(c)); ++i) {
      if (!has_command(setup, i, static_cast<Command>(c))) continue;
      CommandField const& field = command_fields[c];
      std::string const name = names.axles[i] + "." + std::string(field.name) + "_command";
      list.add(variable_of(field, name, Causality::input, field.initial), {Place::command, i, c});
    }
}

/// Speed control of the rollers' drives, where the rig's controller is outside and has a feedback to do it.
void add_speed_control(MechatronicSetup const& setup, PartNames const& names, VariableList& list) {
  for (auto const& [sampling, any_law] : setup.controllers) {
    auto const* law = std::get_if<RigController>(&any_law);
    if (law == nullptr || !sampling.external || !law->controls_speed()) continue;
    for (std::size_t i = 0; i < setup.under_test(); ++i) {
      if (!has_command(setup, i, Command::roller_torque)) continue;
      std::string const axle = names.axles[i] + ".";
      list.add({axle + "roller_speed_control", "1",
                "1: the roller's drive goes to roller_speed_command by the rig's feedback, with "
                "roller_torque_command as its feed-forward; 0: it is given roller_torque_command alone",
                Causality::input, Variability::discrete, 0.0, 0.0, 1.0, true},
               {Place::speed_control, i});
      list.add({axle + "roller_speed_command", "rad/s",
                "speed demanded of the roller's drive, positive drives the wheel forward", Causality::input,
                Variability::discrete, setup.speed / law->assumed.roller_radius, -any, any},
               {Place::roller_speed, i});
    }
  }
}

/// The speed of rollers or track that an ideal drive keeps, where the case keeps it constant.
void add_running_speed(Model const& model, VariableList& list) {
  auto const& speeds = model.speed.points.y;
  bool const driven = model.on_rails || std::ranges::any_of(model.bodies, &Body::speed_controlled);
  if (!driven || std::ranges::adjacent_find(speeds, std::not_equal_to{}) != speeds.end()) return;
  list.add({"run.speed_command", "m/s",
            "running speed that speed-controlled rollers (at the crown) or the track go to, on a straight line over "
            "run.speed_rise_time from each change on",
            Causality::input, Variability::discrete, model.speed.at(0.0), -highest_speed, highest_speed},
           {Place::running_speed});
  list.add({"run.speed_rise_time", "s", "time in which rollers or track reach a new run.speed_command",
            Causality::input, Variability::discrete, 0.1, 1e-3, 1e3},
           {Place::rise_time});
}

/// Of the train that the axles under test belong to: on track the real one, on a rig the virtual one.
void add_train(MechatronicSetup const& setup, VariableList& list) {
  bool const on_rig = std::ranges::any_of(
      setup.controllers, [](auto const& one) { return std::holds_alternative<RigController>(one.controller); });
  if (!on_rig && !(setup.frame.train_mass > 0.0)) return;
  list.add({"train.force", "N", "force on the train beside all others, positive forward", Causality::input,
            Variability::discrete, 0.0, -any, any},
           {Place::train_force});
  if (!on_rig && setup.simulated.count() == 0) return;
  list.add(
      {"train.friction_change", "1", "relative change of the friction of the virtual rail and under simulated axles",
       Causality::input, Variability::discrete, 0.0, -1.0, largest_change},
      {Place::rail_friction});
}

void add_friction(AssembledModel const& assembled, VariableList& list) {
  for (std::size_t i = 0; i < assembled.model->contacts.size(); ++i)
    list.add({wheel_name(assembled, assembled.model->contacts[i]) + ".friction_change", "1",
              "relative change of the friction of rail or roller under the wheel", Causality::input,
              Variability::discrete, 0.0, -1.0, largest_change},
             {Place::friction, i});
}

/// Torques about axles of a model in which nothing is sampled.
void add_torques(Model const& model, PartNames const& names, VariableList& list) {
  auto const add = [&](int body, char const* name, char const* what, Place place) {
    std::string const full = names.bodies[at(body)] + "." + name;
    list.add({full, "N m", what, Causality::input, Variability::discrete, 0.0, -any, any}, place);
  };
  for (std::size_t i = 0; i < model.axle_torques.size(); ++i)
    add(model.axle_torques[i].wheelset, "axle_torque",
        "torque about the axle beside that of the case, positive forward", {Place::axle_torque, i});
  for (std::size_t i = 0; i < model.roller_torques.size(); ++i)
    add(model.roller_torques[i].roller, "roller_torque",
        "torque on the roller beside that of the case, positive drives the wheel forward", {Place::roller_torque, i});
}

/// Names of the recorder's row, in its order, without what stands there once per patch.
class Columns {
 public:
  explicit Columns(VariableList& list) : list_{list} {}

  void block(std::string const& owner, std::span<Field const> fields) {
    for (Field const& field : fields) add(owner + std::string(field.name), field, {Place::recorded, column_++});
  }
  void wheel(std::string const& owner) {
    std::size_t y = 0, q = 0;
    for (Field const& field : Recorder::wheel_fields()) {
      if (field.name == "lateral_force") y = column_;
      if (field.name == "vertical_force") q = column_;
      add(owner + std::string(field.name), field, {Place::recorded, column_++});
    }
    add(owner + "derailment_quotient", {"", "1", "lateral over vertical force on the wheel (Y/Q)"},
        {Place::side_ratio, y, q});
  }
  void train(std::span<Field const> fields) {
    for (Field const& field : fields) {
      std::string const name(field.name.starts_with("train_") ? field.name.substr(6) : field.name);
      add("train." + name, field, {Place::recorded, column_++});
    }
  }
  void skip(std::size_t columns) { column_ += columns; }
  void measured(std::string const& owner) {
    for (MeasurementField const& field : measurement_fields)
      add(owner + std::string(field.name), {field.name, field.unit, field.meaning},
          {Place::measured, list_.measured++});
  }

 private:
  void add(std::string name, Field const& field, Place place) {
    list_.add({std::move(name), std::string(field.unit), std::string(field.meaning), Causality::output,
               Variability::continuous, 0.0, -any, any},
              place);
  }

  VariableList& list_;
  std::size_t column_{0};
};

void add_measurements(MechatronicSetup const& setup, PartNames const& names, Columns& columns) {
  for (auto const& [sampling, any_law] : setup.controllers) {
    if (!sampling.external) continue;
    char const* const name = std::visit([](auto const& law) { return law.name; }, any_law);
    bool const of_rollers = command_of(any_law) == Command::roller_torque;
    std::size_t const axles = of_rollers ? setup.under_test() : setup.axles.size();
    for (std::size_t i = 0; i < axles; ++i) columns.measured(std::string(name) + "." + names.axles[i] + ".");
  }
}

}  // namespace

bool Variable::allows(double value) const {
  return std::isfinite(value) && value >= least && value <= most && (!whole || value == std::round(value));
}

void VariableList::add(Variable variable, Place place) {
  variables.push_back(std::move(variable));
  places.push_back(place);
}

std::string wheel_name(AssembledModel const& assembled, WheelContact const& contact) {
  return assembled.names.bodies[at(contact.wheelset)] + (contact.right ? "_right" : "_left");
}

VariableList list_variables(AssembledModel const& assembled) {
  assembled.check();
  VariableList list;
  Model const& model = *assembled.model;
  PartNames const& names = assembled.names;
  if (assembled.setup) {
    add_demands(*assembled.setup, names, list);
    add_speed_control(*assembled.setup, names, list);
    add_train(*assembled.setup, list);
  } else {
    add_torques(model, names, list);
    add_running_speed(model, list);
  }
  add_friction(assembled, list);
  Columns columns(list);
  for (std::string const& body : names.bodies) columns.block(body + ".", Recorder::body_fields());
  for (WheelContact const& contact : model.contacts) columns.wheel(wheel_name(assembled, contact) + ".");
  columns.skip(model.contacts.size() * Recorder::patches * Recorder::patch_fields().size());
  for (std::string const& element : names.elements) columns.block(element + ".", Recorder::element_fields());
  columns.block("run.", Recorder::run_fields());
  if (assembled.setup) {
    for (std::string const& axle : names.axles) columns.block(axle + ".", MechatronicSystem::axle_fields());
    columns.train(MechatronicSystem::train_fields());
    add_measurements(*assembled.setup, names, columns);
  }
  return list;
}

void check_unique(VariableList const& list) {
  std::set<std::string_view> seen;
  for (Variable const& variable : list.variables)
    if (!seen.insert(variable.name).second)
      throw std::invalid_argument("assembled model: two variables are called " + variable.name);
}

}  // namespace rollerrig
