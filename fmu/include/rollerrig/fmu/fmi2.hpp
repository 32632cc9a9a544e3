// fmu/fmi2.hpp - the functions of FMI 2.0, over any plant.
//
//   calls of a tool -> [FMI 2.0] -> Instance -> Plant
//
// Each takes pointers as a tool gives them: what is null or out of order is answered with an error and a line in the log.
#pragma once
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>

#include "fmi2Functions.h"
#include "rollerrig/fmu/exchange.hpp"
#include "rollerrig/fmu/instance.hpp"
#include "rollerrig/fmu/live.hpp"
#include "rollerrig/fmu/shell.hpp"
#include "rollerrig/fmu/states.hpp"

namespace rollerrig::fmu {

inline fmi2Status fmi2_status(Answer answer) {
  constexpr fmi2Status statuses[] = {fmi2OK, fmi2Discard, fmi2Error};
  return statuses[static_cast<int>(answer)];
}

/// What a tool gives to be told by.
struct Listener2 {
  fmi2CallbackFunctions functions{};
  std::string name{};

  static void write(void* self, Answer answer, char const* text) {
    auto const& listener = *static_cast<Listener2 const*>(self);
    if (listener.functions.logger == nullptr) return;
    char const* category = answer == Answer::discard ? "logStatusDiscard" : "logStatusError";
    listener.functions.logger(listener.functions.componentEnvironment, listener.name.c_str(), fmi2_status(answer),
                              category, "%s", text);
  }
  Log log() { return {write, this}; }
};

template <class Shell>
struct Fmi2 {
  struct Component {
    Listener2 listener;
    Instance<typename Shell::Plant> instance;
    States states;
    Component(Listener2 heard, std::unique_ptr<typename Shell::Plant> plant, bool exchange)
        : listener{std::move(heard)}, instance{std::move(plant), listener.log(), exchange} {}
  };

  static fmi2Component instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                                   fmi2CallbackFunctions const* functions) {
    Listener2 listener;
    if (functions != nullptr) listener.functions = *functions;
    try {
      listener.name = name != nullptr ? name : "";
      auto const refuse = [&](char const* text) -> fmi2Component {
        listener.log()(Answer::error, "fmi2Instantiate: %s", text);
        return nullptr;
      };
      if (functions == nullptr || functions->logger == nullptr || guid == nullptr || location == nullptr)
        return refuse("null pointer");
      if (type != fmi2CoSimulation && type != fmi2ModelExchange) return refuse("there is no such type of FMU");
      std::filesystem::path const resources = path_of_uri(location);
      if (resources.empty()) return refuse("fmuResourceLocation is no URI of a file");
      auto plant = Shell::open(resources, guid);
      bool const exchange = type == fmi2ModelExchange;
      if (exchange && !plant->exchangeable()) return refuse("a controller alone is for co-simulation");
      return live().keep(std::make_unique<Component>(listener, std::move(plant), exchange));
    } catch (std::exception const& problem) {
      listener.log()(Answer::error, "fmi2Instantiate: %s", problem.what());
      return nullptr;
    }
  }

  static Live<Component>& live() {
    static Live<Component> all;
    return all;
  }
  static void free(fmi2Component c) { live().free(c); }

  /// Gives the instance to a call; nothing is thrown into the tool.
  template <class Call>
  static fmi2Status with(fmi2Component c, char const* name, Call call) {
    return with_component(c, name, [&](Component& component) { return call(component.instance); });
  }

  /// The same, with the states that the instance has given out.
  template <class Call>
  static fmi2Status with_states(fmi2Component c, char const* name, Call call) {
    return with_component(c, name, [&](Component& component) { return call(component.states, component.instance); });
  }

  template <class Call>
  static fmi2Status with_component(fmi2Component c, char const* name, Call call) {
    Component* const component = live().find(c);
    if (component == nullptr) return fmi2Error;
    auto& instance = component->instance;
    try {
      return fmi2_status(call(*component));
    } catch (std::exception const& problem) {
      return fmi2_status(instance.log(Answer::error, "%s: %s", name, problem.what()));
    }
  }

  /// A function that this FMU does not offer; with nothing asked for it is an empty task.
  static fmi2Status lacks(fmi2Component c, char const* name, std::size_t count = 1) {
    return with(c, name, [&](auto& instance) {
      return count == 0 ? Answer::ok : instance.log(Answer::error, "%s: this FMU has nothing of that kind", name);
    });
  }

  static fmi2Status get_status(fmi2Component c, char const* name, fmi2StatusKind kind, fmi2Status* value) {
    return status(c, name, kind == fmi2DoStepStatus, value,
                  [](auto const& instance) { return instance.phase() == step_failed ? fmi2Discard : fmi2OK; });
  }
  static fmi2Status get_real_status(fmi2Component c, char const* name, fmi2StatusKind kind, fmi2Real* value) {
    return status(c, name, kind == fmi2LastSuccessfulTime, value,
                  [](auto const& instance) { return instance.last_step().time; });
  }
  static fmi2Status get_boolean_status(fmi2Component c, char const* name, fmi2StatusKind kind, fmi2Boolean* value) {
    return status(c, name, kind == fmi2Terminated, value,
                  [](auto const& instance) { return instance.last_step().run_over ? fmi2True : fmi2False; });
  }

  static fmi2Status set_debug_logging(fmi2Component c, std::size_t count, fmi2String const* categories) {
    constexpr char const* name = "fmi2SetDebugLogging";
    return with(c, name, [&](auto& instance) {
      for (std::size_t i = 0; i < count; ++i)
        if (categories == nullptr || categories[i] == nullptr ||
            (std::strcmp(categories[i], "logStatusDiscard") != 0 && std::strcmp(categories[i], "logStatusError") != 0))
          return instance.log(Answer::error, "%s: categories are logStatusDiscard, logStatusError", name);
      return Answer::ok;
    });
  }

 private:
  template <class Value, class Read>
  static fmi2Status status(fmi2Component c, char const* name, bool known, Value* value, Read read) {
    return with(c, name, [&](auto& instance) {
      if (!instance.may(running, name)) return Answer::error;
      if (value == nullptr) return instance.log(Answer::error, "%s: null pointer", name);
      if (!known) return instance.log(Answer::discard, "%s: nothing is known of that kind", name);
      *value = read(instance);
      return Answer::ok;
    });
  }
};

}  // namespace rollerrig::fmu
