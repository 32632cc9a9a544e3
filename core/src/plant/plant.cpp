#include "rollerrig/plant/plant.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <limits>
#include <utility>

#include "rollerrig/integrate/integrator.hpp"
#include "rollerrig/plant/continuous_plant.hpp"
#include "rollerrig/plant/state_archive.hpp"

namespace rollerrig {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

Plant::Plant(AssembledModel assembled)
    : assembled_{std::move(assembled)},
      parameters_{assembled_},
      list_{list_variables(assembled_)},
      driver_{std::make_unique<Driver>(assembled_.model, assembled_.setup)},
      row_(at(driver_->width()), nan),
      measured_(list_.measured, nan) {
  driver_->answer_for_controllers();
  for (std::size_t i = 0; i < parameters_.variables().size(); ++i)
    list_.add(parameters_.variables()[i], {Place::parameter, i});
  check_unique(list_);
  for (std::size_t i = 0; i < list_.variables.size(); ++i) {
    value_.push_back(list_.variables[i].start);
    if (list_.places[i].kind == Place::running_speed) at_speed_ = i;
    if (list_.places[i].kind == Place::rise_time) at_rise_time_ = i;
  }
  for (WheelContact const& contact : assembled_.model->contacts) wheels_.push_back(wheel_name(assembled_, contact));
}

Plant::~Plant() = default;

ContinuousPlant* Plant::continuous() {
  if (started() && !continuous_) continuous_ = std::make_unique<ContinuousPlant>(*this);
  return continuous_.get();
}

std::string_view Plant::failed_wheel() const {
  return continuous_ ? continuous_->failed_wheel() : wheel_of(driver_->failed_contact());
}

int Plant::find(std::string_view name) const {
  auto const found = std::ranges::find(list_.variables, name, &Variable::name);
  return found == list_.variables.end() ? -1 : static_cast<int>(found - list_.variables.begin());
}

/// The model with the parameters that were set.
void Plant::renew() {
  AssembledModel renewed = parameters_.assembled();
  renewed.check();
  auto driver = std::make_unique<Driver>(renewed.model, renewed.setup);
  driver->answer_for_controllers();
  assembled_ = std::move(renewed);
  driver_ = std::move(driver);
  changed_ = false;
}

bool Plant::set_parameter(int index, double value) {
  if (index < 0 || index >= static_cast<int>(list_.variables.size())) return false;
  auto const i = at(index);
  Variable const& variable = list_.variables[i];
  bool const fixed = variable.variability == Variability::fixed;
  if (variable.causality != Causality::parameter || !variable.allows(value) || (fixed && started())) return false;
  value_[i] = value;
  parameters_.set(list_.places[i].index, value);
  changed_ = changed_ || fixed;
  if (!fixed) driver_->system()->set_controllers(parameters_.controllers());
  return true;
}

Status Plant::start(double final_time) {
  continuous_.reset();
  if (changed_ || started()) renew();  // nothing of a run before is left
  integrate::Options options = assembled_.options;
  options.final_time = final_time;
  options.output_step = 0.0;
  status_ = driver_->start(std::move(options), assembled_.start_time, assembled_.start.data());
  shown_ = {};
  for (std::size_t i = 0; i < value_.size(); ++i)
    if (list_.variables[i].causality == Causality::input) value_[i] = list_.variables[i].start;
  if (MechatronicSystem* system = driver_->system()) system->set_controllers(parameters_.controllers());
  time_ = driver_->time();
  ramp_end_ = never;
  driver_->sample_now();
  row_fresh_ = measured_fresh_ = false;
  return status_;
}

Status Plant::advance(double t) {
  continuous_.reset();
  if (!started()) return Status::not_finite;
  if (status_ != Status::ok || !(t > time_)) return status_;
  shown_ = {};
  auto const unseen = [](double, double const*, double const*) {};
  if (double const end = ramp_end_; end <= t) {
    status_ = driver_->advance(end, unseen);
    if (status_ == Status::ok && driver_->time() >= end) end_ramp();
  }
  if (status_ == Status::ok) status_ = driver_->advance(t, unseen);
  driver_->sample_now();
  time_ = driver_->system() != nullptr || status_ != Status::ok ? driver_->time() : std::min(t, driver_->time());
  row_fresh_ = measured_fresh_ = false;
  return status_;
}

bool Plant::set_input(int index, double value) {
  if (index < 0 || index >= static_cast<int>(list_.variables.size()) || !started()) return false;
  auto const i = at(index);
  if (list_.variables[i].causality != Causality::input || !list_.variables[i].allows(value)) return false;
  if (value_[i] == value) return true;
  value_[i] = value;
  apply(list_.places[i], value);
  if (continuous_) continuous_->forget();
  return true;
}

void Plant::show(double t, std::span<double const> states) {
  time_ = t;
  shown_ = states;
  row_fresh_ = false;
}

void Plant::hold_input(std::size_t index, double value) {
  Place::Kind const kind = list_.places[index].kind;
  if (kind == Place::running_speed || kind == Place::rise_time) return;  // a change begins a ramp, nothing jumps
  value_[index] = value;
  apply(list_.places[index], value);
}

void Plant::apply(Place const& place, double value) {
  if (place.kind == Place::friction) return driver_->hold_friction(place.index, 1.0 + value, time_);
  if (place.kind == Place::running_speed) return ramp_speed(value);
  if (place.kind == Place::rise_time) return;  // of the next command
  MechatronicSystem* system = driver_->system();
  if (system == nullptr) return driver_->hold_torque(place.kind == Place::roller_torque, place.index, value, time_);
  CallerDemands& caller = system->caller();
  if (place.kind == Place::brake_demand) caller.brake_demand[place.index] = value;
  if (place.kind == Place::motor_torque) caller.motor_torque[place.index] = value;
  if (place.kind == Place::command) (caller.commands.*command_fields[place.item].of)[place.index] = value;
  if (place.kind == Place::speed_control) caller.speed_control[place.index] = value;
  if (place.kind == Place::roller_speed) caller.roller_speed[place.index] = value;
  if (place.kind == Place::rail_friction) caller.rail_friction = 1.0 + value;
  if (place.kind == Place::train_force) caller.train_force = value;
}

/// From the present speed to another, on a straight line.
void Plant::ramp_speed(double speed) {
  double const over = value_[at_rise_time_];
  driver_->ramp_speed(speed, over, time_);
  ramp_end_ = time_ + over;
}

void Plant::end_ramp() { driver_->ramp_speed(value_[at_speed_], 0.0, std::exchange(ramp_end_, never)); }

double Plant::get(int index) {
  if (index < 0 || index >= static_cast<int>(list_.variables.size())) return nan;
  auto const i = at(index);
  if (list_.variables[i].causality != Causality::output) return value_[i];
  if (!started()) return nan;
  Place const& place = list_.places[i];
  if (place.kind == Place::measured) {
    if (!std::exchange(measured_fresh_, true)) read_measurements();
    return measured_[place.index];
  }
  if (!std::exchange(row_fresh_, true)) {
    if (shown_.empty())
      driver_->record_at(time_, row_.data());
    else
      driver_->record(time_, shown_.data(), shown_.data() + driver_->observed().sizes().states, row_.data());
  }
  return place.kind == Place::side_ratio ? row_[place.index] / row_[place.item] : row_[place.index];
}

void Plant::read_measurements() {
  double* out = measured_.data();
  for (std::size_t i = 0; i < assembled_.setup->controllers.size(); ++i) {
    if (!assembled_.setup->controllers[i].sampling.external) continue;
    driver_->system()->measure(i, out);
    out += driver_->system()->measurement_width(i);
  }
}

/// What the bytes of a state are for: this model, with these fixed parameters.
std::uint64_t Plant::identity() {
  if (identity_ == 0) identity_ = crc64(write_model(parameters_.given())) | 1;
  std::uint64_t known = identity_;
  for (std::size_t i = 0; i < value_.size(); ++i)
    if (list_.variables[i].causality == Causality::parameter && list_.variables[i].variability == Variability::fixed)
      known = crc64(std::as_bytes(std::span(&value_[i], 1)), known);
  return known;
}

std::vector<std::byte> Plant::save() {
  if (!started()) return {};
  StateWriter archive;
  state(archive);
  return sealed(identity(), archive.out.bytes());
}

bool Plant::restore(std::span<std::byte const> bytes) {
  continuous_.reset();
  std::uint64_t const model = identity();
  auto const wanted = unsealed(model, bytes);
  if (wanted.empty()) return false;
  std::vector<std::byte> const before = save();
  std::vector<double> const values = value_;
  try {
    read(wanted);
    if (identity() == model) return true;
  } catch (FormatError const&) {  // the checksum is right: whoever made it knew how
  }
  value_ = values;
  take_parameters();
  if (!before.empty()) {
    read(unsealed(identity(), before));
    return false;
  }
  renew();
  time_ = 0.0;
  return false;
}

/// Into a run that has just begun, where lists have their lengths.
void Plant::read(std::span<std::byte const> bytes) {
  start(assembled_.options.final_time);
  StateReader archive(bytes);
  state(archive);
  for (std::size_t i = 0; i < value_.size(); ++i)
    archive.need(list_.variables[i].causality == Causality::output || list_.variables[i].allows(value_[i]));
  bool const over = status_ != Status::ok;
  bool const stepped = driver_->statistics().steps > 0;  // not so where another program integrates
  archive.need(over || (time_ >= driver_->step_start() && (!stepped || time_ <= driver_->time())));
  archive.end(over);
  take_parameters();
  row_fresh_ = measured_fresh_ = false;
}

void Plant::take_parameters() {
  for (std::size_t i = 0; i < value_.size(); ++i)
    if (list_.places[i].kind == Place::parameter) parameters_.set(list_.places[i].index, value_[i]);
  if (MechatronicSystem* system = driver_->system()) system->set_controllers(parameters_.controllers());
}

std::string_view Plant::wheel_of(int contact) const {
  return contact < 0 ? std::string_view{} : std::string_view{wheels_[at(contact)]};
}

}  // namespace rollerrig
