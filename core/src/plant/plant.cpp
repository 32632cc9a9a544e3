#include "rollerrig/plant/plant.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace rollerrig {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

Plant::Plant(AssembledModel assembled)
    : assembled_{std::move(assembled)},
      list_{list_variables(assembled_)},
      driver_{assembled_.model, assembled_.setup},
      value_(list_.variables.size()),
      row_(static_cast<std::size_t>(driver_.width()), nan),
      measured_(list_.measured, nan) {
  driver_.answer_for_controllers();
  for (WheelContact const& contact : assembled_.model->contacts) wheels_.push_back(wheel_name(assembled_, contact));
}

int Plant::find(std::string_view name) const {
  auto const found = std::ranges::find(list_.variables, name, &Variable::name);
  return found == list_.variables.end() ? -1 : static_cast<int>(found - list_.variables.begin());
}

Status Plant::start(double final_time) {
  integrate::Options options = assembled_.options;
  options.final_time = final_time;
  options.output_step = 0.0;
  status_ = driver_.start(std::move(options), assembled_.start_time, assembled_.start.data());
  for (std::size_t i = 0; i < value_.size(); ++i) value_[i] = list_.variables[i].start;
  time_ = driver_.time();
  driver_.sample_now();
  fresh_ = false;
  return status_;
}

Status Plant::advance(double t) {
  if (!started()) return Status::not_finite;
  if (status_ != Status::ok || !(t > time_)) return status_;
  status_ = driver_.advance(t, [](double, double const*, double const*) {});
  driver_.sample_now();
  time_ = driver_.system() != nullptr || status_ != Status::ok ? driver_.time() : std::min(t, driver_.time());
  fresh_ = false;
  return status_;
}

bool Plant::set_input(int index, double value) {
  if (index < 0 || index >= static_cast<int>(list_.variables.size()) || !started()) return false;
  auto const i = static_cast<std::size_t>(index);
  if (list_.variables[i].causality != Causality::input || !list_.variables[i].allows(value)) return false;
  if (value_[i] == value) return true;
  value_[i] = value;
  Place const& place = list_.places[i];
  if (MechatronicSystem* system = driver_.system()) {
    CallerDemands& caller = system->caller();
    if (place.kind == Place::brake_demand) caller.brake_demand[place.index] = value;
    if (place.kind == Place::motor_torque) caller.motor_torque[place.index] = value;
    if (place.kind == Place::command) caller.commands[place.item][place.index] = value;
  } else {
    driver_.hold_torque(place.kind == Place::roller_torque, place.index, value, time_);
  }
  return true;
}

double Plant::get(int index) {
  if (index < 0 || index >= static_cast<int>(list_.variables.size())) return nan;
  auto const i = static_cast<std::size_t>(index);
  if (list_.variables[i].causality != Causality::output) return value_[i];
  if (!started()) return nan;
  if (!std::exchange(fresh_, true)) read_outputs();
  Place const& place = list_.places[i];
  if (place.kind == Place::measured) return measured_[place.index];
  return place.kind == Place::side_ratio ? row_[place.index] / row_[place.item] : row_[place.index];
}

void Plant::read_outputs() {
  driver_.record_at(time_, row_.data());
  if (!assembled_.setup) return;
  double* out = measured_.data();
  for (std::size_t i = 0; i < assembled_.setup->controllers.size(); ++i) {
    if (!assembled_.setup->controllers[i].sampling.external) continue;
    driver_.system()->measure(i, out);
    out += driver_.system()->measurement_width(i);
  }
}

std::string_view Plant::failed_wheel() const {
  int const contact = driver_.failed_contact();
  return contact < 0 ? std::string_view{} : std::string_view{wheels_[static_cast<std::size_t>(contact)]};
}

}  // namespace rollerrig
