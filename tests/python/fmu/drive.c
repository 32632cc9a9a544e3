/* A tool on Windows that runs an FMU, FMI 2.0 for co-simulation:  drive.exe DLL TOKEN RESOURCES STEP COUNT REFERENCE...
 *
 * Prints a value per line, of the references after COUNT steps; what the FMU says goes to the other stream.
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <windows.h>

#include "fmi2FunctionTypes.h"

static void hear(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                 fmi2String format, ...) {
  va_list arguments;
  (void)environment, (void)name, (void)status, (void)category;
  va_start(arguments, format);
  vfprintf(stderr, format, arguments);
  va_end(arguments);
  fputs("\n", stderr);
}

static FARPROC find(HMODULE library, char const* name) {
  FARPROC const found = GetProcAddress(library, name);
  if (found == NULL) fprintf(stderr, "%s is not exported\n", name), exit(3);
  return found;
}
#define CALL(name) ((name##TYPE*)(void*)find(library, #name))

int main(int count, char** words) {
  if (count < 7) return 2;
  HMODULE const library = LoadLibraryA(words[1]);
  if (library == NULL) return fprintf(stderr, "%s: error %lu\n", words[1], GetLastError()), 3;
  fmi2CallbackFunctions const functions = {hear, NULL, NULL, NULL, NULL};
  fmi2Component const c = CALL(fmi2Instantiate)("driven", fmi2CoSimulation, words[2], words[3], &functions, 0, 0);
  if (c == NULL) return 4;
  double const step = atof(words[4]);
  int const steps = atoi(words[5]);
  if (CALL(fmi2SetupExperiment)(c, 0, 0.0, 0.0, 0, 0.0) != fmi2OK) return 5;
  if (CALL(fmi2EnterInitializationMode)(c) != fmi2OK || CALL(fmi2ExitInitializationMode)(c) != fmi2OK) return 6;
  for (int k = 0; k < steps; ++k)
    if (CALL(fmi2DoStep)(c, k * step, step, fmi2True) != fmi2OK) return 7;
  for (int i = 6; i < count; ++i) {
    fmi2ValueReference const reference = (fmi2ValueReference)atoi(words[i]);
    double value = 0.0;
    if (CALL(fmi2GetReal)(c, &reference, 1, &value) != fmi2OK) return 8;
    printf("%.17g\n", value);
  }
  CALL(fmi2FreeInstance)(c);
  return 0;
}
