// fmu/exchange.hpp - model exchange: the tool integrates, the FMU gives rates, indicators and events. Of both versions.
//
//   calls of FMI 2.0, of FMI 3.0 -> [model exchange] -> Instance -> ContinuousPlant
//
// Source: FMI 2.0.4, section 3.2; FMI 3.0.2, section 3.
#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "rollerrig/fmu/instance.hpp"
#include "rollerrig/plant/continuous_plant.hpp"

namespace rollerrig::fmu {

/// What a tool is told in event mode.
struct Events {
  bool over{false};  ///< the model's validity has ended
  bool has_next{false};
  double next{};  ///< time event [s]
};

/// @param values  of `count` numbers, which must be as many as the FMU has
template <class I, class Read>
Answer exchange_numbers(I& i, char const* call, double* values, std::size_t count, std::size_t expected, Read read) {
  if (count != expected) return i.log(Answer::error, "%s: %zu numbers; there are %zu", call, count, expected);
  if (count > 0 && values == nullptr) return i.log(Answer::error, "%s: null pointer", call);
  Status const status = read(values);
  return status == Status::ok ? Answer::ok : i.tell(call, status, Answer::discard);
}

template <class I>
ContinuousPlant* continuous_of(I& i) {
  return i.plant().continuous();
}

template <class I>
Answer get_rates(I& i, char const* call, double* values, std::size_t count) {
  if (!i.may(exchanging, call)) return Answer::error;
  ContinuousPlant& plant = *continuous_of(i);
  return exchange_numbers(i, call, values, count, plant.count(), [&](double* out) { return plant.rates(out); });
}

/// Of the states, or of the event indicators.
template <class I>
Answer count_of(I& i, char const* call, std::size_t* count, bool indicators) {
  if (!i.may(initializing | exchanging, call)) return Answer::error;
  if (count == nullptr) return i.log(Answer::error, "%s: null pointer", call);
  ContinuousPlant const* plant = continuous_of(i);
  *count = plant == nullptr ? 0 : indicators ? plant->indicator_count() : plant->count();
  return Answer::ok;
}

template <class I>
Answer get_indicators(I& i, char const* call, double* values, std::size_t count) {
  if (!i.may(exchanging, call)) return Answer::error;
  ContinuousPlant& plant = *continuous_of(i);
  return exchange_numbers(i, call, values, count, plant.indicator_count(),
                          [&](double* out) { return plant.indicators(out); });
}

/// One number for each state: the states themselves, or their nominals.
template <class I>
Answer get_of_states(I& i, char const* call, double* values, std::size_t count,
                     std::span<double const> (ContinuousPlant::*of)() const) {
  if (!i.may(exchanging, call)) return Answer::error;
  ContinuousPlant& plant = *continuous_of(i);
  return exchange_numbers(i, call, values, count, plant.count(), [&](double* out) {
    std::ranges::copy((plant.*of)(), out);
    return Status::ok;
  });
}

template <class I>
Answer get_states(I& i, char const* call, double* values, std::size_t count) {
  return get_of_states(i, call, values, count, &ContinuousPlant::states);
}

template <class I>
Answer get_nominals(I& i, char const* call, double* values, std::size_t count) {
  return get_of_states(i, call, values, count, &ContinuousPlant::nominals);
}

template <class I>
Answer set_exchange_time(I& i, char const* call, double time) {
  if (!i.may(exchanging, call)) return Answer::error;
  if (!std::isfinite(time)) return i.log(Answer::error, "%s: time must be a finite number", call);
  i.set_time(time);
  continuous_of(i)->set_time(time - i.offset());
  return Answer::ok;
}

template <class I>
Answer set_exchange_states(I& i, char const* call, double const* states, std::size_t count) {
  if (!i.may(continuous_time, call)) return Answer::error;
  ContinuousPlant& plant = *continuous_of(i);
  if (states == nullptr || count != plant.count())
    return i.log(Answer::error, "%s: %zu states; there are %zu", call, states == nullptr ? 0 : count, plant.count());
  for (std::size_t k = 0; k < count; ++k)
    if (!std::isfinite(states[k])) return i.log(Answer::discard, "%s: state %zu is not finite", call, k + 1);
  plant.set_states({states, count});
  return Answer::ok;
}

/// Begins with an initialization, ends where the tool may go on to continuous time.
template <class I>
Answer exchange_events(I& i, char const* call, Events& events) {
  if (!i.may(event_mode, call)) return Answer::error;
  ContinuousPlant& plant = *continuous_of(i);
  Status const passed = plant.pass_event();
  double const next = plant.next_event();
  std::vector<double> rates(plant.count());
  Status const status = passed == Status::ok ? plant.rates(rates.data()) : passed;
  events = {status != Status::ok, std::isfinite(next), next + i.offset()};
  if (events.over) i.tell(call, status, Answer::discard);
  return Answer::ok;
}

/// A step of the tool that is kept; says whether the run is over.
template <class I>
Answer exchange_step_done(I& i, char const* call, bool& over) {
  if (!i.may(continuous_time, call)) return Answer::error;
  Status const status = continuous_of(i)->accept();
  over = status != Status::ok;
  if (over) i.tell(call, status, Answer::discard);
  return Answer::ok;
}

/// References as the description has them: unknown are rates, outputs and indicators, known are states and inputs.
template <class I, class Reference>
Answer exchange_directional(I& i, char const* call, std::span<Reference const> unknown,
                            std::span<Reference const> known, double const* seed, double* out) {
  if (!i.may(initializing | exchanging, call)) return Answer::error;
  ContinuousPlant* plant = continuous_of(i);
  if (plant == nullptr) return i.log(Answer::error, "%s: a controller alone has no derivatives", call);
  if ((!known.empty() && seed == nullptr) || (!unknown.empty() && out == nullptr))
    return i.log(Answer::error, "%s: null pointer", call);
  auto const variables = i.plant().variables();
  std::size_t const all = variables.size(), states = plant->count();
  std::vector<ContinuousPlant::Known> from;
  std::vector<ContinuousPlant::Unknown> to;
  auto const refuse = [&](Reference reference) {
    return i.log(Answer::error, "%s: no derivative by or of reference %u", call, static_cast<unsigned>(reference));
  };
  for (std::size_t k = 0; k < known.size(); ++k) {
    Reference const r = known[k];
    if (!std::isfinite(seed[k])) return i.log(Answer::error, "%s: a seed is not finite", call);
    if (r >= 1 && r <= all && variables[r - 1].causality == Causality::input)
      from.push_back({ContinuousPlant::Known::input, r - 1, seed[k]});
    else if (r > all && r <= all + states)
      from.push_back({ContinuousPlant::Known::state, r - all - 1, seed[k]});
    else
      return refuse(r);
  }
  for (Reference const r : unknown) {
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
  return status == Status::ok ? Answer::ok : i.tell(call, status, Answer::discard);
}

}  // namespace rollerrig::fmu
