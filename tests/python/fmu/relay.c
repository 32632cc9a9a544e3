/* A slide protection by somebody else, FMI 2.0 for co-simulation: vents an axle that turns slower than a part of the fastest one.
 *
 * Two Real inputs (references 0, 1), two Integer outputs (2, 3), Real parameters: part of the speed (4), time after which it
 * fails (5), time after which its first output is out of its limits (6); String parameter (7), Boolean parameter: never vents (8).
 * The same outputs as Real (9, 10), of which the first is no number from a time on (11). How it dies in its first step (12): by
 * abort, exit or in an endless loop for 1, 2, 3.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

typedef struct {
  fmi2CallbackFunctions const* callbacks;
  double real[13];
  int valve[2], never;
} Relay;

char const* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
char const* fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                              fmi2CallbackFunctions const* functions, fmi2Boolean visible, fmi2Boolean logging) {
  Relay* relay = calloc(1, sizeof *relay);
  (void)name, (void)location, (void)visible, (void)logging;
  if (type != fmi2CoSimulation || strcmp(guid, "relay") != 0) return NULL;
  relay->callbacks = functions;
  relay->real[4] = 0.9, relay->real[5] = relay->real[6] = relay->real[11] = 1e9;
  return relay;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real t, fmi2Real s, fmi2Boolean e, fmi2Real f) {
  (void)c, (void)d, (void)t, (void)s, (void)e, (void)f;
  return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2Terminate(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2Reset(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2SetReal(fmi2Component c, fmi2ValueReference const vr[], size_t n, fmi2Real const value[]) {
  for (size_t i = 0; i < n; ++i) ((Relay*)c)->real[vr[i]] = value[i];
  return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, fmi2ValueReference const vr[], size_t n, fmi2Real value[]) {
  for (size_t i = 0; i < n; ++i) value[i] = ((Relay*)c)->real[vr[i]];
  return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, fmi2ValueReference const vr[], size_t n, fmi2Integer value[]) {
  for (size_t i = 0; i < n; ++i) value[i] = ((Relay*)c)->valve[vr[i] - 2];
  return fmi2OK;
}
fmi2Status fmi2SetBoolean(fmi2Component c, fmi2ValueReference const vr[], size_t n, fmi2Boolean const value[]) {
  for (size_t i = 0; i < n; ++i) ((Relay*)c)->never = vr[i] == 8 && value[i];
  return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, fmi2ValueReference const vr[], size_t n, fmi2String const value[]) {
  for (size_t i = 0; i < n; ++i)
    if (vr[i] != 7 || strcmp(value[i], "dry") != 0) return fmi2Error;
  return c ? fmi2OK : fmi2Error;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real length, fmi2Boolean keep) {
  Relay* relay = c;
  double fastest = relay->real[0] > relay->real[1] ? relay->real[0] : relay->real[1];
  (void)length, (void)keep;
  if (relay->real[12] == 1) abort();
  if (relay->real[12] == 2) exit(0);
  while (relay->real[12] == 3) (void)*(double volatile*)&fastest;
  if (time > relay->real[5]) {
    relay->callbacks->logger(relay->callbacks->componentEnvironment, "relay", fmi2Error, "error", "the wire is broken");
    return fmi2Error;
  }
  for (int i = 0; i < 2; ++i) relay->valve[i] = !relay->never && relay->real[i] < relay->real[4] * fastest ? 2 : 0;
  if (time > relay->real[6]) relay->valve[0] = 7;
  for (int i = 0; i < 2; ++i) relay->real[9 + i] = relay->valve[i];
  if (time > relay->real[11]) relay->real[9] = NAN;
  return fmi2OK;
}

/* The standard asks for all of them. */
#define NOT_OFFERED(name, ...) \
  fmi2Status name(fmi2Component c __VA_OPT__(, ) __VA_ARGS__) { return c ? fmi2Error : fmi2Fatal; }
typedef fmi2ValueReference const References[];
NOT_OFFERED(fmi2SetDebugLogging, fmi2Boolean, size_t, fmi2String const[])
NOT_OFFERED(fmi2GetBoolean, References, size_t, fmi2Boolean[])
NOT_OFFERED(fmi2GetString, References, size_t, fmi2String[])
NOT_OFFERED(fmi2SetInteger, References, size_t, fmi2Integer const[])
NOT_OFFERED(fmi2GetFMUstate, fmi2FMUstate*)
NOT_OFFERED(fmi2SetFMUstate, fmi2FMUstate)
NOT_OFFERED(fmi2FreeFMUstate, fmi2FMUstate*)
NOT_OFFERED(fmi2SerializedFMUstateSize, fmi2FMUstate, size_t*)
NOT_OFFERED(fmi2SerializeFMUstate, fmi2FMUstate, fmi2Byte[], size_t)
NOT_OFFERED(fmi2DeSerializeFMUstate, fmi2Byte const[], size_t, fmi2FMUstate*)
NOT_OFFERED(fmi2GetDirectionalDerivative, References, size_t, References, size_t, fmi2Real const[], fmi2Real[])
NOT_OFFERED(fmi2SetRealInputDerivatives, References, size_t, fmi2Integer const[], fmi2Real const[])
NOT_OFFERED(fmi2GetRealOutputDerivatives, References, size_t, fmi2Integer const[], fmi2Real[])
NOT_OFFERED(fmi2CancelStep)
NOT_OFFERED(fmi2GetStatus, fmi2StatusKind const, fmi2Status*)
NOT_OFFERED(fmi2GetRealStatus, fmi2StatusKind const, fmi2Real*)
NOT_OFFERED(fmi2GetIntegerStatus, fmi2StatusKind const, fmi2Integer*)
NOT_OFFERED(fmi2GetBooleanStatus, fmi2StatusKind const, fmi2Boolean*)
NOT_OFFERED(fmi2GetStringStatus, fmi2StatusKind const, fmi2String*)
