#include "rollerrig/simulate/sampled_run.hpp"
#include "rollerrig/system/outputs.hpp"

#include <algorithm>
#include <cmath>

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr BenchColumn axle_table[] = {
    {"axle_speed", "rad/s", "true speed of the axle, positive forward"},
    {"measured_axle_speed", "rad/s", "what the encoder says at the last sample"},
    {"roller_speed", "rad/s", "true speed of the roller, positive as under a wheel that rolls forward"},
    {"cylinder_pressure", "Pa", "brake cylinder pressure over the ambient"},
    {"valve", "1", "dump valve: 0 fill, 1 hold, 2 vent"},
    {"brake_torque", "N m", "of the friction brake, or of the motor that stands in for it"},
    {"traction_torque", "N m", "of the traction motor"},
    {"torque_factor", "1", "that wheel-slip control leaves of the traction demand"},
    {"roller_torque", "N m", "of the roller's drive, positive drives the wheel forward"},
    {"roller_command", "N m", "asked of the roller's drive"},
    {"estimated_force", "N", "estimated contact force on the axle, forward"},
    {"estimated_torque", "N m", "estimated torque on the axle"},
    {"virtual_speed", "rad/s", "speed of the virtual axle"},
    {"virtual_force", "N", "force of the virtual rail on the virtual axle, forward"},
    {"air", "m^3", "air taken by the cylinder since the start, at ambient pressure"},
    {"dump_cycles", "1", "times that the dump valve has opened to vent"},
    {"contact_force", "N", "force of rail or rollers on both wheels, along the running direction"},
    {"real_sliding", "m/s",
     "of the wheel on roller or rail, at the nominal radii: r w less the surface's speed and the wheelset's own"},
    {"measured_roller_torque", "N m", "what the torque sensor of the roller's drive says at the last sample"},
    {"measured_load", "N", "vertical force on the axle's rollers as measured at the last sample"},
    {"dissipated_energy_density", "J/m^2", "energy per area on the rail under the axle"},
};

constexpr BenchColumn train_table[] = {
    {"train_speed", "m/s", "of the train: on track the real one, on a rig the virtual one"},
    {"train_distance", "m", "since the start"},
    {"train_acceleration", "m/s^2", "of the train"},
    {"reference_speed", "m/s", "that slide protection, or else wheel-slip control, believes in"},
    {"brake_demand", "Pa", "cylinder pressure asked for"},
    {"traction_demand", "N m", "torque per axle asked for"},
};

double first_order(double state, double wanted, double rate, double h) {
  return wanted + (state - wanted) * std::exp(-rate * h);
}

/// One step of a motor's torque loop: exact for a first-order loop under a held command, else fine Runge-Kutta steps.
void step_motor(Motor const& motor, double* state, double command, double speed, double h) {
  double const wanted = motor.within_envelope(command, speed);
  if (!(motor.damping_ratio > 0.0)) {
    state[0] = first_order(state[0], wanted, motor.bandwidth, h);
    return;
  }
  int const parts = std::max(1, static_cast<int>(std::ceil(motor.bandwidth * h / 0.2)));
  double const k = h / parts;
  for (int i = 0; i < parts; ++i) {
    double r1[2], r2[2], middle[2];
    motor.rates(state, wanted, 0.0, r1);  // the envelope has been applied
    for (int j = 0; j < 2; ++j) middle[j] = state[j] + 0.5 * k * r1[j];
    motor.rates(middle, wanted, 0.0, r2);
    for (int j = 0; j < 2; ++j) state[j] += k * r2[j];
  }
}

}  // namespace

std::span<BenchColumn const> TestBench::axle_columns() { return axle_table; }
std::span<BenchColumn const> TestBench::train_columns() { return train_table; }

TestBench::TestBench(Dynamics& dynamics, BenchSetup const& setup)
    : dynamics_{&dynamics},
      setup_{setup},
      driven_{dynamics, inputs_},
      plant_{driven_},
      method_{plant_},
      axle_(setup.axles.size()) {
  auto const size = dynamics.sizes();
  y_.setZero(size.states + size.quadratures);
  y_new_ = y_;
  for (int r = 0; r < roles; ++r) {
    auto const length = at(sampling(static_cast<Role>(r)).delay) + 2;
    pending_[at(r)].value.resize(length);
    pending_[at(r)].acts_at.assign(length, 0);
  }
  Model const& model = dynamics.model();
  auto& in = inputs_;
  in.axle_torque.assign(model.axle_torques.size(), {});
  in.roller_torque.assign(model.roller_torques.size(), {});
  in.cylinder.assign(model.brakes.size(), {});
  in.dissipated_energy.assign(model.contacts.size(), 0.0);
  if (setup.estimator.kind == EstimatorKind::kalman)
    solve_kalman_gain(setup_.estimator, setup.step * std::max(1, setup.rig_sampling.every));
}

Sampling const& TestBench::sampling(Role role) const {
  if (role == Role::slide_protection) return setup_.slide_sampling;
  return role == Role::wheel_slip_control ? setup_.wheel_slip_sampling : setup_.rig_sampling;
}

Status TestBench::start(double const* x0) {
  auto const& map = dynamics_->map();
  dynamics_->reset_run();
  y_.setZero();
  std::copy_n(x0, dynamics_->sizes().states, y_.data());
  dynamics_->evaluate(0.0, y_.data(), inputs_);
  for (std::size_t i = 0; i < axle_.size() && setup_.pure_rolling; ++i)  // from no slip at all
    y_[map.rate[at(setup_.axles[i].wheelset)][coord_pitch]] +=
        rolling_slip(*dynamics_, static_cast<int>(i)) /
        dynamics_->model().contacts[at(setup_.axles[i].contact[0])].pair.wheel_radius;
  plant_.statistics = {};
  step_count_ = 0;
  ended_ = sampled_ = protection_acted_ = false;
  due_.fill(false);
  speed_ = setup_.speed;
  distance_ = acceleration_ = last_acceleration_ = 0.0;
  slide_.reset(speed_);
  wheel_slip_control_.reset(speed_);
  train_.reset(setup_.train, speed_);
  for (auto& rail : rail_) rail.reset(setup_.rail_cell);
  virtual_rail_.reset(setup_.rail_cell);
  for (auto& p : pending_) p.first = p.count = 0, p.now.fill(0.0);
  pending_[at(static_cast<int>(Role::wheel_slip_control))].now.fill(1.0);
  auto& in = inputs_;
  in.travels = setup_.travelling_mass > 0.0;
  in.speed = {0.0, speed_, 0.0};
  in.distance = 0.0;
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    BenchAxle const& a = setup_.axles[i];
    Axle& axle = axle_[i];
    axle = {};
    double const wheel = y_[map.rate[at(a.wheelset)][coord_pitch]];
    double const roller = a.roller >= 0 ? -y_[map.rate[at(a.roller)][coord_pitch]] : 0.0;
    axle.wheel_speed = wheel;
    axle.roller_speed = roller;
    axle.encoder.reset(0.0, wheel);
    axle.roller_encoder.reset(0.0, roller);
    axle.estimate.reset(roller, wheel, 0.0);
    axle.feedback.reset();
  }
  method_.restart();
  status_ = dynamics_->accept(0.0, y_.data(), inputs_);
  reset_sensors();
  return status_;
}

long TestBench::last_step(double t_stop) const {
  return std::lround(std::floor(std::min(t_stop, setup_.duration) / setup_.step + 1e-6));
}

// ------------------------------------------------------------------------------------------------- the plant

void TestBench::step() {
  method_.prepare(plant_, time(), y_);  // under the inputs until now
  take_commands();
  auto& in = inputs_;
  move_train();
  move_machines();
  in.speed = {time(), speed_, in.travels ? acceleration_ : 0.0};
  in.distance = distance_;
  dissipate_energy();
  // Inputs are straight lines that join: the slope at the end of the last step is that at the start of this one. What
  // does jump, V' and the dissipated energy, shifts a velocity by less than step / 6 times the jump, and the next jump back.
  status_ =
      method_.attempt(plant_, {time(), setup_.step, setup_.step * static_cast<double>(step_count_ + 1)}, y_, y_new_);
  if (status_ == Status::ok && !y_new_.allFinite()) status_ = Status::not_finite;
  if (status_ != Status::ok) return;
  y_.swap(y_new_);
  ++plant_.statistics.steps;
  ++step_count_;
  sampled_ = false;
  if (in.travels) {
    distance_ += setup_.step * (speed_ + 0.5 * setup_.step * acceleration_);
    speed_ += setup_.step * acceleration_;
  }
  status_ = dynamics_->accept(time(), y_.data(), inputs_);
  protect();
  double const train_speed = in.travels ? speed_ : setup_.reproduce ? train_.speed() : setup_.speed;
  if (train_speed < setup_.floor_speed && time() > 1.0) ended_ = true;
}

/// V' of the travelling frames for the next step: what pushes the train as a whole.
void TestBench::move_train() {
  if (!inputs_.travels) return;
  Model const& model = dynamics_->model();
  auto const& work = dynamics_->work();
  double const mass = setup_.travelling_mass;
  double force = dynamics_->evaluation().longitudinal_force - mass * model.gravity * model.resistance.gradient;
  force -= model.resistance.force(speed_);
  double momentum_rate = 0.0, momentum = 0.0, offset = 0.0, free_mass = 0.0;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    Body const& body = model.bodies[b];
    if (!body.in_moving_frame || body.locked[coord_x]) continue;
    momentum_rate += body.mass * (work.acceleration[b][coord_x] + inputs_.speed.slope);
    momentum += body.mass * work.motion[b].v.x;
    offset += body.mass * work.motion[b].p.x;
    free_mass += body.mass;
  }
  double wanted = 0.0;
  if (setup_.held_mass > 0.0) {
    wanted = (force - momentum_rate) / setup_.held_mass;  // what is left for the mass that the frame itself stands for
  } else {
    wanted = force / mass + 2.0 * momentum / free_mass + 1.0 * offset / free_mass;  // keeps the bodies in their places
  }
  acceleration_ = step_count_ == 0 ? wanted : 1.5 * wanted - 0.5 * last_acceleration_;
  last_acceleration_ = wanted;
}

void TestBench::move_machines() {
  auto& in = inputs_;
  double const t = time();
  double const h = setup_.step;
  auto const& work = dynamics_->work();
  auto const held = [&](double from, double to) { return HeldInput{t, from, (to - from) / h}; };
  auto const& factor = pending_[at(static_cast<int>(Role::wheel_slip_control))].now;
  auto const& valve = pending_[at(static_cast<int>(Role::slide_protection))].now;
  auto const& roller = pending_[at(static_cast<int>(Role::rig))].now;
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    BenchAxle const& a = setup_.axles[i];
    Axle& axle = axle_[i];
    double const speed = work.motion[at(a.wheelset)].rate[coord_pitch];

    double const before = axle.cylinder_state[1];
    int const parts = 8;  // the flow near equal pressures is quick
    for (int k = 0; k < parts; ++k) {
      double rate[2], middle[2], inflow = 0.0;
      double const part = h / parts;
      DumpValve const position = static_cast<DumpValve>(static_cast<int>(valve[i]));
      setup_.brake.rates(axle.cylinder_state, setup_.brake_demand.at(t), position, rate, inflow);
      for (int j = 0; j < 2; ++j) middle[j] = axle.cylinder_state[j] + 0.5 * part * rate[j];
      setup_.brake.rates(middle, setup_.brake_demand.at(t), position, rate, inflow);
      for (int j = 0; j < 2; ++j) axle.cylinder_state[j] = std::max(0.0, axle.cylinder_state[j] + part * rate[j]);
      axle.air += setup_.brake.air(part * inflow);
    }
    double demand = factor[i] * setup_.traction_demand.at(t);
    if (a.brake >= 0) in.cylinder[at(a.brake)] = held(before, axle.cylinder_state[1]);
    axle.stand_in = setup_.motor_brakes ? setup_.brake.torque(axle.cylinder_state[1], speed) : 0.0;
    demand += axle.stand_in;
    if (a.axle_torque >= 0) {
      double const from = axle.torque_state[0];
      step_motor(setup_.motor, axle.torque_state, demand, speed, h);
      in.axle_torque[at(a.axle_torque)] = held(from, axle.torque_state[0]);
    }
    if (a.roller_torque >= 0) {
      double const from = axle.roller_state[0];
      double const roller_speed = -work.motion[at(a.roller)].rate[coord_pitch];
      axle.command = roller[i];
      step_motor(setup_.roller_motor, axle.roller_state, axle.command, roller_speed, h);
      in.roller_torque[at(a.roller_torque)] = held(from, axle.roller_state[0]);
    }
  }
}

/// Energy that the wheels dissipate on the rail under them, and what they leave for those behind.
void TestBench::dissipate_energy() {
  auto& in = inputs_;
  Model const& model = dynamics_->model();
  double const way = setup_.step * std::max(0.0, speed_);
  double const per_length_of_rail =
      1.0 / std::max(0.1, speed_);  // rail passes at the train's speed, however wheels slide
  for (BenchAxle const& a : setup_.axles)
    for (int side = 0; side < 2; ++side) {
      int const c = a.contact[at(side)];
      if (c < 0 || model.contacts[at(c)].laws.friction.map == nullptr) continue;
      double const place = distance_ + model.contacts[at(c)].distance_ahead;
      double per_length = 0.0, width = 0.0;  // [J/m], [m]
      for (int k = 0; k < dynamics_->patch_count(c); ++k) {
        auto const& patch = dynamics_->patch(c, k);
        per_length += std::max(0.0, patch.creep_dissipation()) * per_length_of_rail;
        width += 0.5 * pi * patch.b;  // area of the ellipse over its length
      }
      double const own = width > 0.0 ? per_length / width : 0.0;
      double const wanted = rail_[at(side)].before(place) + 0.5 * own;
      in.dissipated_energy[at(c)] +=
          0.2 * (wanted - in.dissipated_energy[at(c)]);  // friction and energy act on each other: five steps' memory
      rail_[at(side)].dissipate(place, place + way, own);
    }
}

/// Ends a test on rollers before real sliding damages them.
void TestBench::protect() {
  if (setup_.rig_sampling.every == 0) return;
  auto const& work = dynamics_->work();
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    BenchAxle const& a = setup_.axles[i];
    if (a.roller < 0) continue;
    double const wheel = setup_.estimator.wheel_radius * work.motion[at(a.wheelset)].rate[coord_pitch];
    double const roller = -setup_.estimator.roller_radius * work.motion[at(a.roller)].rate[coord_pitch];
    Axle& axle = axle_[i];
    axle.slip_for = std::fabs(wheel - roller) > setup_.slip_limit ? axle.slip_for + setup_.step : 0.0;
    if (axle.slip_for > setup_.slip_time) ended_ = protection_acted_ = true;
  }
}

void TestBench::fill_row(double* axles, double* train) const {
  auto const& work = dynamics_->work();
  auto const& in = inputs_;
  Model const& model = dynamics_->model();
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    BenchAxle const& a = setup_.axles[i];
    Axle const& axle = axle_[i];
    double const wheel = work.motion[at(a.wheelset)].rate[coord_pitch];
    double const roller = a.roller >= 0 ? -work.motion[at(a.roller)].rate[coord_pitch] : 0.0;
    double force = 0.0, surface = in.travels ? speed_ : setup_.speed;
    for (int c : a.contact)
      for (int k = 0; c >= 0 && k < dynamics_->patch_count(c); ++k) force += dynamics_->patch(c, k).force.x;
    if (setup_.pure_rolling) force += dynamics_->evaluation().rolling_force[i];
    double const r = model.contacts[at(a.contact[0])].pair.wheel_radius;
    if (a.roller >= 0) surface = roller * model.contacts[at(a.contact[0])].roller_radius();
    bool const reproduces = setup_.reproduce;
    double const row[] = {wheel,
                          axle.wheel_speed,
                          roller,
                          axle.cylinder_state[1],
                          pending_[at(static_cast<int>(Role::slide_protection))].now[i],
                          setup_.motor_brakes ? axle.stand_in
                          : a.brake >= 0      ? dynamics_->evaluation().brake_torque[at(a.brake)]
                                              : 0.0,
                          axle.torque_state[0],
                          pending_[at(static_cast<int>(Role::wheel_slip_control))].now[i],
                          axle.roller_state[0],
                          axle.command,
                          axle.estimate.force(),
                          axle.estimate.axle_torque(setup_.estimator),
                          reproduces ? train_.axle_speed(static_cast<int>(i)) : 0.0,
                          reproduces ? train_.force(static_cast<int>(i)) : 0.0,
                          axle.air,
                          static_cast<double>(axle.dump_cycles),
                          force,
                          r * wheel - surface - work.motion[at(a.wheelset)].v.x,
                          axle.measured_torque,
                          axle.measured_load,
                          reproduces          ? axle.virtual_energy
                          : a.contact[0] >= 0 ? in.dissipated_energy[at(a.contact[0])]
                                              : 0.0};
    static_assert(std::size(row) == std::size(axle_table));
    axles = std::copy(std::begin(row), std::end(row), axles);
  }
  bool const travels = in.travels;
  double const row[] = {
      travels            ? speed_
      : setup_.reproduce ? train_.speed()
                         : setup_.speed,
      travels            ? distance_
      : setup_.reproduce ? train_.distance()
                         : setup_.speed * time(),
      travels            ? acceleration_
      : setup_.reproduce ? train_.acceleration()
                         : 0.0,
      setup_.slide_sampling.every > 0 ? slide_.reference_speed() : wheel_slip_control_.reference_speed(),
      setup_.brake_demand.at(time()),
      setup_.traction_demand.at(time())};
  static_assert(std::size(row) == std::size(train_table));
  std::copy(std::begin(row), std::end(row), train);
}

}  // namespace rollerrig
