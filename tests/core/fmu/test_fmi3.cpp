#include "fmi3Functions.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "fmu/small_fmu.hpp"
#include "rollerrig/plant/plant.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

struct Heard3 {
  std::vector<std::string> lines;
};

void hear3(fmi3InstanceEnvironment environment, fmi3Status, fmi3String, fmi3String text) {
  if (environment != nullptr) static_cast<Heard3*>(environment)->lines.emplace_back(text);
}

fmi3Instance made3(SmallFmu const& fmu, Heard3* heard = nullptr, bool exchange = false) {
  if (exchange)
    return fmi3InstantiateModelExchange("small", fmu.token.c_str(), fmu.folder.string().c_str(), false, false, heard,
                                        hear3);
  return fmi3InstantiateCoSimulation("small", fmu.token.c_str(), fmu.folder.string().c_str(), false, false, false,
                                     false, nullptr, 0, heard, hear3, nullptr);
}

void begin3(fmi3Instance c) {
  REQUIRE(fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0) == fmi3OK);
  REQUIRE(fmi3ExitInitializationMode(c) == fmi3OK);
}

fmi3Status step3(fmi3Instance c, double at, double length) {
  bool event = false, terminate = false, early = false;
  double time = 0.0;
  return fmi3DoStep(c, at, length, true, &event, &terminate, &early, &time);
}

/// All values after steps of 10 ms.
std::vector<double> course3(fmi3Instance c, int first, int last) {
  std::vector<fmi3ValueReference> references(Plant(braked()).variables().size() + 1);
  for (std::size_t i = 0; i < references.size(); ++i) references[i] = static_cast<fmi3ValueReference>(i);
  std::vector<double> values(references.size());
  for (int k = first; k < last; ++k) CHECK(step3(c, 0.01 * k, 0.01) == fmi3OK);
  CHECK(fmi3GetFloat64(c, references.data(), references.size(), values.data(), values.size()) == fmi3OK);
  return values;
}

bool same3(std::vector<double> const& a, std::vector<double> const& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

}  // namespace

TEST_CASE(
    "FMI 3.0: a state taken while the wheel slides, taken back here or elsewhere: the same bytes after going on") {
  SmallFmu const fmu;
  fmi3Instance c = made3(fmu), other = made3(fmu);
  REQUIRE(c != nullptr);
  begin3(c);
  course3(c, 0, 10);
  fmi3FMUState state = nullptr, copy = nullptr;
  CHECK(fmi3GetFMUState(c, &state) == fmi3OK);
  auto const expected = course3(c, 10, 20);
  CHECK(fmi3SetFMUState(c, state) == fmi3OK);
  CHECK(same3(course3(c, 10, 20), expected));

  std::size_t size = 0;
  CHECK(fmi3SerializedFMUStateSize(c, state, &size) == fmi3OK);
  std::vector<fmi3Byte> bytes(size);
  CHECK(fmi3SerializeFMUState(c, state, bytes.data(), size - 1) == fmi3Error);
  CHECK(fmi3SerializeFMUState(c, state, bytes.data(), size) == fmi3OK);
  CHECK(fmi3DeserializeFMUState(other, bytes.data(), size, &copy) == fmi3OK);
  CHECK(fmi3SetFMUState(other, copy) == fmi3OK);
  CHECK(same3(course3(other, 10, 20), expected));

  CHECK(fmi3SetFMUState(c, copy) == fmi3Error);  // of the other instance
  CHECK(fmi3DeserializeFMUState(c, bytes.data(), size - 1, &copy) == fmi3Error);
  bytes[size / 2] = static_cast<fmi3Byte>(bytes[size / 2] ^ 1);
  CHECK(fmi3DeserializeFMUState(c, bytes.data(), size, &copy) == fmi3Error);
  CHECK(fmi3FreeFMUState(c, &state) == fmi3OK);
  CHECK(state == nullptr);
  fmi3FreeInstance(c);
  fmi3FreeInstance(other);
}

TEST_CASE("FMI 3.0: what an error was is a line in the log, with or without debug logging") {
  SmallFmu const fmu;
  Heard3 heard;
  fmi3Instance c = made3(fmu, &heard);
  begin3(c);
  CHECK(step3(c, 0.0, 1e300) == fmi3Error);
  REQUIRE(heard.lines.size() == 1);
  CHECK(heard.lines[0] == "fmi3DoStep: communicationStepSize is 1e+300 s; allowed: up to 86400");
  fmi3String const category = "logStatusError", none = "logEverything";
  CHECK(fmi3SetDebugLogging(c, true, 1, &category) == fmi3OK);
  CHECK(fmi3SetDebugLogging(c, true, 1, &none) == fmi3Error);
  CHECK(fmi3SetDebugLogging(c, false, 0, nullptr) == fmi3OK);
  CHECK(step3(c, 0.5, 0.1) == fmi3Error);
  CHECK(heard.lines.size() == 3);
  CHECK(step3(c, 0.0, 0.01) == fmi3OK);
  fmi3FreeInstance(c);
}

namespace {

/// A tool that has lost its way: any function, any order, any value that is no wild pointer.
struct Lost {
  fmi3Instance c;
  std::mt19937 random{20260102};
  fmi3FMUState state{nullptr};
  int steps{0};

  template <class... T>
  auto pick(T... values) {
    std::array const all{values...};
    return all[random() % all.size()];
  }

  fmi3Status step() {
    bool event = false, terminate = false, early = false;
    double at = 0.0, reached = 0.0;
    fmi3ValueReference const clock = 0;
    fmi3GetFloat64(c, &clock, 1, &at, 1);
    double const length = pick(0.001, 0.01, 0.0, -1.0, 1e300, std::nan(""), HUGE_VAL);
    double const from = pick(at, at, at, -1.0, 1e300, std::nan(""));
    auto* told = random() % 16 == 0 ? nullptr : &event;
    fmi3Status const status = fmi3DoStep(c, from, length, random() % 2 == 0, told, &terminate, &early, &reached);
    steps += status == fmi3OK;
    return status;
  }

  fmi3Status with_states() {
    std::size_t size = 0;
    std::array<fmi3Byte, 64> bytes{};
    switch (random() % 6) {
      case 0: return fmi3GetFMUState(c, random() % 8 == 0 ? nullptr : &state);
      case 1: return fmi3SetFMUState(c, pick(state, static_cast<fmi3FMUState>(this), fmi3FMUState{}));
      case 2: return fmi3FreeFMUState(c, random() % 8 == 0 ? nullptr : &state);
      case 3: return fmi3SerializedFMUStateSize(c, state, random() % 8 == 0 ? nullptr : &size);
      case 4: return fmi3SerializeFMUState(c, state, bytes.data(), random() % bytes.size());
      default: return fmi3DeserializeFMUState(c, bytes.data(), random() % bytes.size(), &state);
    }
  }

  fmi3Status with_values() {
    double const number = pick(0.0, 0.01, -1.0, 1e300, 3e5, std::nan(""), HUGE_VAL, 0.1);
    fmi3ValueReference const refs[] = {pick(0u, 1u, 2u, 60u, 1000u, ~0u), 1u};
    std::size_t const n = random() % 3, m = random() % 8 == 0 ? random() % 3 : n;
    double values[] = {number, pick(0.0, 1e5)}, seeds[] = {1.0, number}, found[2]{};
    bool const null = random() % 16 == 0;
    auto const* r = null ? nullptr : refs;
    switch (random() % 8) {
      case 0:
      case 1: return fmi3GetFloat64(c, r, n, null ? nullptr : values, m);
      case 2:
      case 3:
      case 4: return fmi3SetFloat64(c, r, n, null ? nullptr : values, m);
      case 5: return fmi3GetDirectionalDerivative(c, r, n, r, n, seeds, m, found, m);
      case 6: {
        fmi3Int32 whole[2]{};
        return fmi3GetInt32(c, r, n, whole, m);
      }
      default: {
        fmi3String text[2]{};
        return fmi3SetString(c, r, n, text, m);
      }
    }
  }

  fmi3Status of_model_exchange() {
    double values[2]{pick(0.0, 1e300, std::nan("")), 0.0};
    bool told[5]{};
    switch (random() % 9) {
      case 0: return fmi3SetTime(c, values[0]);
      case 1: {
        std::size_t count = 0;
        fmi3GetNumberOfContinuousStates(c, &count);
        std::vector<double> states(count);
        if (fmi3GetContinuousStates(c, states.data(), count) == fmi3OK && count > 0)
          states[random() % count] += pick(0.0, 1e-6, 1e300);
        return fmi3SetContinuousStates(c, states.data(), count);
      }
      case 2: return fmi3GetContinuousStateDerivatives(c, values, 1);
      case 3: return fmi3GetEventIndicators(c, values, 1);
      case 4: return fmi3EnterContinuousTimeMode(c);
      case 5: return fmi3EnterEventMode(c);
      case 6: return fmi3CompletedIntegratorStep(c, true, told, told + 1);
      case 7: return fmi3GetContinuousStates(c, values, 1);
      default: return fmi3UpdateDiscreteStates(c, told, told + 1, told + 2, told + 3, told + 4, values);
    }
  }

  fmi3Status call() {
    switch (random() % 16) {
      case 0:
      case 1:
        return fmi3EnterInitializationMode(c, random() % 2 == 0, 0.0, pick(0.0, 0.0, 1e300, std::nan("")),
                                           random() % 2 == 0, pick(1.0, 0.0, std::nan("")));
      case 2:
      case 3: return fmi3ExitInitializationMode(c);
      case 4: return random() % 8 == 0 ? fmi3Terminate(c) : fmi3OK;
      case 5: return random() % 8 == 0 ? fmi3Reset(c) : fmi3OK;
      case 6:
      case 7: return with_states();
      case 8:
      case 9: return of_model_exchange();
      case 10:
      case 11: return step();
      default: return with_values();
    }
  }
};

}  // namespace

TEST_CASE("FMI 3.0: a hundred thousand calls in any order with any value: a status each time, and the FMU still runs") {
  SmallFmu const fmu;
  bool exchange = false;
  SUBCASE("co-simulation") {}
  SUBCASE("model exchange") { exchange = true; }
  Lost lost{made3(fmu, nullptr, exchange)};
  fmi3Instance const c = lost.c;
  std::array<int, 5> counts{};
  for (int i = 0; i < 100'000; ++i) {
    lost.c = lost.random() % 50 == 0 ? nullptr : c;
    ++counts[static_cast<std::size_t>(lost.call())];
  }
  CHECK(counts[fmi3OK] > 1000);
  CHECK(counts[fmi3Error] > 1000);
  CHECK(counts[fmi3Fatal] == 0);
  if (!exchange) CHECK(lost.steps > 100);  // it did run in between
  if (exchange) return fmi3FreeInstance(c);
  fmi3Instance fresh = made3(fmu);
  CHECK(fmi3Reset(c) == fmi3OK);
  begin3(c);
  begin3(fresh);
  CHECK(same3(course3(c, 0, 5), course3(fresh, 0, 5)));
  fmi3FreeInstance(c);
  fmi3FreeInstance(fresh);
}
