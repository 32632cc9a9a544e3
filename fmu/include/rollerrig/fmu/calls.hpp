// fmu/calls.hpp - from a call of C to the instance that it is for. Of both versions of the standard.
//
//   calls of a tool -> [calls] -> Instance -> plant
//
// Pointers are as a tool gives them: what is null or out of order is answered with an error and a line in the log.
#pragma once
#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>

#include "rollerrig/fmu/instance.hpp"

namespace rollerrig::fmu {

inline Handles<Instance>& live() {
  static Handles<Instance> all;
  return all;
}

/// A new instance over the plant that `open` makes; where it throws, null, and its sentence in the log.
template <class Open>
Instance* instantiate(Log const& log, bool exchange, Open const& open) {
  try {
    std::unique_ptr<AnyPlant> plant = open();
    if (exchange && !plant->exchangeable()) throw std::invalid_argument("a controller alone is for co-simulation");
    return live().keep(std::make_unique<Instance>(std::move(plant), log, exchange));
  } catch (std::exception const& problem) {
    log(Answer::error, "%s", problem.what());
    return nullptr;
  }
}

/// An answer as the status of either standard.
struct Reply {
  Answer answer;
  template <class FmiStatus>
  operator FmiStatus() const {  // NOLINT: what a function of the standard returns
    return static_cast<FmiStatus>(answer);
  }
};

/// function(instance of the handle, arguments); nothing is thrown into the tool.
///
/// @param name  of the standard's function, for the log
template <class Function, class... Arguments>
Reply call(void* handle, char const* name, Function const& function, Arguments... arguments) {
  Instance* const instance = live().find(handle);
  if (instance == nullptr) return {Answer::error};
  instance->log.call = name;
  try {
    return {std::invoke(function, *instance, arguments...)};
  } catch (std::exception const& problem) {
    return {instance->log(Answer::error, "%s", problem.what())};
  }
}

/// A function that this FMU does not offer; with nothing asked for it is an empty task.
inline Reply lacks(void* handle, char const* name, std::size_t count = 1) {
  return call(handle, name, [&](Instance const& i) {
    return count == 0 ? Answer::ok : i.log(Answer::error, "this FMU has nothing of that kind");
  });
}

}  // namespace rollerrig::fmu
