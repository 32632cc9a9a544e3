#include "rollerrig/simulate/driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "rollerrig/integrate/integrator.hpp"
#include "rollerrig/system/outputs.hpp"

namespace rollerrig {
namespace {

constexpr double longest_count = 1e15;  ///< of steps, far within 64 bits

}  // namespace

void check_settings(integrate::Options const& o, int states, double t0, double sampling_step) {
  check_value(t0, finite_number, "start", "t0");
  integrate::check_options(o, states);
  auto const need_length = [&](double length, char const* name, double least) {
    if (length == 0.0 || !(o.final_time > t0) || std::isinf(o.final_time)) return;
    if (length < least || (o.final_time - t0) / length > static_cast<double>(o.max_steps))
      throw std::invalid_argument(std::string("start: ") + name + " is too short: " +
                                  std::to_string((o.final_time - t0) / length) + " of it until final_time");
  };
  // Time does not move by less than some units in the last place.
  double const resolution =
      16.0 * std::numeric_limits<double>::epsilon() * std::max({1.0, std::abs(t0), std::abs(o.final_time)});
  need_length(o.step, "step", resolution);
  need_length(o.maximum_step, "maximum_step", resolution);
  need_length(o.output_step, "output_step", resolution);
  need_length(sampling_step, "the sampling step of its setup", resolution);
}

Driver::Driver(std::shared_ptr<Model const> model, std::optional<MechatronicSetup> setup)
    : plant_{model}, observed_{model}, recorder_{*model}, setup_{std::move(setup)} {
  if (!setup_) return;
  check_setup(*setup_, *model);
  system_.emplace(*setup_);
}

Driver::~Driver() = default;

double Driver::time() const { return integrator_ ? integrator_->time() : 0.0; }
bool Driver::is_held() const { return integrator_->is_held(); }
double Driver::step_start() const { return integrator_->step_start(); }
double const* Driver::states() const { return integrator_->states(); }
integrate::Statistics const& Driver::statistics() const { return integrator_->statistics(); }
void Driver::sample_states(double t, double* x, double* z) { integrator_->sample(t, x, z); }

Status Driver::start(integrate::Options options, double t0, double const* x0) {
  check_settings(options, plant_.sizes().states, t0, setup_ ? setup_->step : 0.0);
  plant_.reset_run();
  final_time_ = options.final_time;
  step_ = 0;
  sampled_ = brake_unit_sampled_ = acted_ = held_ = false;
  inputs_ = {};
  inputs_.axle_torque.reserve(plant_.model().axle_torques.size());  // for hold_torque()
  inputs_.roller_torque.reserve(plant_.model().roller_torques.size());
  inputs_.friction.reserve(plant_.model().contacts.size());
  if (setup_) {
    system_.emplace(*setup_);
    system_->prepare(plant_.model(), inputs_);
    output_every_ =
        std::max<std::int64_t>(1, std::llround(std::min(options.output_step / setup_->step, longest_count)));
    options.output_step = 0.0;
    options.final_time = std::numeric_limits<double>::infinity();  // of whole sampling steps
  }
  std::vector<double> x(x0, x0 + plant_.sizes().states);
  start_without_slip(x.data());
  x_.resize(x.size());
  z_.resize(at(plant_.sizes().quadratures));
  integrator_.reset();
  integrator_ = std::make_unique<integrate::Integrator<DrivenDynamics>>(driven_, std::move(options));
  status_ = integrator_->start(t0, x.data());
  if (system_) system_->start(plant_);
  return status_;
}

/// Axles with a rolling constraint begin without any slip.
void Driver::start_without_slip(double* x) {
  Model const& model = plant_.model();
  if (model.rolling_constraints.empty()) return;
  plant_.evaluate(0.0, x, inputs_);
  for (std::size_t i = 0; i < model.rolling_constraints.size(); ++i) {
    RollingConstraint const& constraint = model.rolling_constraints[i];
    x[plant_.map().rate[at(constraint.wheelset)][coord_pitch]] +=
        rolling_slip(plant_, static_cast<int>(i)) / constraint.wheel_radius;
  }
}

std::int64_t Driver::steps_until(double t_stop) const {
  double const steps = std::floor(std::min(t_stop, final_time_) / setup_->step + 1e-6);
  return std::llround(std::clamp(steps, -1.0, longest_count));
}

Status Driver::advance(double t_stop, Observer const& observer) {
  if (!system_) {
    if (held_) integrator_->hold_until(t_stop);
    return status_ = integrator_->advance(t_stop, observer);
  }
  std::int64_t const last = steps_until(t_stop);
  while (status_ == Status::ok && step_ < last) {
    if (!std::exchange(sampled_, true)) sample();
    if (answers_externally_) system_->answer(step_);
    if (system_->has_pending()) return status_;
    if (!std::exchange(brake_unit_sampled_, true)) system_->ask_machines(step_);
    if (answers_externally_)
      system_->cancel_pending();  // the caller's command for the brake unit stands since answer()
    if (system_->has_pending()) return status_;
    show(observer);
    advance_step();
  }
  if (ended_as_planned()) {
    sample_end();
    show(observer);
  }
  return status_;
}

void Driver::show(Observer const& observer) const {
  if (step_ % output_every_ == 0) observer(integrator_->time(), integrator_->states(), integrator_->quadratures());
}

void Driver::sample_now() {
  if (system_ && status_ == Status::ok && !std::exchange(sampled_, true)) sample();
}

void Driver::sample() {
  plant_.evaluate(integrator_->time(), integrator_->states(), inputs_);
  system_->sample(plant_, step_, integrator_->quadratures());
}

/// What is shown last is of this instant, too; nobody outside is asked any more.
void Driver::sample_end() {
  if (std::exchange(sampled_, true)) return;
  sample();
  system_->cancel_pending();
}

void Driver::advance_step() {
  bool const fixed = integrator_->options().step > 0.0;
  if (fixed) status_ = integrator_->prepare();
  if (status_ != Status::ok) return;
  system_->act(plant_, step_, inputs_);
  if (!fixed) integrator_->drop_slope();
  double const next = setup_->step * static_cast<double>(step_ + 1);
  integrator_->hold_until(next);
  status_ = integrator_->advance(next);
  if (status_ != Status::ok) return;
  sampled_ = brake_unit_sampled_ = false;
  status_ = system_->advance(plant_, ++step_);
}

double Driver::next_sample() const {
  if (!system_) return std::numeric_limits<double>::infinity();
  return setup_->step * static_cast<double>(acted_ ? step_ + 1 : step_);
}

Status Driver::pass_sample(double const* x, double const* z) {
  Status const status = reach_sample(x, z);
  if (status == Status::ok) act_on_sample();
  return status;
}

Status Driver::reach_sample(double const* x, double const* z) {
  double const t = next_sample();
  plant_.evaluate(t, x, inputs_);
  if (acted_) {
    sampled_ = false;
    if (Status const status = system_->advance(plant_, ++step_); status != Status::ok) return status_ = status;
  }
  if (!std::exchange(sampled_, true)) system_->sample(plant_, step_, z);
  return Status::ok;
}

void Driver::act_on_sample() {
  system_->answer(step_);
  system_->ask_machines(step_);
  system_->cancel_pending();
  system_->act(plant_, step_, inputs_);
  acted_ = true;
}

void Driver::hold_torque(bool of_roller, std::size_t index, double value, double from) {
  held_ = true;
  if (inputs_.axle_torque.empty() && inputs_.roller_torque.empty()) {
    inputs_.axle_torque.resize(plant_.model().axle_torques.size());
    inputs_.roller_torque.resize(plant_.model().roller_torques.size());
  }
  (of_roller ? inputs_.roller_torque : inputs_.axle_torque)[index] = {from, value, 0.0};
  integrator_->rewind(from);
}

void Driver::ramp_speed(double speed, double over, double from) {
  Travel<double> const now = travel_now(plant_.model(), inputs_, from);
  held_ = inputs_.frame_moves = true;
  inputs_.speed = over > 0.0 ? HeldInput{from, now.speed, (speed - now.speed) / over} : HeldInput{from, speed, 0.0};
  inputs_.distance = now.s;
  integrator_->rewind(from);
}

void Driver::hold_friction(std::size_t contact, double factor, double from) {
  if (inputs_.friction.empty()) inputs_.friction.resize(plant_.model().contacts.size(), 1.0);
  inputs_.friction[contact] = factor;
  if (system_) return integrator_->drop_slope();
  held_ = true;
  integrator_->rewind(from);
}

void Driver::record_at(double t, double* row) {
  if (system_ || t >= time()) return record(time(), states(), integrator_->quadratures(), row);
  integrator_->sample(t, x_.data(), z_.data());
  record(t, x_.data(), z_.data(), row);
}

void Driver::record(double t, double const* x, double const* z, double* row) {
  recorder_.record(shown(t, x), t, x, z, row, inputs_);
  if (system_) system_->record(plant_, step_, z, inputs_, row + recorder_.width());
}

void Driver::record_reading(double t, double const* x, double const* z, double* row) {
  recorder_.record_reading(shown(t, x), t, x, z, row, inputs_);
}

}  // namespace rollerrig
