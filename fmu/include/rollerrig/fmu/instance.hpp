// fmu/instance.hpp - one FMU that runs: which call is allowed when, values by reference, steps. Of both versions of the standard.
//
//   calls of FMI 2.0, of FMI 3.0 -> [instance] -> Plant
//
// Reference 0 is the time; reference i + 1 the i-th variable of the plant. A call that is refused changes nothing.
// Source: FMI 2.0.4, sections 2.1 and 4.2; FMI 3.0.2, sections 2.3 and 4.2.
#pragma once
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rollerrig/fmu/handles.hpp"
#include "rollerrig/plant/byte_stream.hpp"
#include "rollerrig/plant/continuous_plant.hpp"
#include "rollerrig/status.hpp"

namespace rollerrig::fmu {

/// What a call ends with, as both versions of the standard count.
enum class Answer : int { ok = 0, discard = 2, error = 3 };

/// What an FMU tells the tool that runs it.
struct Log {
  std::function<void(Answer answer, char const* category, char const* text)> write{};
  char const* call{""};  ///< that is answered

  /// A line as printf would write it, behind the call and cut to the buffer; gives the answer back.
  [[gnu::format(printf, 3, 4)]] Answer operator()(Answer answer, char const* format, ...) const {
    if (!write) return answer;
    char text[1024];
    int const head = std::snprintf(text, sizeof text, "%s: ", call);
    std::va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(text + head, sizeof text - at(head), format, arguments);
    va_end(arguments);
    write(answer, answer == Answer::discard ? "logStatusDiscard" : "logStatusError", text);
    return answer;
  }
};

/// States of the standards' state machines: bits, so that a call names all in which it may come.
enum Phase : unsigned {
  instantiated = 1,
  initializing = 2,
  stepping = 4,
  step_failed = 8,  ///< the model left its validity, or the run ended
  terminated = 16,
  event_mode = 32,  ///< of model exchange
  continuous_time = 64,
};
constexpr unsigned exchanging = event_mode | continuous_time;
constexpr unsigned running = stepping | step_failed | terminated | exchanging;

/// What a step ended with.
struct StepEnd {
  bool run_over{false};  ///< nothing follows: the train has stopped, or the model's validity ended
  double time{};         ///< up to which results are valid [s]
};

constexpr double longest_step = 86400.0;  ///< between communication points [s]: a day
constexpr double longest_lag = 10.0;      ///< of a plant with sampled blocks behind the communication point [s]

using Reference = std::uint32_t;

class Instance {
 public:
  Instance(std::unique_ptr<AnyPlant> plant, Log tell_tool, bool exchange = false)
      : log{tell_tool}, plant_{std::move(plant)}, chosen_(plant_->variables().size(), unset), exchange_{exchange} {}

  Log log;

  Phase phase() const { return phase_; }
  double time() const { return time_; }
  StepEnd const& last_step() const { return step_; }
  AnyPlant& plant() { return *plant_; }

  /// Whether a call may come now; if not, the log says so.
  bool may(unsigned phases) const {
    if ((phase_ & phases) != 0) return true;
    log(Answer::error, "not allowed %s", where());
    return false;
  }

  Answer setup(double start, bool has_stop, double stop) {
    if (!may(instantiated)) return Answer::error;
    if (!std::isfinite(start)) return log(Answer::error, "startTime must be a finite number");
    if (has_stop && !(std::isfinite(stop) && stop > start))
      return log(Answer::error, "stopTime must be later than startTime");
    start_ = time_ = start;
    stop_ = has_stop ? stop : endless;
    return Answer::ok;
  }

  Answer enter_initialization() {
    if (!may(instantiated)) return Answer::error;
    if (Answer const answer = begin(); answer != Answer::ok) return answer;
    step_ = {false, start_};
    phase_ = initializing;
    return Answer::ok;
  }

  Answer exit_initialization() {
    if (!may(initializing)) return Answer::error;
    phase_ = exchange_ ? event_mode : stepping;
    return Answer::ok;
  }

  /// Between event mode and continuous time.
  Answer go(Phase from, Phase to) {
    if (!may(from)) return Answer::error;
    phase_ = to;
    return Answer::ok;
  }

  Answer terminate() {
    if (!may(stepping | step_failed | exchanging)) return Answer::error;
    phase_ = terminated;
    return Answer::ok;
  }

  Answer reset() {
    plant_ = plant_->anew();
    chosen_.assign(chosen_.size(), unset);
    phase_ = instantiated;
    start_ = time_ = 0.0;
    stop_ = endless;
    return Answer::ok;
  }

  /// @param count   of references, each of a scalar
  /// @param values  as many
  Answer set(Reference const* references, std::size_t count, double const* values) {
    if (!may(instantiated | initializing | stepping | exchanging)) return Answer::error;
    if (count > 0 && (references == nullptr || values == nullptr)) return log(Answer::error, "null pointer");
    auto const all = variables();
    for (std::size_t k = 0; k < count; ++k) {
      if (references[k] == 0 || references[k] > all.size())
        return log(Answer::error, "no variable that can be set has the reference %u", references[k]);
      Variable const& variable = all[references[k] - 1];
      if (variable.causality == Causality::output) return log(Answer::error, "%s is an output", variable.name.c_str());
      if (variable.causality == Causality::parameter && variable.variability == Variability::fixed && begun())
        return log(Answer::error, "%s is fixed after the initialization", variable.name.c_str());
      if (!variable.allows(values[k]))
        return log(Answer::error, "%s = %g is not allowed: a %snumber from %g to %g", variable.name.c_str(), values[k],
                   variable.whole ? "whole " : "", variable.least, variable.most);
    }
    bool again = false;  // a fixed parameter moves the start
    std::vector<double> const chosen = phase_ == initializing ? chosen_ : std::vector<double>{};
    for (std::size_t k = 0; k < count; ++k) {
      std::size_t const i = references[k] - 1;
      Variable const& variable = all[i];
      bool const fixed = variable.causality == Causality::parameter && variable.variability == Variability::fixed;
      if (!begun()) chosen_[i] = values[k];
      again = again || (fixed && phase_ == initializing);
      if (phase_ != instantiated && !fixed && !apply(i, values[k]))
        return log(Answer::error, "%s = %g was refused", variable.name.c_str(), values[k]);
    }
    if (!again) return Answer::ok;
    return begin_again(chosen);
  }

  Answer get(Reference const* references, std::size_t count, double* values) {
    if (!may(initializing | running)) return Answer::error;
    if (count > 0 && (references == nullptr || values == nullptr)) return log(Answer::error, "null pointer");
    std::size_t const last = variables().size() + locals();
    for (std::size_t k = 0; k < count; ++k)
      if (references[k] > last) return log(Answer::error, "no variable has the reference %u", references[k]);
    for (std::size_t k = 0; k < count; ++k)
      values[k] = references[k] == 0                   ? time_
                  : references[k] > variables().size() ? local(references[k] - variables().size() - 1)
                                                       : plant_->get(static_cast<int>(references[k]) - 1);
    return Answer::ok;
  }

  /// The plant's own steps do not depend on the communication step. With sampled blocks outputs are those of the last
  /// sampling step within it.
  Answer step(double at, double length) {
    if (!may(stepping)) return Answer::error;
    double const round_off = 1e-9 * std::max(1.0, std::abs(time_));  // importers add up their steps
    if (!(std::abs(at - time_) <= round_off))
      return log(Answer::error, "currentCommunicationPoint is %.17g, the FMU stands at %.17g s", at, time_);
    if (!(std::isfinite(length) && length > 0.0))
      return log(Answer::error, "communicationStepSize must be positive, got %g", length);
    if (length > longest_step)  // nothing could interrupt it
      return log(Answer::error, "communicationStepSize is %g s; allowed: up to %g", length, longest_step);
    double const target = at + length;
    if (!(target > at)) return log(Answer::error, "at %g s a step of %g s is lost in round-off", at, length);
    if (!(target <= stop_ + round_off))
      return log(Answer::error, "the step ends at %g s, after stopTime %g s", target, stop_);
    Status const status = plant_->advance(target - offset_);
    bool const ok = status == Status::ok;
    time_ = ok ? target : plant_->time() + offset_;
    step_ = {!ok, time_};
    if (ok) return Answer::ok;
    phase_ = step_failed;
    return tell(status, Answer::discard);
  }

  /// Time of the tool minus that of the plant [s].
  double offset() const { return offset_; }
  void set_time(double time) { time_ = time; }

  /// States, rates and event indicators of a plant that another program could integrate: behind the plant's variables.
  std::size_t locals() {
    ContinuousPlant const* const continuous = plant_->continuous();
    return continuous == nullptr ? 0 : 2 * continuous->count() + continuous->indicator_count();
  }

  Answer tell(Status status, Answer answer) const {
    std::string const wheel{plant_->failed_wheel()};
    double const time = exchange_ ? time_ : plant_->time() + offset_;
    return log(answer, "at %.6g s%s%s: %s", time, wheel.empty() ? "" : ", ", wheel.c_str(),
               std::string(status_sentence(status)).c_str());
  }

  /// Everything, as bytes that only an instance of the same model takes back.
  std::vector<std::byte> save() {
    Head head;
    head.phase = phase_, head.chosen = chosen_.size(), head.exchange = exchange_;
    head.start = start_, head.stop = stop_, head.offset = offset_, head.time = time_, head.step = step_;
    std::vector<std::byte> bytes(sizeof head + chosen_.size() * sizeof(double));
    std::memcpy(bytes.data() + sizeof head, chosen_.data(), chosen_.size() * sizeof(double));
    if (phase_ != instantiated) {
      auto const states = exchange_ ? plant_->continuous()->save() : std::vector<double>{};
      auto const from = std::as_bytes(std::span(states));
      head.states = states.size();
      bytes.insert(bytes.end(), from.begin(), from.end());
      auto const plant = plant_->save();
      bytes.insert(bytes.end(), plant.begin(), plant.end());
    }
    head.checksum = crc64(std::span(std::as_const(bytes)).subspan(sizeof head));
    std::memcpy(bytes.data(), &head, sizeof head);
    return bytes;
  }

  /// Whether bytes are a saved state as a whole; of which model is seen when they are taken back.
  static bool is_state(std::span<std::byte const> bytes) {
    Head head;
    if (bytes.size() < sizeof head) return false;
    std::memcpy(&head, bytes.data(), sizeof head);
    return head.mark == Head{}.mark && head.chosen <= (bytes.size() - sizeof head) / sizeof(double) &&
           head.states <= (bytes.size() - sizeof head) / sizeof(double) - head.chosen &&
           head.checksum == crc64(bytes.subspan(sizeof head));
  }

  /// Goes on from there. What is refused changes nothing.
  Answer restore(std::span<std::byte const> bytes) {
    if (!is_state(bytes)) return log(Answer::error, "these bytes are no saved state");
    Head head;
    std::memcpy(&head, bytes.data(), sizeof head);
    auto const rest = bytes.subspan(sizeof head);
    if (head.chosen != chosen_.size() || (head.exchange != 0) != exchange_)
      return log(Answer::error, "the state of another FMU");
    auto fresh = plant_->anew();
    std::vector<double> states(head.states), chosen(head.chosen);
    std::memcpy(chosen.data(), rest.data(), head.chosen * sizeof(double));
    if (!sound(head) || !take_chosen(*fresh, chosen)) return log(Answer::error, "no state that this FMU can be in");
    if (!states.empty())
      std::memcpy(states.data(), rest.data() + head.chosen * sizeof(double), head.states * sizeof(double));
    auto const run = rest.subspan((head.chosen + head.states) * sizeof(double));
    if (head.phase != instantiated && !(fresh->restore(run) && restore_states(*fresh, states)))
      return log(Answer::error, "the state of another FMU");
    double const lag = head.time - head.offset - fresh->time();
    if (head.phase == stepping && !(lag > -longest_lag && lag < longest_lag))
      return log(Answer::error, "no state that this FMU can be in");
    plant_ = std::move(fresh);
    chosen_ = std::move(chosen);
    phase_ = static_cast<Phase>(head.phase);
    start_ = head.start, stop_ = head.stop, offset_ = head.offset, time_ = head.time, step_ = head.step;
    return Answer::ok;
  }

  /// Saves the instance; over the state that the handle names, if it names one.
  Answer get_state(void** handle) {
    return handle == nullptr ? log(Answer::error, "null pointer") : keep(handle, save());
  }
  Answer set_state(void* handle) {
    auto const* const state = saved_.find(handle);
    return state == nullptr ? unknown_state() : restore(*state);
  }
  /// Null, or a handle that names null: there is nothing to free.
  Answer free_state(void** handle) {
    if (handle == nullptr || *handle == nullptr) return Answer::ok;
    if (saved_.find(*handle) == nullptr) return unknown_state();
    saved_.free(std::exchange(*handle, nullptr));
    return Answer::ok;
  }
  Answer state_size(void* handle, std::size_t* size) {
    auto const* const state = saved_.find(handle);
    if (state == nullptr || size == nullptr) return unknown_state();
    *size = state->size();
    return Answer::ok;
  }
  Answer write_state(void* handle, void* bytes, std::size_t size) {
    auto const* const state = saved_.find(handle);
    if (state == nullptr || bytes == nullptr) return unknown_state();
    if (size < state->size()) return log(Answer::error, "the state has %zu bytes", state->size());
    std::ranges::copy(*state, static_cast<std::byte*>(bytes));
    return Answer::ok;
  }
  Answer read_state(void const* bytes, std::size_t size, void** handle) {
    if (bytes == nullptr || handle == nullptr) return log(Answer::error, "null pointer");
    auto const* const begin = static_cast<std::byte const*>(bytes);
    if (!is_state({begin, size})) return log(Answer::error, "these bytes are no saved state");
    return keep(handle, {begin, begin + size});
  }

  Answer check_categories(std::size_t count, char const* const* categories) const {
    for (std::size_t i = 0; i < count; ++i)
      if (categories == nullptr || categories[i] == nullptr ||
          (std::strcmp(categories[i], "logStatusDiscard") != 0 && std::strcmp(categories[i], "logStatusError") != 0))
        return log(Answer::error, "categories are logStatusDiscard, logStatusError");
    return Answer::ok;
  }

 private:
  using Bytes = std::vector<std::byte>;
  Answer unknown_state() const { return log(Answer::error, "that is no state of this instance"); }
  Answer keep(void** handle, Bytes bytes) {
    if (Bytes* const old = saved_.find(*handle))
      *old = std::move(bytes);
    else
      *handle = saved_.keep(std::make_unique<Bytes>(std::move(bytes)));
    return Answer::ok;
  }

  struct Head {
    std::uint64_t mark{0x3174617473756d66};  ///< "fmustat1"
    std::uint64_t checksum{}, phase{}, chosen{}, states{}, exchange{};
    double start{}, stop{}, offset{}, time{};
    StepEnd step{};
  };
  static constexpr double unset = std::numeric_limits<double>::quiet_NaN();
  static constexpr double endless = std::numeric_limits<double>::infinity();

  /// What any state has, whoever wrote its bytes.
  bool sound(Head const& head) const {
    std::uint64_t const own = exchange_ ? exchanging : stepping | step_failed;
    bool const known =
        std::has_single_bit(head.phase) && (head.phase & (instantiated | initializing | terminated | own)) != 0;
    unsigned char over;
    std::memcpy(&over, &head.step.run_over, 1);
    return known && over <= 1 && std::isfinite(head.start) && std::isfinite(head.offset) && std::isfinite(head.time) &&
           std::isfinite(head.step.time) && head.stop > head.start;
  }
  /// Parameters that were chosen before the run of a plant that has not begun; false: some number is not allowed.
  bool take_chosen(AnyPlant& fresh, std::span<double const> chosen) const {
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (std::isnan(chosen[i])) continue;
      bool const parameter = variables()[i].causality == Causality::parameter;
      if (!variables()[i].allows(chosen[i]) || (parameter && !fresh.set_parameter(static_cast<int>(i), chosen[i])))
        return false;
    }
    return true;
  }

  /// The plant at its start, with what was chosen before; its own clock begins where its case does.
  Answer begin() {
    auto const apply_chosen = [&](bool parameters) {
      for (std::size_t i = 0; i < chosen_.size(); ++i)
        if (!std::isnan(chosen_[i]) && (variables()[i].causality == Causality::parameter) == parameters &&
            !apply(i, chosen_[i]))
          return log(Answer::error, "%s = %g was refused", variables()[i].name.c_str(), chosen_[i]);
      return Answer::ok;
    };
    if (apply_chosen(true) != Answer::ok) return Answer::error;
    Status const status = plant_->start(stop_ - start_);
    if (status != Status::ok) return tell(status, Answer::error);
    offset_ = start_ - plant_->time();
    return apply_chosen(false);
  }

  /// With other numbers; where there is no start with these, the one before still stands.
  Answer begin_again(std::vector<double> const& chosen_before) {
    std::unique_ptr<AnyPlant> before = std::exchange(plant_, plant_->anew());
    auto const put_back = [&] {
      plant_ = std::move(before);
      chosen_ = chosen_before;
    };
    try {
      Answer const answer = begin();
      if (answer != Answer::ok) put_back();
      return answer;
    } catch (...) {  // a model with these numbers is refused
      put_back();
      throw;
    }
  }

  bool apply(std::size_t i, double value) {
    bool const parameter = variables()[i].causality == Causality::parameter;
    int const index = static_cast<int>(i);
    return parameter ? plant_->set_parameter(index, value) : plant_->set_input(index, value);
  }

  std::span<Variable const> variables() const { return std::as_const(*plant_).variables(); }

  char const* where() const {
    switch (phase_) {
      case instantiated: return "before the initialization";
      case initializing: return "in the initialization";
      case stepping: return "between steps";
      case step_failed: return "after a step that ended the run";
      case event_mode: return "in event mode";
      case continuous_time: return "in continuous time";
      case terminated: return "after the end";
    }
    return "now";
  }

  bool restore_states(AnyPlant& plant, std::span<double const> states) const {
    if (!exchange_) return states.empty();
    return plant.continuous() != nullptr && plant.continuous()->restore(states);
  }

  bool begun() const { return (phase_ & (stepping | exchanging)) != 0; }

  /// One of locals(): there is such a plant.
  double local(std::size_t k) {
    auto& continuous = *plant_->continuous();
    std::size_t const states = continuous.count();
    if (k < states) return continuous.states()[k];
    bool const rate = k < 2 * states;
    std::vector<double> all(rate ? states : continuous.indicator_count());
    Status const status = rate ? continuous.rates(all.data()) : continuous.indicators(all.data());
    return status == Status::ok ? all[rate ? k - states : k - 2 * states] : unset;
  }

  std::unique_ptr<AnyPlant> plant_;
  std::vector<double> chosen_;  ///< per variable: set before the initialization
  Phase phase_{instantiated};
  double start_{0.0}, stop_{endless};  ///< [s]
  double offset_{0.0};                 ///< time of the tool minus that of the plant [s]
  double time_{0.0};                   ///< communication point [s]
  StepEnd step_{};
  bool exchange_;         ///< another program integrates
  Handles<Bytes> saved_;  ///< states that it has given out
};

}  // namespace rollerrig::fmu
