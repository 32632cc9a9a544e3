// What a run with sensors, controllers and actuators records beside the plant, and what its controllers see.
#include <algorithm>
#include <stdexcept>
#include <string>

#include "rollerrig/simulate/mechatronic_system.hpp"
#include "rollerrig/system/outputs.hpp"

namespace rollerrig {
namespace {

constexpr Field axle_table[] = {
    {"axle_speed", "rad/s", "true speed of the axle, positive forward"},
    {"measured_axle_speed", "rad/s", "reading of the rig's speed sensor at the last sample"},
    {"roller_speed", "rad/s", "true speed of the roller, positive as under a wheel that rolls forward"},
    {"cylinder_pressure", "Pa", "brake cylinder pressure over the ambient"},
    {"valve", "1", "command of the dump valve: 0 fill, 1 hold, 2 vent"},
    {"brake_torque", "N m", "torque of the friction brake, or of the motor in its place"},
    {"traction_torque", "N m", "torque of the traction motor"},
    {"torque_factor", "1", "part of the traction demand that wheel-slip control admits"},
    {"roller_torque", "N m", "torque of the roller's drive, positive drives the wheel forward"},
    {"roller_command", "N m", "torque commanded of the roller's drive"},
    {"estimated_force", "N", "estimated contact force on the axle, forward"},
    {"estimated_torque", "N m", "estimated torque on the axle"},
    {"virtual_speed", "rad/s", "speed of the virtual axle"},
    {"virtual_force", "N", "force of the virtual rail on the virtual axle, forward"},
    {"air", "m^3", "air taken by the cylinder since the start, at ambient pressure"},
    {"dump_cycles", "1", "times that the dump valve has opened to vent"},
    {"contact_force", "N",
     "force of rail or rollers on both wheels, along the running direction; with the normal force's part where the "
     "wheels "
     "lie off the rollers' crowns"},
    {"creep_force", "N",
     "sum of the creep forces on both wheels along the rolling direction: the part of the contact force that makes a "
     "torque, and uses adhesion"},
    {"real_sliding", "m/s",
     "sliding of the wheel on roller or rail, at the nominal radii: r w less the surface's speed and the wheelset's "
     "own"},
    {"measured_roller_torque", "N m", "reading of the torque sensor of the roller's drive at the last sample"},
    {"measured_load", "N", "vertical force on the axle's rollers as measured at the last sample"},
    {"dissipated_energy_density", "J/m^2",
     "energy per area dissipated on the rail under the axle, and what its wheels keep"},
    {"inlet_open", "1", "1 while the dump valve's inlet to the cylinder is open"},
    {"outlet_open", "1", "1 while the dump valve's outlet to the ambient is open"},
    {"roller_power", "W", "power that the roller's drive delivers; negative: that it takes up"},
    {"vehicle_axle_speed", "rad/s", "reading of the vehicle's own speed sensor at the last sample"},
    {"exhausted_air", "m^3", "air let out of the cylinder since the start, at ambient pressure"},
    {"electrodynamic_torque", "N m", "torque of the traction motor that brakes, beside traction_torque"},
    {"demanded_brake_torque", "N m",
     "torque of all brakes of the axle together against its turning: that of the friction brake under the full demand"},
    {"sand", "kg/m", "mass of sand per length of rail under the axle"},
    {"demanded_roller_power", "W", "power demanded of the roller's drive, before its limits"},
    {"drive_torque_limited", "s", "time that the limit of torque has held the roller's drive back since the start"},
    {"drive_power_limited", "s", "the same of its limit of power"},
    {"drive_speed_limited", "s", "the same of its limit of speed"},
    {"axle_work", "J", "work of motor and brake on a simulated axle since the start; 0 for those under test"},
    {"work_on_train", "J", "work of a simulated axle on the train since the start"},
    {"slip_dissipation", "J", "heat of a simulated axle's slip since the start"},
    {"reservoir_pressure", "Pa",
     "pressure in the auxiliary reservoir that feeds the axle's cylinder, over the ambient; 0 where the supply is "
     "unlimited"},
    {"pipe_pressure", "Pa",
     "pressure in the pipe between the axle's relay valve and its dump valve, over the ambient; 0 where the air has no "
     "pipe"},
};

constexpr Field train_table[] = {
    {"train_speed", "m/s",
     "speed of the train: on track the real one, on a rig the virtual one, or else of the rollers"},
    {"train_distance", "m", "distance of the train since the start"},
    {"train_acceleration", "m/s^2", "acceleration of the train"},
    {"reference_speed", "m/s", "train speed as slide protection, or else wheel-slip control, estimates it"},
    {"brake_demand", "Pa", "cylinder pressure demanded"},
    {"traction_demand", "N m", "torque per axle demanded"},
    {"main_pipe_air", "m^3",
     "air that all reservoirs have drawn from the main pipe since the start, at ambient pressure"},
    {"reference_speed_error", "m/s", "reference speed less the train's; 0 where no controller estimates it"},
    {"track_brake_force", "N", "force of all track brakes against running: on a rig on the virtual train"},
    {"track_brake_energy", "J", "energy that the track brakes have taken since the start"},
    {"sand_used", "kg", "sand that has been laid on both rails since the start"},
};

consteval std::size_t index_in(std::span<Field const> table, std::string_view name) {
  auto const found = std::ranges::find(table, name, &Field::name);
  if (found == table.end()) throw "there is no such column";
  return at(found - table.begin());
}
consteval std::size_t column(std::string_view name) { return index_in(axle_table, name); }
consteval std::size_t train_column(std::string_view name) { return index_in(train_table, name); }

/// Of all patches of an axle, and of the rolling constraint where it stands for creep [N].
struct LongitudinalForce {
  double total{0.0};  ///< along the running direction
  double creep{0.0};  ///< along the rolling direction, in the contact planes
};

LongitudinalForce longitudinal_force(Dynamics const& plant, AxleParts const& parts, int axle) {
  LongitudinalForce sum;
  for (int c : parts.contacts)
    for (int k = 0; c != absent && k < plant.patch_count(c); ++k) {
      sum.total += plant.patch(c, k).force.x;
      sum.creep += plant.patch(c, k).creep.longitudinal;
    }
  if (!plant.model().rolling_constraints.empty()) {
    sum.total += plant.evaluation().rolling_force[at(axle)];
    sum.creep += plant.evaluation().rolling_force[at(axle)];
  }
  return sum;
}

}  // namespace

std::span<Field const> MechatronicSystem::axle_fields() { return axle_table; }
std::span<Field const> MechatronicSystem::train_fields() { return train_table; }

int MechatronicSystem::width() const {
  return static_cast<int>(axles() * std::size(axle_table) + std::size(train_table));
}

std::vector<double> MechatronicSystem::measurement(std::string_view controller) const {
  auto const asked = std::ranges::find(controllers_, controller, &Controller::name);
  if (asked == controllers_.end()) throw std::invalid_argument("no controller " + std::string(controller));
  auto const index = at(asked - controllers_.begin());
  std::vector<double> out(at(measurement_width(index)));
  measure(index, out.data());
  return out;
}

int MechatronicSystem::measurement_width(std::size_t controller) const {
  bool const of_rollers = controllers_[controller].command == Command::roller_torque;
  return static_cast<int>((of_rollers ? under_test() : axles()) * std::size(measurement_fields));
}

void MechatronicSystem::measure(std::size_t controller, double* row) const {
  bool const of_rollers = controllers_[controller].command == Command::roller_torque;
  auto const* control = rig_state();
  for (std::size_t i = 0; i < (of_rollers ? under_test() : axles()); ++i, row += std::size(measurement_fields)) {
    for (std::size_t c = 0; c < std::size(measurement_fields); ++c) {
      auto const place = place_of(measurement_fields[c], of_rollers);
      row[c] = place != nullptr ? (measured_.*place)[i] : 0.0;
    }
    row[measurement_index("track_brake_force")] = measured_.track_brake_force;
    row[measurement_index("force_of_others")] = measured_.force_of_others;
    if (control == nullptr) continue;
    auto const& own = control->axle[i];
    row[measurement_index("estimated_force")] = own.estimate.force;
    row[measurement_index("estimated_torque")] = own.estimate.torque;
    row[measurement_index("virtual_speed")] = control->train.axle[i].speed;
    row[measurement_index("feed_forward")] = own.feed_forward;
  }
}

void MechatronicSystem::record(Dynamics const& plant, std::int64_t step, double const* z, Inputs const& inputs,
                               double* row) const {
  for (std::size_t i = 0; i < axles(); ++i, row += std::size(axle_table)) {
    ActuatorStates::Axle const& actuators = actuators_.axle(i);
    Cylinder const& cylinder = actuators_.cylinder(i);
    std::fill_n(row, std::size(axle_table), 0.0);
    row[column("measured_axle_speed")] = measured_.axle_speed[i];
    row[column("vehicle_axle_speed")] = measured_.vehicle_axle_speed[i];
    row[column("measured_load")] = measured_.axle_load[i];
    row[column("valve")] = acting_.dump_valve[i];
    row[column("torque_factor")] = acting_.torque_factor[i];
    row[column("traction_torque")] = actuators.motor[0];
    row[column("electrodynamic_torque")] = actuators.electrodynamic.torque;
    row[column("demanded_brake_torque")] = actuators.asked;
    row[column("cylinder_pressure")] = cylinder.pressure;
    row[column("air")] = cylinder.air;
    row[column("exhausted_air")] = cylinder.exhausted;
    row[column("dump_cycles")] = static_cast<double>(cylinder.dump_cycles);
    row[column("inlet_open")] = static_cast<double>(cylinder.inlet_open);
    row[column("outlet_open")] = static_cast<double>(cylinder.outlet_open);
    row[column("reservoir_pressure")] = actuators_.cylinders().supply(i).reservoir;
    row[column("pipe_pressure")] = actuators_.cylinders().pipe_pressure(i);
    i < under_test() ? record_axle(plant, i, inputs, row) : record_simulated(i, row);
  }
  auto const* control = frame_moves() ? nullptr : rig_state();
  double const t = time(step);
  Travel<double> train = running_motion(plant, t, z, inputs);  // on a rig without a virtual train: that of the rollers
  if (control != nullptr)
    train = {control->train.distance, control->train.speed, control->train.acceleration};
  else if (frame_moves())
    train = {train_.distance, train_.speed, train_.acceleration};
  row[train_column("train_speed")] = train.speed;
  row[train_column("train_distance")] = train.s;
  row[train_column("train_acceleration")] = train.acceleration;
  row[train_column("reference_speed")] = reference_speed().value_or(setup_.speed);
  row[train_column("brake_demand")] = setup_.actuators.brake_demand.at(t);
  row[train_column("traction_demand")] = setup_.actuators.torque_demand.at(t);
  row[train_column("main_pipe_air")] = actuators_.cylinders().drawn();
  row[train_column("reference_speed_error")] = reference_speed().value_or(train.speed) - train.speed;
  row[train_column("track_brake_force")] = track_brake_force(plant);
  row[train_column("track_brake_energy")] = track_brake_energy_;
  row[train_column("sand_used")] = sand_used_;
}

void MechatronicSystem::record_axle(Dynamics const& plant, std::size_t i, Inputs const& inputs, double* out) const {
  AxleParts const& parts = setup_.axles[i];
  auto const& actuators = actuators_.axle(i);
  int const axle = static_cast<int>(i);
  auto const spin = [&](int body) { return plant.work().motion[at(body)].rate[coord_pitch]; };
  std::size_t const left = at(parts.contacts[0]);
  WheelContact const& contact = plant.model().contacts[left];
  double const wheel = spin(parts.wheelset), roller = parts.roller != absent ? -spin(parts.roller) : 0.0;
  double const ground_speed = frame_moves() ? train_.speed : setup_.speed;
  double const surface = parts.roller != absent ? roller * contact.roller_radius : ground_speed;
  auto const force = longitudinal_force(plant, parts, axle);
  out[column("axle_speed")] = wheel;
  out[column("roller_speed")] = roller;
  out[column("brake_torque")] = setup_.actuators.by_traction_motors ? actuators.stand_in
                                : parts.brake != absent             ? plant.evaluation().brake_torque[at(parts.brake)]
                                                                    : 0.0;
  out[column("roller_torque")] = actuators.drive[0];
  out[column("roller_command")] = acting_.roller_torque[i];
  out[column("contact_force")] = force.total;
  out[column("creep_force")] = force.creep;
  out[column("real_sliding")] =
      contact.pair.wheel_radius * wheel - surface - plant.work().motion[at(parts.wheelset)].v.x;
  out[column("measured_roller_torque")] = sensors_.torque_reading(i);
  out[column("roller_power")] = actuators.drive[0] * roller;
  out[column("demanded_roller_power")] = actuators.drive_wanted;
  auto const limited = [&](DriveLimit of) { return actuators.drive_limited[at(of)]; };
  out[column("drive_torque_limited")] = limited(DriveLimit::torque);
  out[column("drive_power_limited")] = limited(DriveLimit::power);
  out[column("drive_speed_limited")] = limited(DriveLimit::speed);
  if (auto const* control = rig_state()) {
    auto const& own = control->axle[i];
    out[column("estimated_force")] = own.estimate.force;
    out[column("estimated_torque")] = own.estimate.torque;
    out[column("virtual_speed")] = control->train.axle[at(axle)].speed;
    out[column("virtual_force")] = control->train.axle[at(axle)].force;
    out[column("dissipated_energy_density")] = own.rail.energy;
    out[column("sand")] = own.rail.sand;
  } else {
    out[column("dissipated_energy_density")] = inputs.dissipated_energy[left];
    out[column("sand")] = inputs.sand.empty() ? 0.0 : inputs.sand[left];
  }
}

/// Of an axle outside the model there are no rollers, and the virtual rail's force is all that acts on it.
void MechatronicSystem::record_simulated(std::size_t i, double* out) const {
  auto const& own = simulated_.axle[i - under_test()];
  double const force = own.wheels.force;
  out[column("axle_speed")] = own.wheels.speed;
  out[column("contact_force")] = out[column("creep_force")] = force;
  out[column("dissipated_energy_density")] = own.rail.energy;
  out[column("sand")] = own.rail.sand;
  out[column("brake_torque")] =
      setup_.actuators.by_traction_motors ? actuators_.axle(i).stand_in : own.wheels.brake_torque;
  out[column("axle_work")] = own.work;
  out[column("work_on_train")] = own.to_train;
  out[column("slip_dissipation")] = own.dissipated;
  if (rig_state() != nullptr) {  // nothing slides on a roller
    out[column("virtual_speed")] = own.wheels.speed;
    out[column("virtual_force")] = force;
  } else {
    out[column("real_sliding")] = own.slip;
  }
}

}  // namespace rollerrig
