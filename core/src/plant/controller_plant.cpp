#include "rollerrig/plant/controller_plant.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include "rollerrig/plant/state_archive.hpp"

namespace rollerrig {
namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();
constexpr double largest_change = 9.0;  ///< of friction
constexpr double most_samples = 1e7;    ///< in one step of a tool: hours
constexpr double round_off = 1e-6;      ///< of a sample time, in periods: tools add up their steps
constexpr double least_change = 1e-6;   ///< of a number that is varied, over it: differences then have ten digits
constexpr double unreached = 1e-14;     ///< change of a number, over it, that is rounding
constexpr int trial_samples = 3;        ///< in which states show how far inputs bring them

struct TrainInput {
  char const *name, *unit, *meaning;
  double Measurements::* place;
  double base, least, most;
};

constexpr std::string_view of_motors[] = {"axle_speed", "motor_torque"};  // of slide protection the first one
constexpr std::string_view of_rig[] = {"axle_speed",   "roller_speed", "roller_torque", "drive_torque",
                                       "motor_torque", "brake_torque", "axle_load",     "sand_flow"};
constexpr std::string_view of_brake[] = {"dump_valve", "brake_demand"};
constexpr TrainInput of_train[] = {
    {"train.track_brake_force", "N", "force of all track brakes against running", &Measurements::track_brake_force, 0.0,
     -no_limit, no_limit},
    {"train.force_of_others", "N", "force of axles that are not on the rig, mean since the last sample, forward",
     &Measurements::force_of_others, 0.0, -no_limit, no_limit},
    {"train.friction_change", "1", "relative change of the friction of the virtual rail", &Measurements::rail_friction,
     1.0, -1.0, largest_change},
};

}  // namespace

ControllerPlant::ControllerPlant(ControllerPart part) : part_{std::move(part)} {
  check_part(part_);
  add_axle_inputs();
  if (of_rollers()) add_train_inputs();
  commands_ = variables_.size();
  add_outputs();
  parameters_ = variables_.size();
  add_parameters();
  for (Variable const& variable : variables_) value_.push_back(variable.start);
}

bool ControllerPlant::of_rollers() const { return std::holds_alternative<RigController>(part_.controller.controller); }
bool ControllerPlant::of_brakes() const { return std::holds_alternative<BrakeUnit>(part_.controller.controller); }

void ControllerPlant::add_axle_inputs() {
  bool const drives = std::holds_alternative<WheelSlipControl>(part_.controller.controller);
  using Names = std::span<std::string_view const>;
  Names const names = of_rollers() ? Names(of_rig) : of_brakes() ? Names(of_brake) : Names(of_motors, drives ? 2 : 1);
  auto const* rig = std::get_if<RigController>(&part_.controller.controller);
  for (std::size_t i = 0; i < part_.axles.size(); ++i)
    for (std::string_view const name : names) {
      MeasurementField const& field = measurement_fields[measurement_index(name)];
      double const start = name == "axle_speed"     ? part_.axle_speed[i]
                           : name == "roller_speed" ? part_.roller_speed[i]
                           : name == "axle_load"    ? rig->train.static_load[i]
                                                    : 0.0;
      variables_.push_back(variable_of(field, part_.axles[i] + "." + std::string(name), Causality::input, start));
      inputs_.push_back({.per_axle = place_of(field, of_rollers()), .axle = i});
    }
}

void ControllerPlant::add_train_inputs() {
  for (TrainInput const& input : of_train) {
    variables_.push_back(
        {input.name, input.unit, input.meaning, Causality::input, Variability::discrete, 0.0, input.least, input.most});
    inputs_.push_back({.of_train = input.place, .base = input.base});
  }
}

void ControllerPlant::add_outputs() {
  CommandField const& field = field_of(command_of(part_.controller.controller));
  for (std::string const& axle : part_.axles)
    variables_.push_back(
        variable_of(field, axle + "." + std::string(field.name) + "_command", Causality::output, field.initial));
  auto const add = [&](std::string name, char const* unit, char const* meaning, double start) {
    variables_.push_back(
        {std::move(name), unit, meaning, Causality::output, Variability::discrete, start, -no_limit, no_limit});
  };
  if (of_rollers()) {
    for (std::size_t i = 0; i < part_.axles.size(); ++i)
      add(part_.axles[i] + ".virtual_speed", "rad/s", "speed of each axle of the virtual train", part_.axle_speed[i]);
    add("train.speed", "m/s", "speed of the virtual train", part_.train_speed);
  } else if (of_brakes()) {
    for (std::string const& axle : part_.axles) {
      add(axle + ".inlet_open", "1", "1 while the dump valve lets air into the cylinder", 1.0);
      add(axle + ".outlet_open", "1", "1 while the dump valve's outlet to the ambient is open", 0.0);
      add(axle + ".dump_cycles", "1", "times that the dump valve has opened to vent", 0.0);
    }
  } else {
    add("train.reference_speed", "m/s", "train speed as the controller estimates it", part_.train_speed);
  }
}

void ControllerPlant::add_parameters() {
  auto const add = [&](std::string name, char const* unit, char const* meaning, double start) {
    variables_.push_back(
        {std::move(name), unit, meaning, Causality::parameter, Variability::fixed, start, -no_limit, no_limit});
  };
  if (of_brakes()) return;
  add("train.start_speed", "m/s", "speed of the train at the start", part_.train_speed);
  if (!of_rollers()) return;
  for (std::size_t i = 0; i < part_.axles.size(); ++i) {
    add(part_.axles[i] + ".start_axle_speed", "rad/s", "speed of the axle at the start", part_.axle_speed[i]);
    add(part_.axles[i] + ".start_roller_speed", "rad/s", "speed of the roller at the start", part_.roller_speed[i]);
  }
}

bool ControllerPlant::set(int index, double value, Causality causality) {
  if (index < 0 || at(index) >= variables_.size()) return false;
  Variable const& variable = variables_[at(index)];
  if (variable.causality != causality || !variable.allows(value)) return false;
  value_[at(index)] = value;
  return true;
}

Measurements ControllerPlant::measured() const {
  Measurements now;
  now.axles = now.under_test = static_cast<int>(part_.axles.size());
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    Input const& input = inputs_[i];
    double& place = input.of_train != nullptr ? now.*input.of_train : (now.*input.per_axle)[input.axle];
    place = input.base + value_[i];
  }
  now.time = part_.step * static_cast<double>(samples_ * part_.controller.sampling.every);
  return now;
}

/// As the rig is before its sensors have been read.
Measurements ControllerPlant::at_start() const {
  Measurements now;
  now.axles = now.under_test = static_cast<int>(part_.axles.size());
  for (std::size_t i = 0; of_rollers() && i < part_.axles.size(); ++i) {
    now.axle_speed[i] = value_[parameters_ + 1 + 2 * i];
    now.roller_speed[i] = value_[parameters_ + 2 + 2 * i];
  }
  return now;
}

Status ControllerPlant::start(double /*final_time*/) {
  time_ = 0.0;
  samples_ = 0;
  for (std::size_t i = 0; i < parameters_; ++i) value_[i] = variables_[i].start;
  Measurements const now = at_start();
  double const speed = of_brakes() ? 0.0 : value_[parameters_];
  std::visit([&](auto const& law) { state_ = law.start(now, speed, period()); }, part_.controller.controller);
  return Status::ok;
}

Status ControllerPlant::advance(double time) {
  if (time - time_ > most_samples * period()) return Status::too_many_steps;
  double const until = time - round_off * period();
  while (part_.step * static_cast<double>(samples_ * part_.controller.sampling.every) < until) sample();
  time_ = time;
  return Status::ok;
}

void ControllerPlant::sample() {
  Measurements const now = measured();
  PerAxle<double> command{};
  auto const step = [&](auto const& law, auto& state) { law.step(state, now, period(), command); };
  visit_with_state(step, part_.controller.controller, state_);
  ++samples_;
  std::size_t const axles = part_.axles.size();
  for (std::size_t i = 0; i < axles; ++i) value_[commands_ + i] = command[i];
  auto const rest = commands_ + axles;
  if (auto const* rig = std::get_if<RigController::State>(&state_)) {
    for (std::size_t i = 0; i < axles; ++i) value_[rest + i] = rig->train.axle[i].speed;
    value_[rest + axles] = rig->train.speed;
    return;
  }
  if (auto const* brake = std::get_if<BrakeUnit::State>(&state_)) {
    for (std::size_t i = 0; i < axles; ++i) {
      Cylinder const& cylinder = brake->cylinder(i);
      value_[rest + 3 * i] = static_cast<double>(cylinder.inlet_open);
      value_[rest + 3 * i + 1] = static_cast<double>(cylinder.outlet_open);
      value_[rest + 3 * i + 2] = static_cast<double>(cylinder.dump_cycles);
    }
    return;
  }
  std::visit(
      [&](auto const& own) {
        if constexpr (requires { own.reference_speed(); }) value_[rest] = own.reference_speed();
      },
      state_);
}

ControllerPlant::Jacobian ControllerPlant::jacobian(std::span<std::pair<int, double> const> moves) {
  auto const before = std::tuple(state_, value_, samples_);
  StateNumbers numbers;
  numbers(state_);
  auto const varied = [&](double& number, double by, int samples, auto const& look) {
    for (number += by; samples > 0; --samples) {
      sample();
      look();
    }
    std::tie(state_, value_, samples_) = before;
  };
  auto const path = [&](double& number, double by) {
    std::vector<double> found;
    auto const note = [&] {
      for (double const* place : numbers.places) found.push_back(*place);
    };
    note();
    varied(number, by, trial_samples, note);
    return found;
  };
  std::size_t const states = numbers.places.size();
  std::vector<double> size(states), reached(states);
  std::vector<double> const unmoved = path(value_.front(), 0.0);
  for (std::size_t k = 0; k < unmoved.size(); ++k)
    size[k % states] = std::fmax(size[k % states], std::fabs(unmoved[k]));
  for (auto const& [index, by] : moves) {
    std::vector<double> const moved = path(value_[at(index)], by);
    for (std::size_t k = 0; k < moved.size(); ++k)
      reached[k % states] = std::fmax(reached[k % states], std::fabs(moved[k] - unmoved[k]));
  }

  std::vector<std::pair<double*, double>> columns;
  std::vector<double const*> rows;
  for (std::size_t k = 0; k < states; ++k)
    if (reached[k] > unreached * size[k]) {
      columns.emplace_back(numbers.places[k], std::fmax(reached[k], least_change * size[k]));
      rows.push_back(numbers.places[k]);
    }
  for (auto const& [index, by] : moves) columns.emplace_back(&value_[at(index)], by);
  for (std::size_t k = 0; k < part_.axles.size(); ++k) rows.push_back(&value_[commands_ + k]);

  Jacobian found{rows.size(), columns.size(), std::vector<double>(rows.size() * columns.size())};
  for (std::size_t j = 0; j < columns.size(); ++j)
    for (double const sign : {1.0, -1.0})
      varied(*columns[j].first, sign * columns[j].second, 1, [&] {
        for (std::size_t i = 0; i < rows.size(); ++i)
          found.matrix[i * columns.size() + j] += sign * *rows[i] / (2.0 * columns[j].second);
      });
  return found;
}

std::vector<std::byte> ControllerPlant::save() {
  StateWriter archive;
  archive(state_, value_, time_, samples_);
  return sealed(crc64(write_part(part_)), archive.out.bytes());
}

bool ControllerPlant::restore(std::span<std::byte const> bytes) {
  auto const wanted = unsealed(crc64(write_part(part_)), bytes);
  if (wanted.empty()) return false;
  auto const before = std::tuple(state_, value_, samples_, time_);
  try {
    start(no_limit);
    StateReader archive(wanted);
    archive(state_, value_, time_);
    std::int64_t const every = part_.controller.sampling.every;
    archive.within(samples_, std::int64_t{0}, (std::int64_t{1} << 60) / every);
    for (std::size_t i = 0; i < value_.size(); ++i)
      archive.need(variables_[i].causality == Causality::output || variables_[i].allows(value_[i]));
    archive.need(std::fabs(part_.step * static_cast<double>(samples_ * every) - time_) < 2.0 * period());
    archive.end(false);
    return true;
  } catch (FormatError const&) {
    std::tie(state_, value_, samples_, time_) = before;
    return false;
  }
}

}  // namespace rollerrig
