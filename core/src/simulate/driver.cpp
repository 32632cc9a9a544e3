#include "rollerrig/simulate/driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "rollerrig/system/outputs.hpp"

namespace rollerrig {

Driver::Driver(std::shared_ptr<Model const> model, std::optional<MechatronicSetup> setup)
    : plant_{model}, observed_{model}, recorder_{*model}, setup_{std::move(setup)} {
  if (setup_) system_.emplace(*setup_);
}

Status Driver::start(integrate::Options options, double t0, double const* x0) {
  plant_.reset_run();
  final_time_ = options.final_time;
  step_ = 0;
  sampled_ = false;
  if (setup_) {
    system_.emplace(*setup_);
    system_->prepare(plant_.model(), inputs_);
    output_every_ = std::max(1L, std::lround(options.output_step / setup_->step));
    options.output_step = 0.0;
    options.final_time = std::numeric_limits<double>::infinity();  // of whole sampling steps
  }
  std::vector<double> x(x0, x0 + plant_.sizes().states);
  start_without_slip(x.data());
  integrator_.emplace(driven_, std::move(options));
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
    x[plant_.map().rate[static_cast<std::size_t>(constraint.wheelset)][coord_pitch]] +=
        rolling_slip(plant_, static_cast<int>(i)) / constraint.wheel_radius;
  }
}

long Driver::steps_until(double t_stop) const {
  return std::lround(std::floor(std::min(t_stop, final_time_) / setup_->step + 1e-6));
}

void Driver::sample() {
  plant_.evaluate(integrator_->time(), integrator_->states(), inputs_);
  system_->sample(plant_, step_, integrator_->quadratures());
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
  sampled_ = false;
  status_ = system_->advance(plant_, ++step_);
}

void Driver::record(double t, double const* x, double const* z, double* row) {
  recorder_.record(system_ ? plant_ : observed_, t, x, z, row, inputs_);
  if (system_) system_->record(plant_, step_, z, inputs_, row + recorder_.width());
}

}  // namespace rollerrig
