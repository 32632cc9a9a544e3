// The names that a tool looks up in the library: FMI 2.0, over an assembled model.
#include <cstring>
#include <string>
#include <type_traits>

#include "fmi2Functions.h"
#include "rollerrig/fmu/calls.hpp"
#include "rollerrig/fmu/exchange.hpp"
#include "rollerrig/fmu/shell.hpp"

using namespace rollerrig::fmu;
using rollerrig::ContinuousPlant;
using rollerrig::need;

namespace {

template <class Value>
Answer status_of(Instance const& i, bool known, Value* value, Value now) {
  if (!i.may(running)) return Answer::error;
  if (value == nullptr) return i.log(Answer::error, "null pointer");
  if (!known) return i.log(Answer::discard, "nothing is known of that kind");
  *value = now;
  return Answer::ok;
}

}  // namespace

extern "C" {

/// For the export: instructions that this library needs.
FMI2_Export char const* rollerrig_needs() {
  static std::string const text = needed_instructions();
  return text.c_str();
}

char const* fmi2GetTypesPlatform() { return fmi2TypesPlatform; }
char const* fmi2GetVersion() { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean, size_t count, fmi2String const categories[]) {
  return call(c, __func__, &Instance::check_categories, count, categories);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                              fmi2CallbackFunctions const* functions, fmi2Boolean, fmi2Boolean) {
  Log log{{}, __func__};
  if (functions != nullptr && functions->logger != nullptr)
    log.write = [tool = *functions, own = std::string(name != nullptr ? name : "")](Answer answer, char const* category,
                                                                                    char const* text) {
      tool.logger(tool.componentEnvironment, own.c_str(), static_cast<fmi2Status>(answer), category, "%s", text);
    };
  std::underlying_type_t<fmi2Type> kind;  // a tool may hand over any number
  std::memcpy(&kind, &type, sizeof kind);
  return instantiate(log, kind == fmi2ModelExchange, [&] {
    need(log.write && guid != nullptr && location != nullptr, "null pointer");
    need(kind == fmi2CoSimulation || kind == fmi2ModelExchange, "there is no such type of FMU");
    auto const resources = path_of_uri(location);
    need(!resources.empty(), "fmuResourceLocation is no URI of a file");
    return open_plant(resources, guid);
  });
}
void fmi2FreeInstance(fmi2Component c) { live().free(c); }

// ------------------------------------------------------------------------------ phases
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean, fmi2Real, fmi2Real start, fmi2Boolean has_stop,
                               fmi2Real stop) {
  return call(c, __func__, &Instance::setup, start, has_stop != 0, stop);
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return call(c, __func__, &Instance::enter_initialization); }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return call(c, __func__, &Instance::exit_initialization); }
fmi2Status fmi2Terminate(fmi2Component c) { return call(c, __func__, &Instance::terminate); }
fmi2Status fmi2Reset(fmi2Component c) { return call(c, __func__, &Instance::reset); }

// ------------------------------------------------------------------------------ values
fmi2Status fmi2GetReal(fmi2Component c, fmi2ValueReference const refs[], size_t n, fmi2Real values[]) {
  return call(c, __func__, &Instance::get, refs, n, values);
}
fmi2Status fmi2SetReal(fmi2Component c, fmi2ValueReference const refs[], size_t n, fmi2Real const values[]) {
  return call(c, __func__, &Instance::set, refs, n, values);
}

// No variable has another type.
#define ROLLERRIG_NONE_OF(Type)                                                                         \
  fmi2Status fmi2Get##Type(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2##Type[]) {       \
    return lacks(c, __func__, n);                                                                       \
  }                                                                                                     \
  fmi2Status fmi2Set##Type(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2##Type const[]) { \
    return lacks(c, __func__, n);                                                                       \
  }
ROLLERRIG_NONE_OF(Integer)
ROLLERRIG_NONE_OF(Boolean)
ROLLERRIG_NONE_OF(String)
#undef ROLLERRIG_NONE_OF

// ------------------------------------------------------------------------------ saved states
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return call(c, __func__, &Instance::get_state, state);
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  return call(c, __func__, &Instance::set_state, state);
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return call(c, __func__, &Instance::free_state, state);
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
  return call(c, __func__, &Instance::state_size, state, size);
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
  return call(c, __func__, &Instance::write_state, state, bytes, size);
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, fmi2Byte const bytes[], size_t size, fmi2FMUstate* state) {
  return call(c, __func__, &Instance::read_state, bytes, size, state);
}

// ------------------------------------------------------------------------------ co-simulation
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real at, fmi2Real length, fmi2Boolean) {
  return call(c, __func__, &Instance::step, at, length);
}
fmi2Status fmi2CancelStep(fmi2Component c) { return lacks(c, __func__); }
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2Integer const[],
                                       fmi2Real const[]) {
  return lacks(c, __func__, n);
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2Integer const[],
                                        fmi2Real[]) {
  return lacks(c, __func__, n);
}
fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind kind, fmi2Status* value) {
  return call(c, __func__, [&](Instance const& i) {
    return status_of(i, kind == fmi2DoStepStatus, value, i.phase() == step_failed ? fmi2Discard : fmi2OK);
  });
}
fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real* value) {
  return call(c, __func__, [&](Instance const& i) {
    return status_of(i, kind == fmi2LastSuccessfulTime, value, i.last_step().time);
  });
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind, fmi2Integer*) { return lacks(c, __func__); }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean* value) {
  return call(c, __func__, [&](Instance const& i) {
    return status_of<fmi2Boolean>(i, kind == fmi2Terminated, value, i.last_step().run_over);
  });
}
fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind, fmi2String*) { return lacks(c, __func__); }

// ------------------------------------------------------------------------------ model exchange
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, fmi2ValueReference const unknown[], size_t n,
                                        fmi2ValueReference const known[], size_t m, fmi2Real const seed[],
                                        fmi2Real out[]) {
  return call(c, __func__, exchange_directional, unknown, n, known, m, seed, out);
}
fmi2Status fmi2EnterEventMode(fmi2Component c) { return call(c, __func__, &Instance::go, continuous_time, event_mode); }
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
  return call(c, __func__, [&](Instance& i) {
    if (info == nullptr) return i.log(Answer::error, "null pointer");
    Events events;
    Answer const answer = exchange_events(i, events);
    *info = {fmi2False, events.over, fmi2False, fmi2False, events.has_next, events.has_next ? events.next : 0.0};
    return answer;
  });
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
  return call(c, __func__, &Instance::go, event_mode, continuous_time);
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean, fmi2Boolean* event, fmi2Boolean* terminate) {
  return call(c, __func__, exchange_step_done<fmi2Boolean>, event, terminate);
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) { return call(c, __func__, set_exchange_time, time); }
fmi2Status fmi2SetContinuousStates(fmi2Component c, fmi2Real const states[], size_t n) {
  return call(c, __func__, set_exchange_states, states, n);
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real out[], size_t n) {
  return call(c, __func__, get_rates, out, n);
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real out[], size_t n) {
  return call(c, __func__, get_indicators, out, n);
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real out[], size_t n) {
  return call(c, __func__, get_of_states, out, n, &ContinuousPlant::states);
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real out[], size_t n) {
  return call(c, __func__, get_of_states, out, n, &ContinuousPlant::nominals);
}
}
