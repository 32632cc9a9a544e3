// fmu/exchange.hpp - model exchange: the tool integrates, the FMU gives rates, indicators and events. Of both versions.
//
//   calls of FMI 2.0, of FMI 3.0 -> [model exchange] -> Instance -> ContinuousPlant
//
// Source: FMI 2.0.4, section 3.2; FMI 3.0.2, section 3.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "rollerrig/fmu/instance.hpp"

namespace rollerrig::fmu {

/// What a tool is told in event mode.
struct Events {
  bool over{false};  ///< the model's validity has ended
  bool has_next{false};
  double next{};  ///< time event [s]
};

/// Numbers of the plant.
///
/// @param values    of `count` numbers
/// @param expected  how many the plant has
/// @param read      fills them
template <class Read>
Answer get_numbers(Instance& i, double* values, std::size_t count, std::size_t (ContinuousPlant::*expected)() const,
                   Read read) {
  if (!i.may(exchanging)) return Answer::error;
  ContinuousPlant& plant = *i.plant().continuous();
  std::size_t const there = (plant.*expected)();
  if (count != there) return i.log(Answer::error, "%zu numbers; there are %zu", count, there);
  if (count > 0 && values == nullptr) return i.log(Answer::error, "null pointer");
  Status const status = std::invoke(read, plant, values);
  return status == Status::ok ? Answer::ok : i.tell(status, Answer::discard);
}

inline Answer get_rates(Instance& i, double* values, std::size_t count) {
  return get_numbers(i, values, count, &ContinuousPlant::count, &ContinuousPlant::rates);
}

inline Answer get_indicators(Instance& i, double* values, std::size_t count) {
  return get_numbers(i, values, count, &ContinuousPlant::indicator_count, &ContinuousPlant::indicators);
}

/// One number for each state: the states themselves, or their nominals.
inline Answer get_of_states(Instance& i, double* values, std::size_t count,
                            std::span<double const> (ContinuousPlant::*of)() const) {
  return get_numbers(i, values, count, &ContinuousPlant::count, [of](ContinuousPlant const& plant, double* out) {
    std::ranges::copy((plant.*of)(), out);
    return Status::ok;
  });
}

/// Of the states, or of the event indicators.
inline Answer get_count(Instance& i, std::size_t* count, std::size_t (ContinuousPlant::*of)() const) {
  if (!i.may(initializing | exchanging)) return Answer::error;
  if (count == nullptr) return i.log(Answer::error, "null pointer");
  ContinuousPlant const* const plant = i.plant().continuous();
  *count = plant == nullptr ? 0 : (plant->*of)();
  return Answer::ok;
}

inline Answer set_exchange_time(Instance& i, double time) {
  if (!i.may(exchanging)) return Answer::error;
  if (!std::isfinite(time)) return i.log(Answer::error, "time must be a finite number");
  i.set_time(time);
  i.plant().continuous()->set_time(time - i.offset());
  return Answer::ok;
}

inline Answer set_exchange_states(Instance& i, double const* states, std::size_t count) {
  if (!i.may(continuous_time)) return Answer::error;
  ContinuousPlant& plant = *i.plant().continuous();
  if (states == nullptr || count != plant.count())
    return i.log(Answer::error, "%zu states; there are %zu", states == nullptr ? 0 : count, plant.count());
  for (std::size_t k = 0; k < count; ++k)
    if (!std::isfinite(states[k])) return i.log(Answer::discard, "state %zu is not finite", k + 1);
  plant.set_states({states, count});
  return Answer::ok;
}

/// Begins with an initialization, ends where the tool may go on to continuous time.
inline Answer exchange_events(Instance& i, Events& events) {
  if (!i.may(event_mode)) return Answer::error;
  ContinuousPlant& plant = *i.plant().continuous();
  Status const passed = plant.pass_event();
  double const next = plant.next_event();
  std::vector<double> rates(plant.count());
  Status const status = passed == Status::ok ? plant.rates(rates.data()) : passed;
  events = {status != Status::ok, std::isfinite(next), next + i.offset()};
  if (events.over) i.tell(status, Answer::discard);
  return Answer::ok;
}

/// A step of the tool that is kept; says whether the run is over.
template <class Flag>
Answer exchange_step_done(Instance& i, Flag* event, Flag* over) {
  if (event == nullptr || over == nullptr) return i.log(Answer::error, "null pointer");
  *event = *over = false;
  if (!i.may(continuous_time)) return Answer::error;
  Status const status = i.plant().continuous()->accept();
  *over = status != Status::ok;
  if (*over) i.tell(status, Answer::discard);
  return Answer::ok;
}

/// References as the description has them: unknown are rates, outputs and indicators, known are states and inputs.
inline Answer exchange_directional(Instance& i, Reference const* unknown, std::size_t unknowns, Reference const* known,
                                   std::size_t knowns, double const* seed, double* out) {
  if (!i.may(initializing | exchanging)) return Answer::error;
  ContinuousPlant* plant = i.plant().continuous();
  if (plant == nullptr) return i.log(Answer::error, "a controller alone has no derivatives");
  if ((knowns > 0 && (known == nullptr || seed == nullptr)) || (unknowns > 0 && (unknown == nullptr || out == nullptr)))
    return i.log(Answer::error, "null pointer");
  auto const variables = i.plant().variables();
  std::size_t const all = variables.size(), states = plant->count();
  std::vector<ContinuousPlant::Known> from;
  std::vector<ContinuousPlant::Unknown> to;
  auto const refuse = [&](Reference reference) {
    return i.log(Answer::error, "no derivative by or of reference %u", reference);
  };
  for (std::size_t k = 0; k < knowns; ++k) {
    Reference const r = known[k];
    if (!std::isfinite(seed[k])) return i.log(Answer::error, "a seed is not finite");
    if (r >= 1 && r <= all && variables[r - 1].causality == Causality::input)
      from.push_back({ContinuousPlant::Known::input, r - 1, seed[k]});
    else if (r > all && r <= all + states)
      from.push_back({ContinuousPlant::Known::state, r - all - 1, seed[k]});
    else
      return refuse(r);
  }
  for (Reference const r : std::span(unknown, unknowns)) {
    if (r >= 1 && r <= all && variables[r - 1].causality == Causality::output)
      to.push_back({ContinuousPlant::Unknown::output, r - 1});
    else if (r > all + states && r <= all + 2 * states)
      to.push_back({ContinuousPlant::Unknown::rate, r - all - states - 1});
    else if (r > all + 2 * states && r <= all + i.locals())
      to.push_back({ContinuousPlant::Unknown::indicator, r - all - 2 * states - 1});
    else
      return refuse(r);
  }
  Status const status = plant->directional(from, to, out);
  return status == Status::ok ? Answer::ok : i.tell(status, Answer::discard);
}

}  // namespace rollerrig::fmu
