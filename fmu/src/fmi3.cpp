// The names that a tool looks up in the library: FMI 3.0, Fmi3 over an assembled model.
#include "rollerrig/fmu/fmi3.hpp"

using rollerrig::fmu::Answer;
using rollerrig::fmu::Listener3;
using Fmu3 = rollerrig::fmu::Fmi3<rollerrig::fmu::AnyShell>;

extern "C" {

char const* fmi3GetVersion() { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean, size_t count, fmi3String const categories[]) {
  return Fmu3::set_debug_logging(c, count, categories);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String, fmi3String token, fmi3String resources, fmi3Boolean, fmi3Boolean,
                                         fmi3Boolean event_mode, fmi3Boolean, fmi3ValueReference const[], size_t,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback message,
                                         fmi3IntermediateUpdateCallback) {
  return Fmu3::instantiate(__func__, token, resources, event_mode, {environment, message});
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String, fmi3String token, fmi3String resources, fmi3Boolean, fmi3Boolean,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback message) {
  return Fmu3::instantiate(__func__, token, resources, false, {environment, message}, true);
}
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback message,
                                               fmi3ClockUpdateCallback, fmi3LockPreemptionCallback,
                                               fmi3UnlockPreemptionCallback) {
  return Fmu3::refuse(__func__, {environment, message});
}
void fmi3FreeInstance(fmi3Instance c) { Fmu3::free(c); }

// ------------------------------------------------------------------------------ phases
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean, fmi3Float64, fmi3Float64 start,
                                       fmi3Boolean has_stop, fmi3Float64 stop) {
  return Fmu3::enter_initialization(c, start, has_stop, stop);
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
  return Fmu3::with(c, __func__, [](auto& i) { return i.exit_initialization("fmi3ExitInitializationMode"); });
}
fmi3Status fmi3Terminate(fmi3Instance c) {
  return Fmu3::with(c, __func__, [](auto& i) { return i.terminate("fmi3Terminate"); });
}
fmi3Status fmi3Reset(fmi3Instance c) {
  return Fmu3::with(c, __func__, [](auto& i) { return i.reset(); });
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 at, fmi3Float64 length, fmi3Boolean, fmi3Boolean* event,
                      fmi3Boolean* terminate, fmi3Boolean* early, fmi3Float64* time) {
  return Fmu3::step(c, at, length, {event, terminate, early, time});
}

// ------------------------------------------------------------------------------ values
fmi3Status fmi3GetFloat64(fmi3Instance c, fmi3ValueReference const refs[], size_t n, fmi3Float64 values[], size_t m) {
  return Fmu3::exchange(c, __func__, n, m, [&](auto& i) { return i.get("fmi3GetFloat64", refs, n, values); });
}
fmi3Status fmi3SetFloat64(fmi3Instance c, fmi3ValueReference const refs[], size_t n, fmi3Float64 const values[],
                          size_t m) {
  return Fmu3::exchange(c, __func__, n, m, [&](auto& i) { return i.set("fmi3SetFloat64", refs, n, values); });
}

// ------------------------------------------------------------------------------ saved states
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState* state) {
  return Fmu3::with_states(c, __func__, [&](auto& s, auto& i) { return s.get(i, "fmi3GetFMUState", state); });
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
  return Fmu3::with_states(c, __func__, [&](auto& s, auto& i) { return s.set(i, "fmi3SetFMUState", state); });
}
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState* state) {
  return Fmu3::with_states(c, __func__, [&](auto& s, auto& i) { return s.free(i, "fmi3FreeFMUState", state); });
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t* size) {
  return Fmu3::with_states(c, __func__,
                           [&](auto& s, auto& i) { return s.size(i, "fmi3SerializedFMUStateSize", state, size); });
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
  return Fmu3::with_states(c, __func__,
                           [&](auto& s, auto& i) { return s.write(i, "fmi3SerializeFMUState", state, bytes, size); });
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, fmi3Byte const bytes[], size_t size, fmi3FMUState* state) {
  return Fmu3::with_states(c, __func__,
                           [&](auto& s, auto& i) { return s.read(i, "fmi3DeserializeFMUState", bytes, size, state); });
}

// ------------------------------------------------------------------------------ other types: no variable has one
fmi3Status fmi3GetFloat32(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Float32[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetInt8(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Int8[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetUInt8(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3UInt8[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetInt16(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Int16[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetUInt16(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3UInt16[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetInt32(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Int32[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetUInt32(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3UInt32[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetInt64(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Int64[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetUInt64(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3UInt64[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetBoolean(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Boolean[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetString(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3String[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetBinary(fmi3Instance c, fmi3ValueReference const[], size_t n, size_t[], fmi3Binary[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3GetClock(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Clock[]) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetFloat32(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Float32 const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetInt8(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Int8 const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetUInt8(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3UInt8 const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetInt16(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Int16 const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetUInt16(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3UInt16 const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetInt32(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Int32 const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetUInt32(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3UInt32 const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetInt64(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Int64 const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetUInt64(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3UInt64 const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetBoolean(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Boolean const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetString(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3String const[], size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetBinary(fmi3Instance c, fmi3ValueReference const[], size_t n, size_t const[], fmi3Binary const[],
                         size_t) {
  return Fmu3::lacks(c, __func__, n);
}
fmi3Status fmi3SetClock(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Clock const[]) {
  return Fmu3::lacks(c, __func__, n);
}

// ------------------------------------------------------------------------------ model exchange
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, fmi3ValueReference const unknown[], size_t n,
                                        fmi3ValueReference const known[], size_t m, fmi3Float64 const seed[],
                                        size_t seeds, fmi3Float64 out[], size_t outs) {
  return Fmu3::with(c, __func__, [&](auto& i) {
    constexpr char const* name = "fmi3GetDirectionalDerivative";
    if ((n > 0 && unknown == nullptr) || (m > 0 && known == nullptr) || seeds != m || outs != n)
      return i.log(Answer::error, "%s: null pointer, or not as many numbers as scalars", name);
    return exchange_directional(i, name, std::span(unknown, n), std::span(known, m), seed, out);
  });
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) {
  return Fmu3::with(c, __func__, [](auto& i) {
    return i.go("fmi3EnterEventMode", rollerrig::fmu::continuous_time, rollerrig::fmu::event_mode);
  });
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean* again, fmi3Boolean* over, fmi3Boolean* nominals,
                                    fmi3Boolean* values, fmi3Boolean* has_next, fmi3Float64* next) {
  return Fmu3::with(c, __func__, [&](auto& i) {
    constexpr char const* name = "fmi3UpdateDiscreteStates";
    if (again == nullptr || over == nullptr || nominals == nullptr || values == nullptr || has_next == nullptr ||
        next == nullptr)
      return i.log(Answer::error, "%s: null pointer", name);
    rollerrig::fmu::Events events;
    Answer const answer = exchange_events(i, name, events);
    *again = *nominals = *values = false;
    *over = events.over;
    *has_next = events.has_next;
    *next = events.has_next ? events.next : 0.0;
    return answer;
  });
}
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
  return Fmu3::with(c, __func__, [](auto& i) {
    return i.go("fmi3EnterContinuousTimeMode", rollerrig::fmu::event_mode, rollerrig::fmu::continuous_time);
  });
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean, fmi3Boolean* event, fmi3Boolean* terminate) {
  return Fmu3::with(c, __func__, [&](auto& i) {
    constexpr char const* name = "fmi3CompletedIntegratorStep";
    if (event == nullptr || terminate == nullptr) return i.log(Answer::error, "%s: null pointer", name);
    bool over = false;
    Answer const answer = exchange_step_done(i, name, over);
    *event = false;
    *terminate = over;
    return answer;
  });
}
fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
  return Fmu3::with(c, __func__, [&](auto& i) { return set_exchange_time(i, "fmi3SetTime", time); });
}
fmi3Status fmi3SetContinuousStates(fmi3Instance c, fmi3Float64 const states[], size_t n) {
  return Fmu3::with(c, __func__, [&](auto& i) { return set_exchange_states(i, "fmi3SetContinuousStates", states, n); });
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 out[], size_t n) {
  return Fmu3::with(c, __func__, [&](auto& i) { return get_rates(i, "fmi3GetContinuousStateDerivatives", out, n); });
}
fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 out[], size_t n) {
  return Fmu3::with(c, __func__, [&](auto& i) { return get_indicators(i, "fmi3GetEventIndicators", out, n); });
}
fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 out[], size_t n) {
  return Fmu3::with(c, __func__, [&](auto& i) { return get_states(i, "fmi3GetContinuousStates", out, n); });
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 out[], size_t n) {
  return Fmu3::with(c, __func__, [&](auto& i) { return get_nominals(i, "fmi3GetNominalsOfContinuousStates", out, n); });
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t* count) {
  return Fmu3::with(c, __func__, [&](auto& i) { return count_of(i, "fmi3GetNumberOfEventIndicators", count, true); });
}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t* count) {
  return Fmu3::with(c, __func__, [&](auto& i) { return count_of(i, "fmi3GetNumberOfContinuousStates", count, false); });
}

// ------------------------------------------------------------------------------ not offered
fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference, size_t*) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference, size_t[], fmi3ValueReference[], size_t[],
                                       fmi3DependencyKind[], size_t) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, fmi3ValueReference const[], size_t, fmi3ValueReference const[],
                                    size_t, fmi3Float64 const[], size_t, fmi3Float64[], size_t) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return Fmu3::lacks(c, __func__); }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return Fmu3::lacks(c, __func__); }
fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, fmi3ValueReference const[], size_t, fmi3Float64[],
                                  fmi3IntervalQualifier[]) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3GetIntervalFraction(fmi3Instance c, fmi3ValueReference const[], size_t, fmi3UInt64[], fmi3UInt64[],
                                   fmi3IntervalQualifier[]) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3GetShiftDecimal(fmi3Instance c, fmi3ValueReference const[], size_t, fmi3Float64[]) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3GetShiftFraction(fmi3Instance c, fmi3ValueReference const[], size_t, fmi3UInt64[], fmi3UInt64[]) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, fmi3ValueReference const[], size_t, fmi3Float64 const[]) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3SetIntervalFraction(fmi3Instance c, fmi3ValueReference const[], size_t, fmi3UInt64 const[],
                                   fmi3UInt64 const[]) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3SetShiftDecimal(fmi3Instance c, fmi3ValueReference const[], size_t, fmi3Float64 const[]) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3SetShiftFraction(fmi3Instance c, fmi3ValueReference const[], size_t, fmi3UInt64 const[],
                                fmi3UInt64 const[]) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) { return Fmu3::lacks(c, __func__); }
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return Fmu3::lacks(c, __func__); }
fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, fmi3ValueReference const[], size_t, fmi3Int32 const[],
                                    fmi3Float64[], size_t) {
  return Fmu3::lacks(c, __func__);
}
fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference, fmi3Float64) {
  return Fmu3::lacks(c, __func__);
}
}
