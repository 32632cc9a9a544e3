// A controller alone through the functions of FMI 2.0: the same instance as a whole rig, over another plant.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "fmi2Functions.h"
#include "plant/models.hpp"
#include "rollerrig/plant/controller_plant.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

void ignore(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...) {}

struct ControllerFmu {
  std::vector<std::byte> bytes;
  std::filesystem::path folder;
  std::size_t variables;

  ControllerFmu() {
    ControllerPart const part{.name = "small",
                              .step = 1e-3,
                              .controller = braked().setup->controllers[0],
                              .axles = {"axle_1"},
                              .train_speed = 20.0,
                              .axle_speed = {43.0},
                              .roller_speed = {27.0}};
    bytes = write_part(part);
    variables = ControllerPlant(part).variables().size();
    folder = std::filesystem::temp_directory_path() /
             ("rollerrig_part_" + std::to_string(reinterpret_cast<std::uintptr_t>(this)));
    std::filesystem::create_directories(folder);
    std::ofstream file(folder / "controller.part", std::ios::binary);
    file.write(reinterpret_cast<char const*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  ~ControllerFmu() { std::filesystem::remove_all(folder); }
  ControllerFmu(ControllerFmu const&) = delete;
  ControllerFmu& operator=(ControllerFmu const&) = delete;

  fmi2Component made(std::string const& token) const {
    fmi2CallbackFunctions const functions{ignore, nullptr, nullptr, nullptr, nullptr};
    std::string const uri = "file://" + folder.generic_string();
    return fmi2Instantiate("part", fmi2CoSimulation, token.c_str(), uri.c_str(), &functions, 0, 0);
  }
  fmi2Component begun() const {
    fmi2Component c = made(model_token(bytes));
    REQUIRE(c != nullptr);
    REQUIRE(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == fmi2OK);
    REQUIRE(fmi2EnterInitializationMode(c) == fmi2OK);
    REQUIRE(fmi2ExitInitializationMode(c) == fmi2OK);
    return c;
  }
};

/// Valve after each step of 5 ms of an axle that slides.
std::vector<double> slide(fmi2Component c, int from, int to) {
  fmi2ValueReference const speed = 1, valve = 2;
  std::vector<double> found;
  for (int k = from; k < to; ++k) {
    double const now = 43.0 - std::fmax(0.0, 0.3 * (k - 20)), time = 5e-3 * k;
    double command = -1.0;
    CHECK(fmi2SetReal(c, &speed, 1, &now) == fmi2OK);
    CHECK(fmi2DoStep(c, time, 5e-3, fmi2True) == fmi2OK);
    CHECK(fmi2GetReal(c, &valve, 1, &command) == fmi2OK);
    found.push_back(command);
  }
  return found;
}

}  // namespace

TEST_CASE(
    "a controller alone in FMI 2.0: vents a slide; from a saved state and after a reset the same; a wrong token") {
  ControllerFmu const fmu;
  CHECK(fmu.made("0123456789abcdef") == nullptr);
  fmi2Component c = fmu.begun();
  auto const first = slide(c, 0, 30);
  fmi2FMUstate state = nullptr;
  REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK);
  auto const rest = slide(c, 30, 60);
  CHECK(std::ranges::count(rest, 2.0) > 0);
  REQUIRE(fmi2SetFMUstate(c, state) == fmi2OK);
  CHECK(slide(c, 30, 60) == rest);
  CHECK(fmi2FreeFMUstate(c, &state) == fmi2OK);
  REQUIRE(fmi2Terminate(c) == fmi2OK);
  REQUIRE(fmi2Reset(c) == fmi2OK);
  REQUIRE(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == fmi2OK);
  REQUIRE(fmi2EnterInitializationMode(c) == fmi2OK);
  REQUIRE(fmi2ExitInitializationMode(c) == fmi2OK);
  CHECK(slide(c, 0, 30) == first);
  fmi2FreeInstance(c);
}

TEST_CASE("a controller alone in FMI 2.0: random calls and values are an error or answered, never more") {
  ControllerFmu const fmu;
  std::mt19937 random(7);
  auto const below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  double const values[] = {0.0,   -1.0, 43.0, 1e300, -1e300, std::nan(""), std::numeric_limits<double>::infinity(),
                           1e-300};
  fmi2Component c = fmu.begun();
  double time = 0.0;
  int done = 0;  // steps
  for (int k = 0; k < 20000; ++k) {
    fmi2ValueReference const reference = static_cast<fmi2ValueReference>(below(fmu.variables + 3));
    double value = values[below(std::size(values))];
    switch (below(6)) {
      case 0: fmi2SetReal(c, &reference, 1, &value); break;
      case 1: fmi2GetReal(c, &reference, 1, &value); break;
      case 2: fmi2DoStep(c, value + 1e6, 5e-3, fmi2True); break;
      case 3:
        if (fmi2DoStep(c, time, 5e-3, fmi2True) == fmi2OK) time += 5e-3, ++done;
        break;
      case 4: fmi2ExitInitializationMode(c); break;
      default: fmi2SetupExperiment(c, 0, 0.0, value, 1, value); break;
    }
  }
  CHECK(done > 100);
  CHECK(fmi2DoStep(c, time, 1e300, fmi2True) == fmi2Error);  // refused, nothing is changed
  CHECK(fmi2DoStep(c, time, 5e-3, fmi2True) == fmi2OK);
  fmi2FreeInstance(c);
}
