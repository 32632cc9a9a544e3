// fmu/instance.hpp - one FMU that runs: which call is allowed when, values by reference, steps. Of both versions of the standard.
//
//   calls of FMI 2.0, of FMI 3.0 -> [instance] -> Plant
//
// Reference 0 is the time; reference i + 1 the i-th variable of the plant. A call that is refused changes nothing.
// Source: FMI 2.0.4, sections 2.1 and 4.2; FMI 3.0.2, sections 2.3 and 4.2.
#pragma once
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rollerrig/fmu/log.hpp"
#include "rollerrig/plant/byte_stream.hpp"
#include "rollerrig/plant/variable.hpp"
#include "rollerrig/status.hpp"

namespace rollerrig::fmu {

/// What an FMU asks of a plant; rollerrig::Plant says what each means.
template <class P>
concept PlantLike = requires(P plant, P const constant, int index, double number) {
  { constant.variables() } -> std::convertible_to<std::span<Variable const>>;
  { plant.start(number) } -> std::same_as<Status>;
  { plant.advance(number) } -> std::same_as<Status>;
  { plant.set_input(index, number) } -> std::same_as<bool>;
  { plant.set_parameter(index, number) } -> std::same_as<bool>;
  { plant.save() } -> std::same_as<std::vector<std::byte>>;
  { plant.restore(std::span<std::byte const>{}) } -> std::same_as<bool>;
  { plant.get(index) } -> std::same_as<double>;
  { constant.time() } -> std::same_as<double>;
  { constant.failed_wheel() } -> std::convertible_to<std::string_view>;
  { anew(constant) } -> std::same_as<std::unique_ptr<P>>;  // of the same model, nothing kept of a run
};

/// Of what another program integrates; what does not offer it has none.
template <class P>
concept Exchangeable = requires(P plant) { plant.continuous(); };

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

template <PlantLike P>
class Instance {
 public:
  Instance(std::unique_ptr<P> plant, Log tell_tool, bool exchange = false)
      : log{tell_tool}, plant_{std::move(plant)}, chosen_(plant_->variables().size(), unset), exchange_{exchange} {}

  Log log;

  Phase phase() const { return phase_; }
  double time() const { return time_; }
  StepEnd const& last_step() const { return step_; }
  P& plant() { return *plant_; }

  /// Whether a call may come now; if not, the log says so.
  bool may(unsigned phases, char const* call) const {
    if ((phase_ & phases) != 0) return true;
    log(Answer::error, "%s: not allowed %s", call, where());
    return false;
  }

  Answer setup(char const* call, double start, bool has_stop, double stop) {
    if (!may(instantiated, call)) return Answer::error;
    if (!std::isfinite(start)) return log(Answer::error, "%s: startTime must be a finite number", call);
    if (has_stop && !(std::isfinite(stop) && stop > start))
      return log(Answer::error, "%s: stopTime must be later than startTime", call);
    start_ = time_ = start;
    stop_ = has_stop ? stop : endless;
    return Answer::ok;
  }

  Answer enter_initialization(char const* call) {
    if (!may(instantiated, call)) return Answer::error;
    if (Answer const answer = begin(call); answer != Answer::ok) return answer;
    step_ = {false, start_};
    phase_ = initializing;
    return Answer::ok;
  }

  Answer exit_initialization(char const* call) {
    if (!may(initializing, call)) return Answer::error;
    phase_ = exchange_ ? event_mode : stepping;
    return Answer::ok;
  }

  /// Between event mode and continuous time.
  Answer go(char const* call, Phase from, Phase to) {
    if (!may(from, call)) return Answer::error;
    phase_ = to;
    return Answer::ok;
  }

  Answer terminate(char const* call) {
    if (!may(stepping | step_failed | exchanging, call)) return Answer::error;
    phase_ = terminated;
    return Answer::ok;
  }

  Answer reset() {
    plant_ = anew(std::as_const(*plant_));
    chosen_.assign(chosen_.size(), unset);
    phase_ = instantiated;
    start_ = time_ = 0.0;
    stop_ = endless;
    return Answer::ok;
  }

  /// @param count   of references, each of a scalar
  /// @param values  as many
  template <class Reference>
  Answer set(char const* call, Reference const* references, std::size_t count, double const* values) {
    if (!may(instantiated | initializing | stepping | exchanging, call)) return Answer::error;
    if (count > 0 && (references == nullptr || values == nullptr)) return log(Answer::error, "%s: null pointer", call);
    auto const all = variables();
    for (std::size_t k = 0; k < count; ++k) {
      if (references[k] == 0 || references[k] > all.size())
        return log(Answer::error, "%s: no variable that can be set has the reference %u", call,
                   static_cast<unsigned>(references[k]));
      Variable const& variable = all[references[k] - 1];
      if (variable.causality == Causality::output)
        return log(Answer::error, "%s: %s is an output", call, variable.name.c_str());
      if (variable.causality == Causality::parameter && variable.variability == Variability::fixed && begun())
        return log(Answer::error, "%s: %s is fixed after the initialization", call, variable.name.c_str());
      if (!variable.allows(values[k]))
        return log(Answer::error, "%s: %s = %g is not allowed: a %snumber from %g to %g", call, variable.name.c_str(),
                   values[k], variable.whole ? "whole " : "", variable.least, variable.most);
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
        return log(Answer::error, "%s: %s = %g was refused", call, variable.name.c_str(), values[k]);
    }
    if (!again) return Answer::ok;
    return begin_again(call, chosen);
  }

  template <class Reference>
  Answer get(char const* call, Reference const* references, std::size_t count, double* values) {
    if (!may(initializing | running, call)) return Answer::error;
    if (count > 0 && (references == nullptr || values == nullptr)) return log(Answer::error, "%s: null pointer", call);
    std::size_t const last = variables().size() + locals();
    for (std::size_t k = 0; k < count; ++k)
      if (references[k] > last)
        return log(Answer::error, "%s: no variable has the reference %u", call, static_cast<unsigned>(references[k]));
    for (std::size_t k = 0; k < count; ++k)
      values[k] = references[k] == 0                   ? time_
                  : references[k] > variables().size() ? local(references[k] - variables().size() - 1)
                                                       : plant_->get(static_cast<int>(references[k]) - 1);
    return Answer::ok;
  }

  /// The plant's own steps do not depend on the communication step. With sampled blocks outputs are those of the last
  /// sampling step within it.
  Answer step(char const* call, double at, double length) {
    if (!may(stepping, call)) return Answer::error;
    double const round_off = 1e-9 * std::max(1.0, std::abs(time_));  // importers add up their steps
    if (!(std::abs(at - time_) <= round_off))
      return log(Answer::error, "%s: currentCommunicationPoint is %.17g, the FMU stands at %.17g s", call, at, time_);
    if (!(std::isfinite(length) && length > 0.0))
      return log(Answer::error, "%s: communicationStepSize must be positive, got %g", call, length);
    if (length > longest_step)  // nothing could interrupt it
      return log(Answer::error, "%s: communicationStepSize is %g s; allowed: up to %g", call, length, longest_step);
    double const target = at + length;
    if (!(target > at)) return log(Answer::error, "%s: at %g s a step of %g s is lost in round-off", call, at, length);
    if (!(target <= stop_ + round_off))
      return log(Answer::error, "%s: the step ends at %g s, after stopTime %g s", call, target, stop_);
    Status const status = plant_->advance(target - offset_);
    bool const ok = status == Status::ok;
    time_ = ok ? target : plant_->time() + offset_;
    step_ = {!ok, time_};
    if (ok) return Answer::ok;
    phase_ = step_failed;
    return tell(call, status, Answer::discard);
  }

  /// Time of the tool minus that of the plant [s].
  double offset() const { return offset_; }
  void set_time(double time) { time_ = time; }

  /// States, rates and event indicators of a plant that another program could integrate: behind the plant's variables.
  std::size_t locals() {
    if constexpr (Exchangeable<P>)
      if (auto* continuous = plant_->continuous()) return 2 * continuous->count() + continuous->indicator_count();
    return 0;
  }

  Answer tell(char const* call, Status status, Answer answer) const {
    std::string const wheel{plant_->failed_wheel()};
    double const time = exchange_ ? time_ : plant_->time() + offset_;
    return log(answer, "%s: at %.6g s%s%s: %s", call, time, wheel.empty() ? "" : ", ", wheel.c_str(),
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
      auto const states = saved_states();
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
  Answer restore(char const* call, std::span<std::byte const> bytes) {
    if (!is_state(bytes)) return log(Answer::error, "%s: these bytes are no saved state", call);
    Head head;
    std::memcpy(&head, bytes.data(), sizeof head);
    auto const rest = bytes.subspan(sizeof head);
    if (head.chosen != chosen_.size() || (head.exchange != 0) != exchange_)
      return log(Answer::error, "%s: the state of another FMU", call);
    auto fresh = anew(std::as_const(*plant_));
    std::vector<double> states(head.states), chosen(head.chosen);
    std::memcpy(chosen.data(), rest.data(), head.chosen * sizeof(double));
    if (!sound(head) || !take_chosen(*fresh, chosen))
      return log(Answer::error, "%s: no state that this FMU can be in", call);
    if (!states.empty())
      std::memcpy(states.data(), rest.data() + head.chosen * sizeof(double), head.states * sizeof(double));
    auto const run = rest.subspan((head.chosen + head.states) * sizeof(double));
    if (head.phase != instantiated && !(fresh->restore(run) && restore_states(*fresh, states)))
      return log(Answer::error, "%s: the state of another FMU", call);
    double const lag = head.time - head.offset - fresh->time();
    if (head.phase == stepping && !(lag > -longest_lag && lag < longest_lag))
      return log(Answer::error, "%s: no state that this FMU can be in", call);
    plant_ = std::move(fresh);
    chosen_ = std::move(chosen);
    phase_ = static_cast<Phase>(head.phase);
    start_ = head.start, stop_ = head.stop, offset_ = head.offset, time_ = head.time, step_ = head.step;
    return Answer::ok;
  }

 private:
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
  bool take_chosen(P& fresh, std::span<double const> chosen) const {
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (std::isnan(chosen[i])) continue;
      bool const parameter = variables()[i].causality == Causality::parameter;
      if (!variables()[i].allows(chosen[i]) || (parameter && !fresh.set_parameter(static_cast<int>(i), chosen[i])))
        return false;
    }
    return true;
  }

  /// The plant at its start, with what was chosen before; its own clock begins where its case does.
  Answer begin(char const* call) {
    auto const apply_chosen = [&](bool parameters) {
      for (std::size_t i = 0; i < chosen_.size(); ++i)
        if (!std::isnan(chosen_[i]) && (variables()[i].causality == Causality::parameter) == parameters &&
            !apply(i, chosen_[i]))
          return log(Answer::error, "%s: %s = %g was refused", call, variables()[i].name.c_str(), chosen_[i]);
      return Answer::ok;
    };
    if (apply_chosen(true) != Answer::ok) return Answer::error;
    Status const status = plant_->start(stop_ - start_);
    if (status != Status::ok) return tell(call, status, Answer::error);
    offset_ = start_ - plant_->time();
    return apply_chosen(false);
  }

  /// With other numbers; where there is no start with these, the one before still stands.
  Answer begin_again(char const* call, std::vector<double> const& chosen_before) {
    std::unique_ptr<P> before = std::exchange(plant_, anew(std::as_const(*plant_)));
    auto const put_back = [&] {
      plant_ = std::move(before);
      chosen_ = chosen_before;
    };
    try {
      Answer const answer = begin(call);
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

  bool begun() const { return (phase_ & (stepping | exchanging)) != 0; }

  double local(std::size_t k) {
    if constexpr (Exchangeable<P>) {
      auto& continuous = *plant_->continuous();
      std::size_t const states = continuous.count();
      if (k < states) return continuous.states()[k];
      std::vector<double> all(k < 2 * states ? states : continuous.indicator_count());
      bool const rate = k < 2 * states;
      Status const status = rate ? continuous.rates(all.data()) : continuous.indicators(all.data());
      return status == Status::ok ? all[rate ? k - states : k - 2 * states] : unset;
    }
    return unset;
  }

  std::vector<double> saved_states() {
    if constexpr (Exchangeable<P>)
      if (exchange_) return plant_->continuous()->save();
    return {};
  }
  bool restore_states(P& plant, std::span<double const> states) const {
    if constexpr (Exchangeable<P>)
      if (exchange_) return plant.continuous() != nullptr && plant.continuous()->restore(states);
    return states.empty();
  }

  std::unique_ptr<P> plant_;
  std::vector<double> chosen_;  ///< per variable: set before the initialization
  Phase phase_{instantiated};
  double start_{0.0}, stop_{endless};  ///< [s]
  double offset_{0.0};                 ///< time of the tool minus that of the plant [s]
  double time_{0.0};                   ///< communication point [s]
  StepEnd step_{};
  bool exchange_;  ///< another program integrates
};

}  // namespace rollerrig::fmu
