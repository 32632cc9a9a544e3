// fmu/fmi3.hpp - the functions of FMI 3.0, over any plant.
//
//   calls of a tool -> [FMI 3.0] -> Instance -> Plant
//
// Each takes pointers as a tool gives them: what is null or out of order is answered with an error and a line in the log.
#pragma once
#include <cstring>
#include <exception>
#include <memory>
#include <string>

#include "fmi3Functions.h"
#include "rollerrig/fmu/exchange.hpp"
#include "rollerrig/fmu/instance.hpp"
#include "rollerrig/fmu/live.hpp"
#include "rollerrig/fmu/shell.hpp"
#include "rollerrig/fmu/states.hpp"

namespace rollerrig::fmu {

inline fmi3Status fmi3_status(Answer answer) {
  constexpr fmi3Status statuses[] = {fmi3OK, fmi3Discard, fmi3Error};
  return statuses[static_cast<int>(answer)];
}

/// What a tool gives to be told by.
struct Listener3 {
  fmi3InstanceEnvironment environment{};
  fmi3LogMessageCallback message{};

  static void write(void* self, Answer answer, char const* text) {
    auto const& listener = *static_cast<Listener3 const*>(self);
    if (listener.message == nullptr) return;
    char const* category = answer == Answer::discard ? "logStatusDiscard" : "logStatusError";
    listener.message(listener.environment, fmi3_status(answer), category, text);
  }
  Log log() { return {write, this}; }
};

template <class Shell>
struct Fmi3 {
  struct Component {
    Listener3 listener;
    Instance<typename Shell::Plant> instance;
    States states;
    Component(Listener3 heard, std::unique_ptr<typename Shell::Plant> plant, bool exchange)
        : listener{heard}, instance{std::move(plant), listener.log(), exchange} {}
  };

  /// An interface type that this FMU does not have.
  static fmi3Instance refuse(char const* call, Listener3 listener) {
    listener.log()(Answer::error, "%s: this FMU is for co-simulation and model exchange", call);
    return nullptr;
  }

  static fmi3Instance instantiate(char const* call, fmi3String token, fmi3String resources, bool event_mode,
                                  Listener3 listener, bool exchange = false) {
    try {
      if (token == nullptr || resources == nullptr) {
        listener.log()(Answer::error, "%s: null pointer", call);
        return nullptr;
      }
      if (event_mode) {
        listener.log()(Answer::error, "%s: this FMU has no event mode", call);
        return nullptr;
      }
      auto plant = Shell::open(utf8_path(resources), token);
      if (exchange && !plant->exchangeable()) {
        listener.log()(Answer::error, "%s: a controller alone is for co-simulation", call);
        return nullptr;
      }
      return live().keep(std::make_unique<Component>(listener, std::move(plant), exchange));
    } catch (std::exception const& problem) {
      listener.log()(Answer::error, "%s: %s", call, problem.what());
      return nullptr;
    }
  }

  static Live<Component>& live() {
    static Live<Component> all;
    return all;
  }
  static void free(fmi3Instance c) { live().free(c); }

  /// Gives the instance to a call; nothing is thrown into the tool.
  template <class Call>
  static fmi3Status with(fmi3Instance c, char const* name, Call call) {
    return with_component(c, name, [&](Component& component) { return call(component.instance); });
  }

  /// The same, with the states that the instance has given out.
  template <class Call>
  static fmi3Status with_states(fmi3Instance c, char const* name, Call call) {
    return with_component(c, name, [&](Component& component) { return call(component.states, component.instance); });
  }

  template <class Call>
  static fmi3Status with_component(fmi3Instance c, char const* name, Call call) {
    Component* const component = live().find(c);
    if (component == nullptr) return fmi3Error;
    auto& instance = component->instance;
    try {
      return fmi3_status(call(*component));
    } catch (std::exception const& problem) {
      return fmi3_status(instance.log(Answer::error, "%s: %s", name, problem.what()));
    }
  }

  /// A function that this FMU does not offer; with nothing asked for it is an empty task.
  static fmi3Status lacks(fmi3Instance c, char const* name, std::size_t count = 1) {
    return with(c, name, [&](auto& instance) {
      return count == 0 ? Answer::ok : instance.log(Answer::error, "%s: this FMU has nothing of that kind", name);
    });
  }

  static fmi3Status enter_initialization(fmi3Instance c, double start, bool has_stop, double stop) {
    constexpr char const* name = "fmi3EnterInitializationMode";
    return with(c, name, [&](auto& instance) {
      Answer const ready = instance.setup(name, start, has_stop, stop);
      return ready == Answer::ok ? instance.enter_initialization(name) : ready;
    });
  }

  /// Every variable is a scalar: as many values as references.
  template <class Call>
  static fmi3Status exchange(fmi3Instance c, char const* name, std::size_t references, std::size_t values, Call call) {
    return with(c, name, [&](auto& instance) {
      if (references != values)
        return instance.log(Answer::error, "%s: %zu values for %zu scalars", name, values, references);
      return call(instance);
    });
  }

  struct StepFlags {
    fmi3Boolean *event, *terminate, *early;
    fmi3Float64* time;
  };

  /// A run that has come to its end asks for the end of the simulation; one that left the validity discards, too.
  static fmi3Status step(fmi3Instance c, double at, double length, StepFlags flags) {
    constexpr char const* name = "fmi3DoStep";
    return with(c, name, [&](auto& instance) {
      if (flags.event == nullptr || flags.terminate == nullptr || flags.early == nullptr || flags.time == nullptr)
        return instance.log(Answer::error, "%s: null pointer", name);
      Answer const answer = instance.step(name, at, length);
      *flags.event = fmi3False;
      *flags.terminate = answer == Answer::discard;
      *flags.early = answer == Answer::discard;
      *flags.time = instance.last_step().time;
      return answer;
    });
  }

  static fmi3Status set_debug_logging(fmi3Instance c, std::size_t count, fmi3String const* categories) {
    constexpr char const* name = "fmi3SetDebugLogging";
    return with(c, name, [&](auto& instance) {
      for (std::size_t i = 0; i < count; ++i)
        if (categories == nullptr || categories[i] == nullptr ||
            (std::strcmp(categories[i], "logStatusDiscard") != 0 && std::strcmp(categories[i], "logStatusError") != 0))
          return instance.log(Answer::error, "%s: categories are logStatusDiscard, logStatusError", name);
      return Answer::ok;
    });
  }
};

}  // namespace rollerrig::fmu
