// The names that a tool looks up in the library: FMI 3.0, over an assembled model.
#include "fmi3Functions.h"
#include "rollerrig/fmu/calls.hpp"
#include "rollerrig/fmu/exchange.hpp"
#include "rollerrig/fmu/shell.hpp"

using namespace rollerrig::fmu;
using rollerrig::ContinuousPlant;
using rollerrig::need;

namespace {

Log told(char const* name, fmi3InstanceEnvironment environment, fmi3LogMessageCallback message) {
  if (message == nullptr) return {{}, name};
  return {[=](Answer answer, char const* category, char const* text) {
            message(environment, static_cast<fmi3Status>(answer), category, text);
          },
          name};
}

/// Every variable is a scalar: as many values as references.
bool as_many(Instance const& i, size_t references, size_t values) {
  if (references != values) i.log(Answer::error, "%zu values for %zu scalars", values, references);
  return references == values;
}

}  // namespace

extern "C" {

char const* fmi3GetVersion() { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean, size_t count, fmi3String const categories[]) {
  return call(c, __func__, &Instance::check_categories, count, categories);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String, fmi3String token, fmi3String resources, fmi3Boolean, fmi3Boolean,
                                         fmi3Boolean event_mode, fmi3Boolean, fmi3ValueReference const[], size_t,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback message,
                                         fmi3IntermediateUpdateCallback) {
  return instantiate(told(__func__, environment, message), false, [&] {
    need(token != nullptr && resources != nullptr, "null pointer");
    need(!event_mode, "this FMU has no event mode");
    return open_plant(utf8_path(resources), token);
  });
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String, fmi3String token, fmi3String resources, fmi3Boolean, fmi3Boolean,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback message) {
  return instantiate(told(__func__, environment, message), true, [&] {
    need(token != nullptr && resources != nullptr, "null pointer");
    return open_plant(utf8_path(resources), token);
  });
}
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback message,
                                               fmi3ClockUpdateCallback, fmi3LockPreemptionCallback,
                                               fmi3UnlockPreemptionCallback) {
  told(__func__, environment, message)(Answer::error, "this FMU is for co-simulation and model exchange");
  return nullptr;
}
void fmi3FreeInstance(fmi3Instance c) { live().free(c); }

// ------------------------------------------------------------------------------ phases
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean, fmi3Float64, fmi3Float64 start,
                                       fmi3Boolean has_stop, fmi3Float64 stop) {
  return call(c, __func__, [&](Instance& i) {
    Answer const ready = i.setup(start, has_stop, stop);
    return ready == Answer::ok ? i.enter_initialization() : ready;
  });
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return call(c, __func__, &Instance::exit_initialization); }
fmi3Status fmi3Terminate(fmi3Instance c) { return call(c, __func__, &Instance::terminate); }
fmi3Status fmi3Reset(fmi3Instance c) { return call(c, __func__, &Instance::reset); }
/// A run that has come to its end asks for the end of the simulation; one that left the validity discards, too.
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 at, fmi3Float64 length, fmi3Boolean, fmi3Boolean* event,
                      fmi3Boolean* terminate, fmi3Boolean* early, fmi3Float64* time) {
  return call(c, __func__, [&](Instance& i) {
    if (event == nullptr || terminate == nullptr || early == nullptr || time == nullptr)
      return i.log(Answer::error, "null pointer");
    Answer const answer = i.step(at, length);
    *event = false;
    *terminate = *early = answer == Answer::discard;
    *time = i.last_step().time;
    return answer;
  });
}

// ------------------------------------------------------------------------------ values
fmi3Status fmi3GetFloat64(fmi3Instance c, fmi3ValueReference const refs[], size_t n, fmi3Float64 values[], size_t m) {
  return call(c, __func__, [&](Instance& i) { return as_many(i, n, m) ? i.get(refs, n, values) : Answer::error; });
}
fmi3Status fmi3SetFloat64(fmi3Instance c, fmi3ValueReference const refs[], size_t n, fmi3Float64 const values[],
                          size_t m) {
  return call(c, __func__, [&](Instance& i) { return as_many(i, n, m) ? i.set(refs, n, values) : Answer::error; });
}

// No variable has another type.
#define ROLLERRIG_NONE_OF(Type)                                                                                \
  fmi3Status fmi3Get##Type(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3##Type[], size_t) {       \
    return lacks(c, __func__, n);                                                                              \
  }                                                                                                            \
  fmi3Status fmi3Set##Type(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3##Type const[], size_t) { \
    return lacks(c, __func__, n);                                                                              \
  }
ROLLERRIG_NONE_OF(Float32)
ROLLERRIG_NONE_OF(Int8)
ROLLERRIG_NONE_OF(UInt8)
ROLLERRIG_NONE_OF(Int16)
ROLLERRIG_NONE_OF(UInt16)
ROLLERRIG_NONE_OF(Int32)
ROLLERRIG_NONE_OF(UInt32)
ROLLERRIG_NONE_OF(Int64)
ROLLERRIG_NONE_OF(UInt64)
ROLLERRIG_NONE_OF(Boolean)
ROLLERRIG_NONE_OF(String)
#undef ROLLERRIG_NONE_OF
fmi3Status fmi3GetBinary(fmi3Instance c, fmi3ValueReference const[], size_t n, size_t[], fmi3Binary[], size_t) {
  return lacks(c, __func__, n);
}
fmi3Status fmi3SetBinary(fmi3Instance c, fmi3ValueReference const[], size_t n, size_t const[], fmi3Binary const[],
                         size_t) {
  return lacks(c, __func__, n);
}
fmi3Status fmi3GetClock(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Clock[]) {
  return lacks(c, __func__, n);
}
fmi3Status fmi3SetClock(fmi3Instance c, fmi3ValueReference const[], size_t n, fmi3Clock const[]) {
  return lacks(c, __func__, n);
}

// ------------------------------------------------------------------------------ saved states
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState* state) {
  return call(c, __func__, &Instance::get_state, state);
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
  return call(c, __func__, &Instance::set_state, state);
}
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState* state) {
  return call(c, __func__, &Instance::free_state, state);
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t* size) {
  return call(c, __func__, &Instance::state_size, state, size);
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
  return call(c, __func__, &Instance::write_state, state, bytes, size);
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, fmi3Byte const bytes[], size_t size, fmi3FMUState* state) {
  return call(c, __func__, &Instance::read_state, bytes, size, state);
}

// ------------------------------------------------------------------------------ model exchange
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, fmi3ValueReference const unknown[], size_t n,
                                        fmi3ValueReference const known[], size_t m, fmi3Float64 const seed[],
                                        size_t seeds, fmi3Float64 out[], size_t outs) {
  return call(c, __func__, [&](Instance& i) {
    if (seeds != m || outs != n) return i.log(Answer::error, "not as many numbers as scalars");
    return exchange_directional(i, unknown, n, known, m, seed, out);
  });
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) { return call(c, __func__, &Instance::go, continuous_time, event_mode); }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean* again, fmi3Boolean* over, fmi3Boolean* nominals,
                                    fmi3Boolean* values, fmi3Boolean* has_next, fmi3Float64* next) {
  return call(c, __func__, [&](Instance& i) {
    if (again == nullptr || over == nullptr || nominals == nullptr || values == nullptr || has_next == nullptr ||
        next == nullptr)
      return i.log(Answer::error, "null pointer");
    Events events;
    Answer const answer = exchange_events(i, events);
    *again = *nominals = *values = false;
    *over = events.over;
    *has_next = events.has_next;
    *next = events.has_next ? events.next : 0.0;
    return answer;
  });
}
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
  return call(c, __func__, &Instance::go, event_mode, continuous_time);
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean, fmi3Boolean* event, fmi3Boolean* terminate) {
  return call(c, __func__, exchange_step_done<fmi3Boolean>, event, terminate);
}
fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) { return call(c, __func__, set_exchange_time, time); }
fmi3Status fmi3SetContinuousStates(fmi3Instance c, fmi3Float64 const states[], size_t n) {
  return call(c, __func__, set_exchange_states, states, n);
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 out[], size_t n) {
  return call(c, __func__, get_rates, out, n);
}
fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 out[], size_t n) {
  return call(c, __func__, get_indicators, out, n);
}
fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 out[], size_t n) {
  return call(c, __func__, get_of_states, out, n, &ContinuousPlant::states);
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 out[], size_t n) {
  return call(c, __func__, get_of_states, out, n, &ContinuousPlant::nominals);
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t* count) {
  return call(c, __func__, get_count, count, &ContinuousPlant::indicator_count);
}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t* count) {
  return call(c, __func__, get_count, count, &ContinuousPlant::count);
}

// ------------------------------------------------------------------------------ not offered
#define ROLLERRIG_LACKS(Function, ...) \
  fmi3Status fmi3##Function(fmi3Instance c __VA_OPT__(, ) __VA_ARGS__) { return lacks(c, __func__); }
using References = fmi3ValueReference const[];
ROLLERRIG_LACKS(GetNumberOfVariableDependencies, fmi3ValueReference, size_t*)
ROLLERRIG_LACKS(GetVariableDependencies, fmi3ValueReference, size_t[], fmi3ValueReference[], size_t[],
                fmi3DependencyKind[], size_t)
ROLLERRIG_LACKS(GetAdjointDerivative, References, size_t, References, size_t, fmi3Float64 const[], size_t,
                fmi3Float64[], size_t)
ROLLERRIG_LACKS(EnterConfigurationMode)
ROLLERRIG_LACKS(ExitConfigurationMode)
ROLLERRIG_LACKS(GetIntervalDecimal, References, size_t, fmi3Float64[], fmi3IntervalQualifier[])
ROLLERRIG_LACKS(GetIntervalFraction, References, size_t, fmi3UInt64[], fmi3UInt64[], fmi3IntervalQualifier[])
ROLLERRIG_LACKS(GetShiftDecimal, References, size_t, fmi3Float64[])
ROLLERRIG_LACKS(GetShiftFraction, References, size_t, fmi3UInt64[], fmi3UInt64[])
ROLLERRIG_LACKS(SetIntervalDecimal, References, size_t, fmi3Float64 const[])
ROLLERRIG_LACKS(SetIntervalFraction, References, size_t, fmi3UInt64 const[], fmi3UInt64 const[])
ROLLERRIG_LACKS(SetShiftDecimal, References, size_t, fmi3Float64 const[])
ROLLERRIG_LACKS(SetShiftFraction, References, size_t, fmi3UInt64 const[], fmi3UInt64 const[])
ROLLERRIG_LACKS(EvaluateDiscreteStates)
ROLLERRIG_LACKS(EnterStepMode)
ROLLERRIG_LACKS(GetOutputDerivatives, References, size_t, fmi3Int32 const[], fmi3Float64[], size_t)
ROLLERRIG_LACKS(ActivateModelPartition, fmi3ValueReference, fmi3Float64)
#undef ROLLERRIG_LACKS
}
