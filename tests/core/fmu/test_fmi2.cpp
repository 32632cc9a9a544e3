#include "fmi2Functions.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdarg>
#include <random>
#include <thread>

#include "fmu/small_fmu.hpp"
#include "rollerrig/plant/continuous_plant.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

struct Heard {
  std::vector<std::string> lines;
};

void hear(fmi2ComponentEnvironment environment, fmi2String, fmi2Status, fmi2String, fmi2String format, ...) {
  char text[1024];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (environment != nullptr) static_cast<Heard*>(environment)->lines.emplace_back(text);
}

fmi2Component made(SmallFmu const& fmu, Heard* heard = nullptr, fmi2Type type = fmi2CoSimulation) {
  fmi2CallbackFunctions const functions{hear, nullptr, nullptr, nullptr, heard};
  return fmi2Instantiate("small", type, fmu.token.c_str(), fmu.uri().c_str(), &functions, 0, 0);
}

void begin(fmi2Component c) {
  REQUIRE(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == fmi2OK);
  REQUIRE(fmi2EnterInitializationMode(c) == fmi2OK);
  REQUIRE(fmi2ExitInitializationMode(c) == fmi2OK);
}

/// All values after so many steps of 10 ms.
std::vector<double> course(fmi2Component c, std::size_t variables, int steps) {
  std::vector<fmi2ValueReference> references(variables + 1);
  for (std::size_t i = 0; i < references.size(); ++i) references[i] = static_cast<fmi2ValueReference>(i);
  std::vector<double> values(references.size());
  for (int k = 0; k < steps; ++k) CHECK(fmi2DoStep(c, 0.01 * k, 0.01, fmi2True) == fmi2OK);
  CHECK(fmi2GetReal(c, references.data(), references.size(), values.data()) == fmi2OK);
  return values;
}

bool same(std::vector<double> const& a, std::vector<double> const& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

}  // namespace

TEST_CASE("FMI 2.0: an FMU's outputs are those of its plant, bit for bit") {
  SmallFmu const fmu;
  Plant plant(braked());
  REQUIRE(plant.start(HUGE_VAL) == Status::ok);
  REQUIRE(plant.advance(0.2) == Status::ok);
  fmi2Component c = made(fmu);
  REQUIRE(c != nullptr);
  begin(c);
  auto const values = course(c, plant.variables().size(), 20);
  CHECK(values[0] == doctest::Approx(0.2));
  for (std::size_t i = 1; i < values.size(); ++i) {
    double const expected = plant.get(static_cast<int>(i) - 1);
    CHECK(std::memcmp(&values[i], &expected, sizeof expected) == 0);
  }
  fmi2FreeInstance(c);
}

TEST_CASE("FMI 2.0: two instances do not meet, nor do eight in threads") {
  SmallFmu const fmu;
  std::size_t const variables = Plant(braked()).variables().size();
  fmi2Component alone = made(fmu);
  begin(alone);
  auto const expected = course(alone, variables, 10);
  fmi2FreeInstance(alone);

  fmi2Component first = made(fmu), second = made(fmu);
  begin(first);
  begin(second);
  fmi2ValueReference const demand = 1;
  double const more = 1e5;
  CHECK(fmi2SetReal(second, &demand, 1, &more) == fmi2OK);
  for (int k = 0; k < 10; ++k) {
    CHECK(fmi2DoStep(first, 0.01 * k, 0.01, fmi2True) == fmi2OK);
    CHECK(fmi2DoStep(second, 0.01 * k, 0.01, fmi2True) == fmi2OK);
  }
  CHECK(same(course(first, variables, 0), expected));
  CHECK_FALSE(same(course(second, variables, 0), expected));
  fmi2FreeInstance(first);
  fmi2FreeInstance(second);

  std::vector<std::vector<double>> found(8);
  std::vector<std::thread> threads;
  std::vector<fmi2Component> all;
  for (std::size_t i = 0; i < found.size(); ++i) all.push_back(made(fmu));
  for (std::size_t i = 0; i < found.size(); ++i) {
    begin(all[i]);
    threads.emplace_back([&, i] { found[i] = course(all[i], variables, 10); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(same(found[i], expected));
    fmi2FreeInstance(all[i]);
  }
}

TEST_CASE(
    "FMI 2.0: a state taken while the wheel slides, taken back here or elsewhere: the same bytes after going on") {
  SmallFmu const fmu;
  std::size_t const variables = Plant(braked()).variables().size();
  auto const go_on = [&](fmi2Component c) {
    for (int k = 10; k < 20; ++k) CHECK(fmi2DoStep(c, 0.01 * k, 0.01, fmi2True) == fmi2OK);
    return course(c, variables, 0);
  };
  fmi2Component c = made(fmu), other = made(fmu);
  begin(c);
  course(c, variables, 10);
  fmi2FMUstate state = nullptr, copy = nullptr;
  CHECK(fmi2GetFMUstate(c, &state) == fmi2OK);
  auto const expected = go_on(c);
  CHECK(fmi2SetFMUstate(c, state) == fmi2OK);
  CHECK(same(go_on(c), expected));

  std::size_t size = 0;
  CHECK(fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK);
  std::vector<char> bytes(size);
  CHECK(fmi2SerializeFMUstate(c, state, bytes.data(), size - 1) == fmi2Error);
  CHECK(fmi2SerializeFMUstate(c, state, bytes.data(), size) == fmi2OK);
  CHECK(fmi2DeSerializeFMUstate(other, bytes.data(), size, &copy) == fmi2OK);
  CHECK(fmi2SetFMUstate(other, copy) == fmi2OK);
  CHECK(same(go_on(other), expected));

  CHECK(fmi2SetFMUstate(c, copy) == fmi2Error);  // of the other instance
  CHECK(fmi2DeSerializeFMUstate(c, bytes.data(), size - 1, &copy) == fmi2Error);
  bytes[size / 2] = static_cast<char>(bytes[size / 2] ^ 1);
  CHECK(fmi2DeSerializeFMUstate(c, bytes.data(), size, &copy) == fmi2Error);
  CHECK(fmi2FreeFMUstate(c, &state) == fmi2OK);
  CHECK(state == nullptr);
  fmi2FreeInstance(c);
  fmi2FreeInstance(other);
}

TEST_CASE("FMI 2.0: what is not this FMU's own is refused with a line") {
  SmallFmu const fmu;
  Heard heard;
  fmi2CallbackFunctions const functions{hear, nullptr, nullptr, nullptr, &heard};
  auto const refused = [&](fmi2Type type, char const* guid, char const* location, char const* line) {
    CHECK(fmi2Instantiate("x", type, guid, location, &functions, 0, 0) == nullptr);
    REQUIRE_FALSE(heard.lines.empty());
    CHECK(heard.lines.back() == std::string("fmi2Instantiate: ") + line);
  };
  std::string const uri = fmu.uri();
  refused(fmi2CoSimulation, "another", uri.c_str(),
          "the token of modelDescription.xml is not that of the model among the resources");
  refused(fmi2CoSimulation, fmu.token.c_str(), "file:///no/such/place", "cannot open rig.model among the resources");
  refused(fmi2CoSimulation, fmu.token.c_str(), "http://somewhere", "fmuResourceLocation is no URI of a file");
  refused(fmi2CoSimulation, nullptr, uri.c_str(), "null pointer");
  refused(static_cast<fmi2Type>(7), fmu.token.c_str(), uri.c_str(), "there is no such type of FMU");
  std::ofstream(fmu.folder / "rig.model", std::ios::binary) << "rollerrig model\n";
  refused(fmi2CoSimulation, fmu.token.c_str(), uri.c_str(), "model file: cut: it ends after 16 bytes");
  CHECK(fmi2Instantiate("x", fmi2CoSimulation, "", "", nullptr, 0, 0) == nullptr);
}

namespace {

/// One call of a tool that has lost its way: any function, any order, any value that is no wild pointer.
fmi2Status any_call(fmi2Component c, std::mt19937& random) {
  auto const pick = [&](auto... values) {
    std::array const all{values...};
    return all[random() % all.size()];
  };
  double const number = pick(0.0, 0.01, -1.0, 1e300, 3e5, std::nan(""), HUGE_VAL, 0.1);
  fmi2ValueReference const refs[] = {pick(0u, 1u, 2u, 60u, 1000u, ~0u), 1u};
  std::size_t const n = random() % 3;
  double values[] = {number, pick(0.0, 1e5)};
  bool const null = random() % 16 == 0;
  auto const* r = null ? nullptr : refs;
  int whole[2]{};
  char const* text[2]{};
  switch (random() % 32) {
    case 0: return fmi2SetupExperiment(c, 0, 0.0, number, pick(0, 1), pick(1.0, 0.0, std::nan("")));
    case 1:
    case 2: return fmi2EnterInitializationMode(c);
    case 3:
    case 4: return fmi2ExitInitializationMode(c);
    case 5: return random() % 8 == 0 ? fmi2Terminate(c) : fmi2OK;
    case 6: return random() % 8 == 0 ? fmi2Reset(c) : fmi2OK;
    case 7:
    case 8: return fmi2GetReal(c, r, n, null ? nullptr : values);
    case 9:
    case 10: return fmi2SetReal(c, r, n, null ? nullptr : values);
    case 11: return fmi2GetInteger(c, r, n, whole);
    case 12: return fmi2GetBoolean(c, r, n, whole);
    case 13: return fmi2GetString(c, r, n, text);
    case 14: return fmi2SetInteger(c, r, n, whole);
    case 15: return fmi2SetString(c, r, n, text);
    case 16: return fmi2CancelStep(c);
    case 17:
      return fmi2GetStatus(c, pick(fmi2DoStepStatus, fmi2Terminated),
                           null ? nullptr : reinterpret_cast<fmi2Status*>(whole));
    case 18: return fmi2GetRealStatus(c, pick(fmi2LastSuccessfulTime, fmi2Terminated), null ? nullptr : values);
    case 19: return fmi2GetBooleanStatus(c, pick(fmi2Terminated, fmi2DoStepStatus), null ? nullptr : whole);
    case 20: return fmi2SetTime(c, number);
    case 21: return fmi2GetDerivatives(c, values, n);
    case 22: return fmi2SetDebugLogging(c, 1, random() % 5, null ? nullptr : text);
    case 23: return fmi2GetDirectionalDerivative(c, r, n, r, n, values, values);
    case 24: return fmi2EnterEventMode(c);
    case 25: {
      fmi2EventInfo info{};
      return fmi2NewDiscreteStates(c, null ? nullptr : &info);
    }
    case 26: return fmi2EnterContinuousTimeMode(c);
    case 27: return fmi2CompletedIntegratorStep(c, 1, whole, null ? nullptr : whole + 1);
    case 28: {
      static std::vector<double> states(list_continuous_variables(braked()).states.size());
      std::size_t const all = pick(std::size_t{0}, std::size_t{1}, states.size(), states.size());
      if (random() % 64 == 0) states.assign(states.size(), number);
      return random() % 2 == 0 ? fmi2SetContinuousStates(c, null ? nullptr : states.data(), all)
                               : fmi2GetContinuousStates(c, null ? nullptr : states.data(), all);
    }
    case 29: return fmi2GetEventIndicators(c, null ? nullptr : values, n);
    default: {
      fmi2Real at = 0.0;
      fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &at);
      return fmi2DoStep(c, random() % 4 == 0 ? number : at, pick(0.001, 0.01, 0.0, -1.0, 1e300, std::nan(""), HUGE_VAL),
                        fmi2True);
    }
  }
}

}  // namespace

TEST_CASE("FMI 2.0: a hundred thousand calls in any order with any value: a status each time, and the FMU still runs") {
  SmallFmu const fmu;
  fmi2Component c = nullptr;
  SUBCASE("co-simulation") { c = made(fmu); }
  SUBCASE("model exchange") {
    c = made(fmu, nullptr, fmi2ModelExchange);
    std::mt19937 random(20260102);
    std::array<int, 6> counts{};
    for (int i = 0; i < 100'000; ++i) ++counts[static_cast<std::size_t>(any_call(c, random))];
    CHECK(counts[fmi2OK] > 1000);
    CHECK(counts[fmi2Error] > 1000);
    CHECK(counts[fmi2Fatal] == 0);
    fmi2FreeInstance(c);
    return;
  }
  std::mt19937 random(20260101);
  std::array<int, 6> counts{};
  for (int i = 0; i < 100'000; ++i)
    ++counts[static_cast<std::size_t>(any_call(random() % 50 == 0 ? nullptr : c, random))];
  CHECK(counts[fmi2OK] > 1000);
  CHECK(counts[fmi2Error] > 1000);
  CHECK(counts[fmi2Fatal] == 0);
  CHECK(counts[fmi2Pending] == 0);
  std::size_t const variables = Plant(braked()).variables().size();
  fmi2Component fresh = made(fmu);
  CHECK(fmi2Reset(c) == fmi2OK);
  begin(c);
  begin(fresh);
  CHECK(same(course(c, variables, 5), course(fresh, variables, 5)));
  fmi2FreeInstance(c);
  fmi2FreeInstance(fresh);
}
