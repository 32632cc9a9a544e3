#include "rollerrig/plant/continuous_plant.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rollerrig/simulate/recorder.hpp"

namespace rollerrig {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr double lifted = 1.0;             ///< normal force below which a wheel counts as off [N]
constexpr double difference_step = 1e-5;   ///< of nominal values
constexpr double friction_nominal = 1.0;   ///< [-] relative change
constexpr double torque_nominal = 1000.0;  ///< [N m]

// Changes that count: millimetres and milliradians, ten times as much in a second, a radian turned, a kilojoule.
constexpr double nominal_displacement = 1e-3, nominal_rate = 1e-2, nominal_angle = 1.0, nominal_work = 1e3;

Variable local(std::string name, std::string unit, std::string what, double nominal) {
  return {std::move(name), std::move(unit), std::move(what), Causality::local, Variability::continuous, 0.0,
          -endless,        nominal};
}

}  // namespace

ContinuousVariables list_continuous_variables(AssembledModel const& assembled) {
  assembled.check();
  Model const& model = *assembled.model;
  StateMap const& map = model.map;
  ContinuousVariables all;
  all.states.resize(at(map.states()));
  auto const fields = Recorder::body_fields();
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    for (std::size_t c = 0; c < 6; ++c) {
      auto const put = [&](int state, Field const& field, double nominal) {
        if (state < 0) return;
        all.states[at(state)] = local("state." + assembled.names.bodies[b] + "." + std::string(field.name),
                                      std::string(field.unit), std::string(field.meaning), nominal);
      };
      put(map.coordinate[b][c], fields[c], nominal_displacement);
      put(map.rate[b][c], fields[6 + c], nominal_rate);
    }
  for (int k = 0; k < map.nodes; ++k)
    all.states[at(map.coordinates + map.rates + k)] =
        local("state.node_" + std::to_string(k + 1), "m", "motion of the node between spring and damper in series",
              nominal_displacement);
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    if (map.angle[b] >= 0)  // in the order of their indices
      all.states.push_back(local("state." + assembled.names.bodies[b] + ".angle", "rad",
                                 "angle that the body has turned", nominal_angle));
  for (Field const& account : Recorder::run_fields().subspan(3, account_count))  // behind what is stored
    all.states.push_back(local("state." + std::string(account.name), "J", std::string(account.meaning), nominal_work));
  for (Variable const& state : all.states)
    all.rates.push_back(local("der(" + state.name + ")", state.unit == "J" ? "W" : state.unit + "/s",
                              "rate of " + state.name, endless));
  for (WheelContact const& contact : model.contacts)
    all.indicators.push_back(local("indicator." + wheel_name(assembled, contact), "N",
                                   "normal force of the wheel above 1 N; negative: it has lifted off", endless));
  return all;
}

ContinuousPlant::ContinuousPlant(Plant& plant) : plant_{plant}, time_{plant.time()}, passed_{plant.time()}, nominal_{} {
  Driver& driver = plant_.driver();
  auto const sizes = driver.observed().sizes();
  state_.resize(at(sizes.states + sizes.quadratures));
  driver.sample_states(time_, state_.data(), state_.data() + sizes.states);
  for (Variable const& state : list_continuous_variables(plant.assembled()).states) nominal_.push_back(state.most);
  plant_.show(time_, state_);
}

void ContinuousPlant::set_time(double t) {
  time_ = t;
  forget();
}

void ContinuousPlant::set_states(std::span<double const> states) {
  std::copy_n(states.begin(), state_.size(), state_.begin());
  forget();
}

void ContinuousPlant::forget() {
  linear_fresh_ = false;
  plant_.show(evaluated_time(), state_);
}

/// Tables jump at their instant: a step that ends there is of what stands before.
double ContinuousPlant::evaluated_time() const {
  double const event = next_event();
  return time_ >= event ? std::nextafter(event, -endless) : time_;
}

double ContinuousPlant::next_event() const {
  double next = std::min(plant_.driver().next_sample(), plant_.ramp_end());
  for (double const b : plant_.assembled().options.breakpoints)
    if (b > passed_) next = std::min(next, b);
  return next;
}

Status ContinuousPlant::pass_event() {
  constexpr double round_off = 1e-12;
  double const until = time_ + round_off * std::max(1.0, std::abs(time_));
  Status status = Status::ok;
  if (Driver& driver = plant_.driver(); driver.next_sample() <= until)
    status = driver.pass_sample(state_.data(), state_.data() + dynamics().sizes().states);
  for (double const b : plant_.assembled().options.breakpoints)
    if (b <= until) passed_ = std::max(passed_, b);
  if (plant_.ramp_end() <= until) plant_.end_ramp();
  forget();
  return status;
}

Status ContinuousPlant::rates(double* out) {
  auto const states = at(dynamics().sizes().states);
  Status const status =
      dynamics().derivative(evaluated_time(), state_.data(), out, out + states, plant_.driver().inputs());
  if (status != Status::ok) return status;
  return std::all_of(out, out + count(), [](double r) { return std::isfinite(r); }) ? Status::ok : Status::not_finite;
}

Status ContinuousPlant::indicators(double* out) {
  dynamics().evaluate(evaluated_time(), state_.data(), plant_.driver().inputs());
  for (std::size_t c = 0; c < indicator_count(); ++c) {
    double load = 0.0;
    for (int k = 0; k < dynamics().patch_count(static_cast<int>(c)); ++k)
      load += dynamics().patch(static_cast<int>(c), k).normal.total();
    out[c] = load - lifted;
  }
  return Status::ok;
}

Status ContinuousPlant::accept() {
  return dynamics().accept(evaluated_time(), state_.data(), plant_.driver().inputs());
}

std::string_view ContinuousPlant::failed_wheel() const {
  return plant_.wheel_of(plant_.driver().observed().failed_contact());
}

std::vector<double> ContinuousPlant::save() const {
  std::vector<double> numbers{time_, passed_};
  numbers.insert(numbers.end(), state_.begin(), state_.end());
  return numbers;
}

bool ContinuousPlant::restore(std::span<double const> numbers) {
  if (numbers.size() != 2 + state_.size() || !std::ranges::all_of(numbers, [](double v) { return std::isfinite(v); }))
    return false;
  time_ = numbers[0];
  passed_ = numbers[1];
  set_states(numbers.subspan(2));
  return true;
}

/// Whether an input is a torque of the linear model, and which of its columns.
bool ContinuousPlant::torque(Known const& known, std::size_t& column) const {
  Place const& place = plant_.place(known.index);
  column = place.index + (place.kind == Place::roller_torque ? model().axle_torques.size() : 0);
  return place.kind == Place::axle_torque || place.kind == Place::roller_torque;
}

/// Whether the linear model has it, and which of its rows, of the outputs or of the states.
bool ContinuousPlant::exact(Unknown const& unknown, std::size_t& row, bool& output) const {
  row = unknown.index;
  output = unknown.kind == Unknown::output;
  if (unknown.kind == Unknown::rate) return row < at(model().map.states());
  if (!output || plant_.place(unknown.index).kind != Place::recorded) return false;
  row = plant_.place(unknown.index).index;
  std::size_t const body = row / Recorder::body_fields().size();
  if (row >= at(linear_.c.rows())) return false;
  // The angle that a body has turned is a state of its own.
  bool const turned = body < model().bodies.size() && row % Recorder::body_fields().size() == coord_pitch &&
                      model().map.angle[body] >= 0;
  return !turned;
}

Status ContinuousPlant::read(std::span<Unknown const> unknown, double* out) {
  std::vector<double> rate(count()), indicator(indicator_count());
  if (auto e = rates(rate.data()); e != Status::ok) return e;
  if (auto e = indicators(indicator.data()); e != Status::ok) return e;
  for (std::size_t i = 0; i < unknown.size(); ++i) {
    std::size_t const k = unknown[i].index;
    out[i] = unknown[i].kind == Unknown::rate     ? rate[k]
             : unknown[i].kind == Unknown::output ? plant_.get(static_cast<int>(k))
                                                  : indicator[k];
  }
  return Status::ok;
}

Status ContinuousPlant::difference(std::span<Known const> known, std::span<Unknown const> unknown, double* out) {
  double largest = 0.0;
  std::size_t column = 0;
  for (Known const& one : known) {
    double const nominal = one.kind == Known::state ? nominal_[one.index]
                           : torque(one, column)    ? torque_nominal
                                                    : friction_nominal;
    largest = std::max(largest, std::abs(one.seed) / nominal);
  }
  std::fill_n(out, unknown.size(), 0.0);
  if (largest == 0.0) return Status::ok;
  double const h = difference_step / largest;
  std::vector<double> const before = state_;
  std::vector<double> inputs;
  for (Known const& one : known)
    inputs.push_back(one.kind == Known::input ? plant_.get(static_cast<int>(one.index)) : 0.0);
  std::vector<double> value(unknown.size());
  Status status = Status::ok;
  auto const move = [&](double way) {
    state_ = before;
    for (std::size_t k = 0; k < known.size(); ++k) {
      if (known[k].kind == Known::state) state_[known[k].index] += way * h * known[k].seed;
      if (known[k].kind == Known::input) plant_.hold_input(known[k].index, inputs[k] + way * h * known[k].seed);
    }
    forget();
  };
  for (double const way : {1.0, -1.0}) {
    move(way);
    if (status == Status::ok) status = read(unknown, value.data());
    for (std::size_t i = 0; i < unknown.size(); ++i) out[i] += way * value[i] / (2.0 * h);
  }
  move(0.0);
  return status;
}

Status ContinuousPlant::directional(std::span<Known const> known, std::span<Unknown const> unknown, double* out) {
  Inputs const& inputs = plant_.driver().inputs();
  double const t = evaluated_time();
  if (!linear_fresh_) {
    JacobianData j(dynamics().sizes());
    if (auto e = dynamics().jacobian(t, state_.data(), j, inputs); e != Status::ok) return e;
    work_ = j.g;
    linear_ = linear_model(dynamics(), t, state_.data(), inputs);
  }
  linear_fresh_ = true;
  std::vector<Known> others, by_input;  // of what the linear model has not
  std::size_t column = 0, row = 0;
  bool output = false;
  Eigen::VectorXd by_state = Eigen::VectorXd::Zero(linear_.a.cols()),
                  by_torque = Eigen::VectorXd::Zero(linear_.b.cols());
  for (Known const& one : known) {
    if (one.kind == Known::input) by_input.push_back(one);
    if (one.kind == Known::state && one.index < at(model().map.states()))
      by_state[static_cast<Eigen::Index>(one.index)] += one.seed;
    else if (one.kind == Known::input && torque(one, column))
      by_torque[static_cast<Eigen::Index>(column)] += one.seed;
    else
      others.push_back(one);
  }
  std::vector<double> all(unknown.size()), rest(unknown.size()), fed(unknown.size());
  auto const quadrature = [&](Unknown const& u) {
    return u.kind == Unknown::rate && u.index >= at(model().map.states());
  };
  bool const whole =
      std::ranges::all_of(unknown, [&](auto const& u) { return exact(u, row, output) || quadrature(u); });
  if (auto e = difference(by_input, unknown, fed.data()); e != Status::ok) return e;
  if (auto e = whole ? Status::ok : difference(known, unknown, all.data()); e != Status::ok) return e;
  if (auto e = difference(others, unknown, rest.data()); e != Status::ok) return e;
  for (std::size_t i = 0; i < unknown.size(); ++i) {
    if (quadrature(unknown[i])) {
      auto const r = static_cast<Eigen::Index>(unknown[i].index) - model().map.states();
      out[i] = fed[i] + work_.row(r).dot(by_state);
      continue;
    }
    if (!exact(unknown[i], row, output)) {
      out[i] = all[i];
      continue;
    }
    auto const r = static_cast<Eigen::Index>(row);
    out[i] = rest[i] + (output ? linear_.c.row(r).dot(by_state) + linear_.d.row(r).dot(by_torque)
                               : linear_.a.row(r).dot(by_state) + linear_.b.row(r).dot(by_torque));
  }
  return Status::ok;
}

}  // namespace rollerrig
