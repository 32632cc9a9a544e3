// The names that a tool looks up in the library: FMI 2.0, Fmi2 over an assembled model.
#include "rollerrig/fmu/fmi2.hpp"

using rollerrig::fmu::Answer;
using Fmu2 = rollerrig::fmu::Fmi2<rollerrig::fmu::AnyShell>;

extern "C" {

/// For the export: instructions that this library needs.
FMI2_Export char const* rollerrig_needs() {
  static std::string const text = rollerrig::fmu::needed_instructions();
  return text.c_str();
}

char const* fmi2GetTypesPlatform() { return fmi2TypesPlatform; }
char const* fmi2GetVersion() { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean, size_t count, fmi2String const categories[]) {
  return Fmu2::set_debug_logging(c, count, categories);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                              fmi2CallbackFunctions const* functions, fmi2Boolean, fmi2Boolean) {
  return Fmu2::instantiate(name, type, guid, location, functions);
}
void fmi2FreeInstance(fmi2Component c) { Fmu2::free(c); }

// ------------------------------------------------------------------------------ phases
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean, fmi2Real, fmi2Real start, fmi2Boolean has_stop,
                               fmi2Real stop) {
  return Fmu2::with(c, __func__, [&](auto& i) { return i.setup("fmi2SetupExperiment", start, has_stop != 0, stop); });
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return Fmu2::with(c, __func__, [](auto& i) { return i.enter_initialization("fmi2EnterInitializationMode"); });
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return Fmu2::with(c, __func__, [](auto& i) { return i.exit_initialization("fmi2ExitInitializationMode"); });
}
fmi2Status fmi2Terminate(fmi2Component c) {
  return Fmu2::with(c, __func__, [](auto& i) { return i.terminate("fmi2Terminate"); });
}
fmi2Status fmi2Reset(fmi2Component c) {
  return Fmu2::with(c, __func__, [](auto& i) { return i.reset(); });
}

// ------------------------------------------------------------------------------ values
fmi2Status fmi2GetReal(fmi2Component c, fmi2ValueReference const refs[], size_t n, fmi2Real values[]) {
  return Fmu2::with(c, __func__, [&](auto& i) { return i.get("fmi2GetReal", refs, n, values); });
}
fmi2Status fmi2SetReal(fmi2Component c, fmi2ValueReference const refs[], size_t n, fmi2Real const values[]) {
  return Fmu2::with(c, __func__, [&](auto& i) { return i.set("fmi2SetReal", refs, n, values); });
}
fmi2Status fmi2GetInteger(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2Integer[]) {
  return Fmu2::lacks(c, __func__, n);
}
fmi2Status fmi2GetBoolean(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2Boolean[]) {
  return Fmu2::lacks(c, __func__, n);
}
fmi2Status fmi2GetString(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2String[]) {
  return Fmu2::lacks(c, __func__, n);
}
fmi2Status fmi2SetInteger(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2Integer const[]) {
  return Fmu2::lacks(c, __func__, n);
}
fmi2Status fmi2SetBoolean(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2Boolean const[]) {
  return Fmu2::lacks(c, __func__, n);
}
fmi2Status fmi2SetString(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2String const[]) {
  return Fmu2::lacks(c, __func__, n);
}

// ------------------------------------------------------------------------------ saved states
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return Fmu2::with_states(c, __func__, [&](auto& s, auto& i) { return s.get(i, "fmi2GetFMUstate", state); });
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  return Fmu2::with_states(c, __func__, [&](auto& s, auto& i) { return s.set(i, "fmi2SetFMUstate", state); });
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return Fmu2::with_states(c, __func__, [&](auto& s, auto& i) { return s.free(i, "fmi2FreeFMUstate", state); });
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
  return Fmu2::with_states(c, __func__,
                           [&](auto& s, auto& i) { return s.size(i, "fmi2SerializedFMUstateSize", state, size); });
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
  return Fmu2::with_states(c, __func__,
                           [&](auto& s, auto& i) { return s.write(i, "fmi2SerializeFMUstate", state, bytes, size); });
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, fmi2Byte const bytes[], size_t size, fmi2FMUstate* state) {
  return Fmu2::with_states(c, __func__,
                           [&](auto& s, auto& i) { return s.read(i, "fmi2DeSerializeFMUstate", bytes, size, state); });
}

// ------------------------------------------------------------------------------ co-simulation
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real at, fmi2Real length, fmi2Boolean) {
  return Fmu2::with(c, __func__, [&](auto& i) { return i.step("fmi2DoStep", at, length); });
}
fmi2Status fmi2CancelStep(fmi2Component c) { return Fmu2::lacks(c, __func__); }
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2Integer const[],
                                       fmi2Real const[]) {
  return Fmu2::lacks(c, __func__, n);
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, fmi2ValueReference const[], size_t n, fmi2Integer const[],
                                        fmi2Real[]) {
  return Fmu2::lacks(c, __func__, n);
}
fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind kind, fmi2Status* value) {
  return Fmu2::get_status(c, __func__, kind, value);
}
fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real* value) {
  return Fmu2::get_real_status(c, __func__, kind, value);
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind, fmi2Integer*) { return Fmu2::lacks(c, __func__); }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean* value) {
  return Fmu2::get_boolean_status(c, __func__, kind, value);
}
fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind, fmi2String*) { return Fmu2::lacks(c, __func__); }

// ------------------------------------------------------------------------------ model exchange
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, fmi2ValueReference const unknown[], size_t n,
                                        fmi2ValueReference const known[], size_t m, fmi2Real const seed[],
                                        fmi2Real out[]) {
  return Fmu2::with(c, __func__, [&](auto& i) {
    constexpr char const* name = "fmi2GetDirectionalDerivative";
    if ((n > 0 && unknown == nullptr) || (m > 0 && known == nullptr))
      return i.log(Answer::error, "%s: null pointer", name);
    return exchange_directional(i, name, std::span(unknown, n), std::span(known, m), seed, out);
  });
}
fmi2Status fmi2EnterEventMode(fmi2Component c) {
  return Fmu2::with(c, __func__, [](auto& i) {
    return i.go("fmi2EnterEventMode", rollerrig::fmu::continuous_time, rollerrig::fmu::event_mode);
  });
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
  return Fmu2::with(c, __func__, [&](auto& i) {
    constexpr char const* name = "fmi2NewDiscreteStates";
    if (info == nullptr) return i.log(Answer::error, "%s: null pointer", name);
    rollerrig::fmu::Events events;
    Answer const answer = exchange_events(i, name, events);
    *info = {fmi2False, events.over, fmi2False, fmi2False, events.has_next, events.has_next ? events.next : 0.0};
    return answer;
  });
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
  return Fmu2::with(c, __func__, [](auto& i) {
    return i.go("fmi2EnterContinuousTimeMode", rollerrig::fmu::event_mode, rollerrig::fmu::continuous_time);
  });
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean, fmi2Boolean* event, fmi2Boolean* terminate) {
  return Fmu2::with(c, __func__, [&](auto& i) {
    constexpr char const* name = "fmi2CompletedIntegratorStep";
    if (event == nullptr || terminate == nullptr) return i.log(Answer::error, "%s: null pointer", name);
    bool over = false;
    Answer const answer = exchange_step_done(i, name, over);
    *event = fmi2False;
    *terminate = over;
    return answer;
  });
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
  return Fmu2::with(c, __func__, [&](auto& i) { return set_exchange_time(i, "fmi2SetTime", time); });
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, fmi2Real const states[], size_t n) {
  return Fmu2::with(c, __func__, [&](auto& i) { return set_exchange_states(i, "fmi2SetContinuousStates", states, n); });
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real out[], size_t n) {
  return Fmu2::with(c, __func__, [&](auto& i) { return get_rates(i, "fmi2GetDerivatives", out, n); });
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real out[], size_t n) {
  return Fmu2::with(c, __func__, [&](auto& i) { return get_indicators(i, "fmi2GetEventIndicators", out, n); });
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real out[], size_t n) {
  return Fmu2::with(c, __func__, [&](auto& i) { return get_states(i, "fmi2GetContinuousStates", out, n); });
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real out[], size_t n) {
  return Fmu2::with(c, __func__, [&](auto& i) { return get_nominals(i, "fmi2GetNominalsOfContinuousStates", out, n); });
}
}
