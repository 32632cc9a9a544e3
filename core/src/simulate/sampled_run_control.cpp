// The sampled side of the test bench: sensors, controllers, commands on their way.
#include <algorithm>
#include <cmath>

#include "rollerrig/simulate/sampled_run.hpp"

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

/// Vertical force of rail or rollers on both wheels of an axle, in the last evaluation [N].
double TestBench::load(int axle) const {
  double sum = 0.0;
  for (int c : setup_.axles[at(axle)].contact)
    for (int k = 0; c >= 0 && k < dynamics_->patch_count(c); ++k) sum += dynamics_->patch(c, k).force.z;
  return sum;
}

void TestBench::reset_sensors() {
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    axle_[i].torque_reading.reset(0.0);
    axle_[i].load_reading.reset(load(static_cast<int>(i)));
  }
}

void TestBench::read_sensors(double period) {
  auto const& map = dynamics_->map();
  double const* z = y_.data() + dynamics_->sizes().states;
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    BenchAxle const& a = setup_.axles[i];
    Axle& axle = axle_[i];
    std::uint64_t const stream = setup_.seed * 64 + 2 * i;
    axle.wheel_speed = axle.encoder.step(setup_.axle_encoder, z[map.angle[at(a.wheelset)]],
                                         dynamics_->work().motion[at(a.wheelset)].rate[coord_pitch], period, stream);
    axle.measured_load = axle.load_reading.read(setup_.load_sensor, stream + 16);
    if (a.roller < 0) continue;
    axle.roller_speed =
        axle.roller_encoder.step(setup_.roller_encoder, -z[map.angle[at(a.roller)]],
                                 -dynamics_->work().motion[at(a.roller)].rate[coord_pitch], period, stream + 1);
    axle.measured_torque = axle.torque_reading.read(setup_.torque_sensor, stream + 17);
  }
}

/// Torque of a roller's drive since the last sample, as far as the controller knows it [N m].
double TestBench::drive_torque(Axle& axle) const {
  double const before = axle.sampled_torque;
  axle.sampled_torque = axle.measured_torque;
  double const acted = axle.torque_steps > 0 ? axle.torque_sum / axle.torque_steps : 0.0;
  axle.torque_sum = 0.0;
  axle.torque_steps = 0;
  if (setup_.commanded_torque) return axle.command;
  return setup_.has_torque_sensor ? 0.5 * (before + axle.measured_torque) : acted;
}

/// Reads the sensors and asks every controller that is due; false where the caller must answer first.
bool TestBench::sample() {
  dynamics_->evaluate(time(), y_.data(), inputs_);
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    Axle& axle = axle_[i];
    if (step_count_ > 0) {
      axle.torque_sum += 0.5 * (axle.torque_now + axle.roller_state[0]);
      ++axle.torque_steps;
    }
    axle.torque_now = axle.roller_state[0];
    axle.torque_reading.follow(setup_.torque_sensor, axle.torque_now, setup_.step);
    axle.load_reading.follow(setup_.load_sensor, load(static_cast<int>(i)), setup_.step);
  }
  bool waiting = false;
  bool any = false;
  std::array<bool, roles> now{};
  for (int r = 0; r < roles; ++r) {
    int const every = sampling(static_cast<Role>(r)).every;
    now[at(r)] = every > 0 && step_count_ % every == 0;
    any = any || now[at(r)];
  }
  if (std::any_of(due_.begin(), due_.end(), [](bool d) { return d; })) return false;  // still not answered
  if (any) {
    int fastest = 0;
    for (int r = 0; r < roles; ++r)
      if (int const every = sampling(static_cast<Role>(r)).every; every > 0)
        fastest = fastest == 0 ? every : std::min(fastest, every);
    read_sensors(setup_.step * fastest);
  }
  for (int r = 0; r < roles; ++r) {
    if (!now[at(r)]) continue;
    Role const role = static_cast<Role>(r);
    if (sampling(role).external) {
      if (role == Role::rig) control_rig();  // its estimates and the virtual train, for the caller to read
      due_[at(r)] = waiting = true;
    } else {
      run_controller(role);
    }
  }
  sampled_ = true;
  return !waiting;
}

void TestBench::run_controller(Role role) {
  std::array<double, most_axles> speed{}, command{};
  int const axles = static_cast<int>(axle_.size());
  for (int i = 0; i < axles; ++i) speed[at(i)] = axle_[at(i)].wheel_speed;
  double const period = setup_.step * sampling(role).every;
  if (role == Role::rig) {
    control_rig();
    for (int i = 0; i < axles; ++i) command[at(i)] = axle_[at(i)].wanted_torque;
    return post(role, command.data());
  }
  if (role == Role::slide_protection) {
    std::array<DumpValve, most_axles> valve{};
    slide_.step(setup_.slide, speed.data(), axles, period, valve.data());
    for (int i = 0; i < axles; ++i) command[at(i)] = static_cast<double>(static_cast<int>(valve[at(i)]));
  } else {
    wheel_slip_control_.step(setup_.wheel_slip_control, speed.data(), axles, period, command.data());
  }
  post(role, command.data());
}

/// Torque of motor and brake on an axle now [N m].
double TestBench::acting_torque(int axle) const {
  BenchAxle const& a = setup_.axles[at(axle)];
  return axle_[at(axle)].torque_state[0] + (a.brake >= 0 ? dynamics_->evaluation().brake_torque[at(a.brake)] : 0.0);
}

/// T of (D1) now [N].
double TestBench::acting_force(int axle) const {
  BenchAxle const& a = setup_.axles[at(axle)];
  double const inertia = dynamics_->model().bodies[at(a.roller)].inertia.y;
  double const rate = -dynamics_->work().acceleration[at(a.roller)][coord_pitch];
  double const radius = dynamics_->model().contacts[at(a.contact[0])].roller_radius();
  return (inertia * rate - axle_[at(axle)].roller_state[0]) / radius;
}

/// Our own rig controller: estimate, virtual train, feed-forward and feedback. (D1)-(D5)
void TestBench::control_rig() {
  std::array<double, most_axles> torque{};
  int const axles = static_cast<int>(axle_.size());
  double const period = setup_.step * setup_.rig_sampling.every;
  ContactForceEstimator const& e = setup_.estimator;
  for (int i = 0; i < axles; ++i) {
    Axle& axle = axle_[at(i)];
    axle.roller_torque = drive_torque(axle);
    if (e.kind == EstimatorKind::exact) {
      axle.estimate.set(e, acting_force(i), acting_torque(i));
    } else {
      axle.estimate.step(e, axle.roller_speed, axle.wheel_speed, axle.roller_torque, period);
    }
    torque[at(i)] = axle.estimate.axle_torque(e);
  }
  if (setup_.reproduce) {
    double const now = time();
    double const from = train_.distance();
    auto const law = [&](int i, double slip, double speed, double load) {
      return setup_.rail.force(slip, speed, load, now, from + setup_.place[at(i)], axle_[at(i)].virtual_energy);
    };
    VirtualTrain train = setup_.train;
    for (int i = 0; i < axles && setup_.measured_loads; ++i) {
      train.static_load[at(i)] = axle_[at(i)].measured_load;
      train.load_transfer[at(i)] = 0.0;
    }
    train_.step(train, torque.data(), period, law);
    for (int i = 0; i < axles; ++i) {  // front to back: the following ones run on what the leading axle leaves
      Axle& axle = axle_[at(i)];
      double const place = setup_.place[at(i)];
      double const slip = setup_.train.wheel_radius * train_.axle_speed(i) - train_.speed();
      double const speed = std::max(train_.speed(), 0.1);
      double const own = std::fabs(train_.force(i) * slip) / (2.0 * speed * setup_.rail.width);
      double const found = virtual_rail_.before(from + place);
      axle.virtual_energy = found + 0.5 * own;  // half of it is dissipated behind the patch's middle
      virtual_rail_.dissipate(from + place, train_.distance() + place, own);
      double const feed_forward = e.roller_inertia * setup_.train.wheel_radius / e.roller_radius * train_.axle_rate(i) -
                                  e.roller_radius * train_.force(i);  // (D5)
      axle.feed_forward = feed_forward;
      axle.wanted_torque =
          axle.feedback.step(setup_.feedback, feed_forward, train_.axle_speed(i) - axle.wheel_speed, period);
    }
  }
}

std::vector<double> TestBench::measurement(Role) const {
  std::vector<double> out;
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    Axle const& a = axle_[i];
    double const virtual_speed = setup_.reproduce ? train_.axle_speed(static_cast<int>(i)) : 0.0;
    out.insert(out.end(), {a.wheel_speed, a.roller_speed, a.roller_torque, a.estimate.force(),
                           a.estimate.axle_torque(setup_.estimator), virtual_speed, a.feed_forward, a.measured_load});
  }
  return out;
}

void TestBench::set_command(Role role, double const* command) {
  std::array<double, most_axles> c{};
  std::copy_n(command, axle_.size(), c.begin());
  due_[at(static_cast<int>(role))] = false;
  post(role, c.data());
}

void TestBench::post(Role role, double const* command) {
  Pending& p = pending_[at(static_cast<int>(role))];
  std::size_t const slot = (p.first + p.count) % p.value.size();
  std::copy_n(command, most_axles, p.value[slot].begin());
  p.acts_at[slot] = step_count_ + sampling(role).delay;
  ++p.count;
}

void TestBench::take_commands() {
  for (Pending& p : pending_)
    while (p.count > 0 && p.acts_at[p.first] <= step_count_) {
      if (&p == &pending_[at(static_cast<int>(Role::slide_protection))])
        for (std::size_t i = 0; i < axle_.size(); ++i)
          axle_[i].dump_cycles += p.value[p.first][i] > 1.5 && p.now[i] < 1.5;
      p.now = p.value[p.first];
      p.first = (p.first + 1) % p.value.size();
      --p.count;
    }
}

}  // namespace rollerrig
