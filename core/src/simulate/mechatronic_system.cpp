#include "rollerrig/simulate/mechatronic_system.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "rollerrig/system/outputs.hpp"

namespace rollerrig {
namespace {

constexpr double energy_relaxation = 0.2;  ///< per step: friction and dissipated energy act on each other
constexpr double settling_time = 1.0;      ///< no run ends at standstill before [s]

}  // namespace

MechatronicSystem::MechatronicSystem(MechatronicSetup setup)
    : setup_{std::move(setup)},
      sensors_{axles()},
      actuators_{setup_},
      train_{setup_.speed},
      simulated_{setup_.simulated, setup_.speed},
      sand_{0.0, setup_.sanding ? static_cast<int>(std::lround(setup_.sanding->delay / setup_.step)) : 0} {
  for (auto const& [sampling, any] : setup_.controllers) {
    Command const command = command_of(any);
    char const* const name = std::visit([](auto const& law) { return law.name; }, any);
    controllers_.push_back({name, command, {}, {field_of(command).initial, sampling.delay}});
    if (command == Command::roller_torque) rig_ = controllers_.size() - 1;
    if (command == Command::cylinder_pressure) {  // a machine reads no sensors
      brake_unit_ = controllers_.size() - 1;
      continue;
    }
    shortest_ = shortest_ == 0 ? sampling.every : std::min(shortest_, sampling.every);
  }
  measured_.axles = static_cast<int>(axles());
  measured_.under_test = static_cast<int>(under_test());
  for (auto& rail : rail_) rail.reset(setup_.rail_cell);
  sanded_.reset(setup_.rail_cell);
  for (CommandField const& field : command_fields) (acting_.*field.of).fill(field.initial);
  caller_.commands = acting_;
  if (RigController const* law = rig()) caller_.roller_speed.fill(setup_.speed / law->assumed.roller_radius);
}

void MechatronicSystem::set_controllers(std::vector<SampledController> const& controllers) {
  setup_.controllers = controllers;
}

void MechatronicSystem::prepare(Model const& model, Inputs& inputs) const {
  inputs.axle_torque.assign(model.axle_torques.size(), {});
  inputs.roller_torque.assign(model.roller_torques.size(), {});
  inputs.cylinder.assign(model.brakes.size(), {});
  inputs.dissipated_energy.assign(model.contacts.size(), 0.0);
  inputs.sand.assign(setup_.sanding ? model.contacts.size() : 0, 0.0);
  inputs.frame_moves = frame_moves();
  inputs.speed = {0.0, setup_.speed, 0.0};
  inputs.distance = 0.0;
}

void MechatronicSystem::start(Dynamics const& plant) {
  sensors_.start(setup_, plant, simulated_, measured_);
  if (RigController const* law = rig()) speed_control_.fill(first_state(law->feedback));
  for (std::size_t i = 0; i < controllers_.size(); ++i) {
    auto const& [sampling, any] = setup_.controllers[i];
    double const period = setup_.step * sampling.every;
    std::visit([&](auto const& law) { controllers_[i].state = law.start(measured_, setup_.speed, period); }, any);
  }
}

bool MechatronicSystem::sample(Dynamics const& plant, std::int64_t step, double const* z) {
  sensors_.follow(setup_, plant, time(step), z, actuators_, simulated_);
  auto const due = [&](SampledController const& c) {
    return !std::holds_alternative<BrakeUnit>(c.controller) && step % c.sampling.every == 0;
  };
  sample_brake_demand(step);
  if (std::none_of(setup_.controllers.begin(), setup_.controllers.end(), due)) return true;
  sensors_.read(setup_, setup_.step * shortest_, measured_);
  read_true_forces(plant);
  measured_.track_brake_force = track_brake_force(plant) - caller_.train_force;
  measured_.rail_friction = caller_.rail_friction;
  measured_.sand_flow = sand_.acting();
  for (std::size_t i = 0; i < controllers_.size(); ++i)
    if (due(setup_.controllers[i])) ask(i, step);
  return !has_pending();
}

/// What the brakes are asked for from this instant on, by all that has been commanded up to now.
void MechatronicSystem::sample_brake_demand(std::int64_t step) {
  measured_.time = time(step);
  measured_.dump_valve = caller_.commands.dump_valve;
  for (Controller& own : controllers_)
    if (own.command == Command::dump_valve) {
      own.commands.advance(step);
      measured_.dump_valve = own.commands.acting();
    }
  for (std::size_t i = 0; i < axles(); ++i)
    measured_.brake_demand[i] = rollerrig::brake_demand(setup_, caller_, i, time(step));
}

void MechatronicSystem::ask_machines(std::int64_t step) {
  if (!brake_unit_) return;
  sample_brake_demand(step);
  if (step % setup_.controllers[*brake_unit_].sampling.every == 0) ask(*brake_unit_, step);
}

/// One sample of a controller; of an external rig controller the estimates and the virtual train, for the caller to read.
void MechatronicSystem::ask(std::size_t index, std::int64_t step) {
  Controller& own = controllers_[index];
  Sampling const& sampling = setup_.controllers[index].sampling;
  own.pending = sampling.external;
  PerAxle<double> command{};
  auto const run = [&]<class Law>(Law const& law, typename Law::State& state) {
    if constexpr (std::same_as<Law, RigController>) {
      sensors_.read_roller_torques(setup_, law.commanded_torque ? &acting_.roller_torque : nullptr, measured_);
      measured_.force_of_others = impulse_of_simulated_ / (setup_.step * sampling.every);
      impulse_of_simulated_ = 0.0;
    } else if (sampling.external)
      return;
    law.step(state, measured_, setup_.step * sampling.every, command);
  };
  visit_with_state(run, setup_.controllers[index].controller, own.state);
  if (!own.pending) own.commands.send(command, step);
}

/// T of (D1) from the roller's own acceleration, and the torque of motor and brake on the axle.
void MechatronicSystem::read_true_forces(Dynamics const& plant) {
  Model const& model = plant.model();
  for (std::size_t i = 0; i < axles(); ++i) measured_.motor_torque[i] = actuators_.axle(i).of_motor();
  for (std::size_t i = 0; i < under_test(); ++i) {
    AxleParts const& parts = setup_.axles[i];
    if (parts.roller == absent) continue;
    auto const& axle = actuators_.axle(i);
    double const rate = -plant.work().acceleration[at(parts.roller)][coord_pitch];
    measured_.true_force[i] = (model.bodies[at(parts.roller)].inertia.y * rate - axle.drive[0]) /
                              model.contacts[at(parts.contacts[0])].roller_radius;
    measured_.true_torque[i] =
        axle.of_motor() + (parts.brake != absent ? plant.evaluation().brake_torque[at(parts.brake)] : 0.0);
    measured_.brake_torque[i] =
        parts.brake != absent ? setup_.actuators.brake.torque(actuators_.cylinder(i).pressure, measured_.axle_speed[i])
                              : 0.0;
    measured_.drive_torque[i] = sensors_.torque_reading(i);
  }
}

void MechatronicSystem::act(Dynamics const& plant, std::int64_t step, Inputs& inputs) {
  acting_ = caller_.commands;
  for (Controller& own : controllers_) {
    own.commands.advance(step);
    acting_.*field_of(own.command).of = own.commands.acting();
  }
  if (setup_.sanding) switch_sand(plant, step);
  double const retarding = track_brake_force(plant) - simulated_.force - caller_.train_force;
  if (frame_moves()) train_.accelerate(setup_.frame, plant, inputs, retarding);
  PerAxle<double> speed{}, roller_speed{};
  for (std::size_t i = 0; i < axles(); ++i) {
    int const roller = setup_.axles[i].roller;
    speed[i] = axle_speed(plant, i);
    roller_speed[i] = roller != absent ? -plant.work().motion[at(roller)].rate[coord_pitch] : 0.0;
  }
  actuators_.step(setup_, step, acting_, caller_, speed, roller_speed, train_speed(plant), inputs);
  inputs.speed = {time(step), train_.speed, train_.acceleration};
  inputs.distance = train_.distance;
  dissipate(plant, inputs);
  if (setup_.sanding) deposit_sand(plant, inputs);
  if (simulated_.axle.size() > 0) step_simulated(step);
}

/// True speed of an axle [rad/s].
double MechatronicSystem::axle_speed(Dynamics const& plant, std::size_t i) const {
  if (i >= under_test()) return simulated_.axle[i - under_test()].wheels.speed;
  return plant.work().motion[at(setup_.axles[i].wheelset)].rate[coord_pitch];
}

/// The train over the step that begins: on a rig the virtual train has been advanced to its controller's next sample.
TrainStep MechatronicSystem::train_step(std::int64_t step) const {
  double const h = setup_.step, t = time(step);
  if (frame_moves()) {
    double const rate = train_.acceleration;
    return {t, train_.distance, std::max(0.0, train_.speed + 0.5 * h * rate), rate};
  }
  VirtualTrainState const& train = rig_state()->train;
  int const every = setup_.controllers[*rig_].sampling.every;
  double const until = h * static_cast<double>(every - step % every), rate = train.acceleration;
  double const behind = until * (train.speed - 0.5 * until * rate);  // that the train still has to run until then
  return {t, train.distance - behind, std::max(0.0, train.speed - (until - 0.5 * h) * rate), rate};
}

/// The axles of the train that are not in the model, over the step that begins.
void MechatronicSystem::step_simulated(std::int64_t step) {
  TrainStep const train = train_step(step);
  RigController::State* control = rig_state();
  FoundRail found{.energy = rail_, .sand = setup_.sanding ? &sanded_ : nullptr};
  if (control != nullptr) {
    found.energy = {&control->rail, 1};
    if (setup_.sanding) found.sand = &control->sand;
  }
  std::size_t const first = under_test();
  found.friction = caller_.rail_friction;
  found.sand_flow = sand_.acting().data() + first;
  auto const torque = [&](std::size_t i) {
    AxleParts const& parts = setup_.axles[first + i];
    return parts.driven() ? actuators_.axle(first + i).of_motor() : 0.0;
  };
  auto const brake = [&](std::size_t i, double w) {
    AxleParts const& parts = setup_.axles[first + i];
    return parts.has_brake ? setup_.actuators.brake.torque(actuators_.cylinder(first + i).pressure, w) : 0.0;
  };
  simulated_.step(setup_.simulated, *setup_.rail, train, setup_.step, found, torque, brake);
  impulse_of_simulated_ += setup_.step * simulated_.force;
}

/// What slide protection or wheel-slip control has just asked of an axle.
bool MechatronicSystem::axle_is_sliding(std::size_t axle) const {
  return valve_of(acting_.dump_valve[axle]) == DumpValve::vent || acting_.torque_factor[axle] < 1.0;
}

void MechatronicSystem::switch_sand(Dynamics const& plant, std::int64_t step) {
  SandingMoment now{time(step), train_distance(), false};
  for (std::size_t i = 0; i < axles(); ++i) now.slides = now.slides || axle_is_sliding(i);
  bool const flows = sanding_.step(*setup_.sanding, now, train_speed(plant), setup_.step);
  PerAxle<double> flow{};
  for (std::size_t i = 0; i < axles(); ++i) flow[i] = flows && setup_.axles[i].sands ? setup_.sanding->flow : 0.0;
  sand_.send(flow, step);
  sand_.advance(step);
  for (std::size_t i = 0; i < axles(); ++i) sand_used_ += 2.0 * sand_.acting()[i] * setup_.step;  // on both rails
}

/// Sand on the rails of a track, in front of the wheels and behind them; on a rig it lies on the virtual rail.
void MechatronicSystem::deposit_sand(Dynamics const& plant, Inputs& inputs) {
  if (!frame_moves()) return;
  double const way = setup_.step * std::max(0.0, train_.speed);
  for (std::size_t i = 0; i < under_test(); ++i) {
    AxleParts const& parts = setup_.axles[i];
    double const from = train_.distance + plant.model().contacts[at(parts.contacts[0])].distance_ahead;
    double const sand = sanded_.run(from, from + way, sand_.acting()[i] * setup_.step, setup_.sanding->kept);
    for (int c : parts.contacts)
      if (c != absent) inputs.sand[at(c)] = sand;
  }
}

/// Of all bogies, against running [N].
double MechatronicSystem::track_brake_force(Dynamics const& plant) const {
  auto const& brake = setup_.actuators.track_brake;
  return brake ? brake->bogies * actuators_.track_brake() * brake->force(train_speed(plant)) : 0.0;
}

/// Energy that the wheels dissipate on the rail under them, and what they leave for those behind.
void MechatronicSystem::dissipate(Dynamics const& plant, Inputs& inputs) {
  Model const& model = plant.model();
  double const step_length = setup_.step * std::max(0.0, train_.speed);
  for (std::size_t i = 0; i < under_test(); ++i) {
    AxleParts const& parts = setup_.axles[i];
    for (std::size_t side = 0; side < 2; ++side) {
      int const c = parts.contacts[side];
      if (c == absent || model.contacts[at(c)].friction.map == nullptr) continue;
      double const from = train_.distance + model.contacts[at(c)].distance_ahead;
      double power = 0.0, width = 0.0;  // [W], [m]
      for (int k = 0; k < plant.patch_count(c); ++k) {
        auto const& patch = plant.patch(c, k);
        power += std::max(0.0, patch.creep_dissipation());
        width += 0.5 * pi * patch.b;  // area of the ellipse over its length
      }
      if (setup_.energy_width > 0.0) width = setup_.energy_width;
      double const own = width > 0.0 ? energy_per_area(power, train_.speed, width) : 0.0;
      double const radius = model.contacts[at(c)].pair.wheel_radius;
      double const rolled = setup_.step * std::fabs(radius * plant.work().motion[at(parts.wheelset)].rate[coord_pitch]);
      double const under = wheel_[side][i].pass({&rail_[side], 1}, from, step_length, own, rolled, 2.0 * pi * radius,
                                                setup_.wheel_memory);
      inputs.dissipated_energy[at(c)] += energy_relaxation * (under - inputs.dissipated_energy[at(c)]);
    }
  }
}

Status MechatronicSystem::advance(Dynamics const& plant, std::int64_t step) {
  if (frame_moves()) train_.advance(setup_.step);
  double const power = track_brake_force(plant) * train_speed(plant);
  track_brake_energy_ += 0.5 * setup_.step * (track_brake_power_ + power);
  track_brake_power_ = power;
  if (slip_limit_exceeded(plant)) return Status::rollers_protected;
  return time(step) > settling_time && train_speed(plant) < setup_.stop_speed ? Status::stopped : Status::ok;
}

/// Whether a wheel has slid on its roller for longer than the rig's protection allows.
bool MechatronicSystem::slip_limit_exceeded(Dynamics const& plant) {
  RigController const* control = rig();
  if (control == nullptr) return false;
  bool too_long = false;
  for (std::size_t i = 0; i < under_test(); ++i) {
    AxleParts const& parts = setup_.axles[i];
    if (parts.roller == absent) continue;
    double const wheel = control->assumed.wheel_radius * plant.work().motion[at(parts.wheelset)].rate[coord_pitch];
    double const roller = -control->assumed.roller_radius * plant.work().motion[at(parts.roller)].rate[coord_pitch];
    double const own =
        plant.work().motion[at(parts.wheelset)].v.x;  // a wheel that rolls along the roller does not slide
    slides_for_[i] = std::fabs(wheel - roller - own) > setup_.protection.slip ? slides_for_[i] + setup_.step : 0.0;
    too_long = too_long || slides_for_[i] > setup_.protection.time;
  }
  return too_long;
}

/// Of the train on track, of the virtual train on a rig, or else of the rollers [m/s].
double MechatronicSystem::train_speed(Dynamics const& plant) const {
  if (frame_moves()) return train_.speed;
  auto const* control = rig_state();
  return control != nullptr ? control->train.speed : crown_speed(plant);
}

/// Of the train on track, of the virtual train on a rig, since the start [m].
double MechatronicSystem::train_distance() const {
  auto const* control = rig_state();
  return frame_moves() || control == nullptr ? train_.distance : control->train.distance;
}

/// Of the first controller that estimates the train's speed.
std::optional<double> MechatronicSystem::reference_speed() const {
  std::optional<double> found;
  for (Controller const& own : controllers_)
    std::visit(
        [&](auto const& state) {
          if constexpr (requires { state.reference_speed(); })
            if (!found) found = state.reference_speed();
        },
        own.state);
  return found;
}

bool MechatronicSystem::has_pending() const {
  return std::any_of(controllers_.begin(), controllers_.end(), [](Controller const& c) { return c.pending; });
}

bool MechatronicSystem::waits_for(std::string_view controller) const {
  return std::any_of(controllers_.begin(), controllers_.end(),
                     [&](Controller const& c) { return c.pending && c.name == controller; });
}

void MechatronicSystem::cancel_pending() {
  for (Controller& own : controllers_) own.pending = false;
}

void MechatronicSystem::answer(std::int64_t step) {
  for (std::size_t i = 0; i < controllers_.size(); ++i)
    if (setup_.controllers[i].sampling.external) controllers_[i].commands.send(answer_of(i), step);
}

/// What the caller commands. A roller's drive that is asked for a speed finds its torque by the feedback of the rig's controller,
/// where that is due.
PerAxle<double> MechatronicSystem::answer_of(std::size_t index) {
  Controller& own = controllers_[index];
  bool const due = std::exchange(own.pending, false);
  PerAxle<double> command = caller_.commands.*field_of(own.command).of;
  auto const& [sampling, any] = setup_.controllers[index];
  auto const* law = std::get_if<RigController>(&any);
  for (std::size_t i = 0; i < under_test() && law != nullptr; ++i) {
    if (caller_.speed_control[i] == 1.0 && !due)
      command[i] = own.commands.newest()[i];
    else if (caller_.speed_control[i] == 1.0)
      command[i] = law->torque_for_speed(speed_control_[i], command[i], caller_.roller_speed[i],
                                         measured_.roller_speed[i], setup_.step * sampling.every);
    else
      speed_control_[i] = first_state(law->feedback);
  }
  return command;
}

void MechatronicSystem::set_command(std::string_view controller, std::span<double const> command, std::int64_t step) {
  for (Controller& own : controllers_) {
    if (own.name != controller || !own.pending) continue;
    bool const of_rollers = own.command == Command::roller_torque;
    if (command.size() != (of_rollers ? under_test() : axles()))
      throw std::invalid_argument("a command has one number per axle");
    CommandField const& field = field_of(own.command);
    for (double number : command)
      if (!(number >= field.lowest && number <= field.highest) || (field.whole && number != std::round(number)))
        throw std::invalid_argument("command: " + std::string(field.name) + " = " + std::to_string(number) +
                                    "; allowed: " + std::string(field.allowed));
    PerAxle<double> value{};
    std::copy(command.begin(), command.end(), value.begin());
    own.commands.send(value, step);
    own.pending = false;
    return;
  }
  throw std::invalid_argument("no external controller " + std::string(controller) + " waits for a command");
}

}  // namespace rollerrig
