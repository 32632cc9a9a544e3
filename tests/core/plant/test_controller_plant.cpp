#include "rollerrig/plant/controller_plant.hpp"

#include <doctest/doctest.h>

#include <stdexcept>

#include "plant/models.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

ControllerPart slide_protection() {
  return {.name = "small",
          .step = 1e-3,
          .controller = braked().setup->controllers[0],
          .axles = {"axle_1", "axle_2"},
          .train_speed = 20.0,
          .axle_speed = {43.0, 43.0},
          .roller_speed = {27.0, 27.0}};
}

/// Of an axle that slides from 0.2 s on.
double speed(double time) { return 43.0 - (time > 0.2 ? 40.0 * (time - 0.2) : 0.0); }

int index_of(ControllerPlant const& plant, std::string const& name) {
  auto const all = plant.variables();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].name == name) return static_cast<int>(i);
  return -1;
}

}  // namespace

TEST_CASE("a controller alone commands what its law does, sample by sample") {
  ControllerPart const part = slide_protection();
  ControllerPlant plant(part);
  REQUIRE(plant.start(1.0) == Status::ok);
  auto const& law = std::get<WheelSlideProtection>(part.controller.controller);
  auto state = law.start({}, part.train_speed, 5e-3);
  PerAxle<double> valve{};
  bool vented = false;
  for (int k = 0; k < 100; ++k) {
    double const time = 5e-3 * k;
    Measurements now;
    now.time = time, now.axles = now.under_test = 2;
    now.vehicle_axle_speed = {speed(time), 43.0};
    law.step(state, now, 5e-3, valve);
    CHECK(plant.set_input(index_of(plant, "axle_1.axle_speed"), speed(time)));
    CHECK(plant.advance(time + 2e-3) == Status::ok);  // the sample, then nothing until the next one
    CHECK(plant.advance(time + 5e-3) == Status::ok);
    CHECK(plant.get(index_of(plant, "axle_1.valve_command")) == valve[0]);
    CHECK(plant.get(index_of(plant, "axle_2.valve_command")) == valve[1]);
    CHECK(plant.get(index_of(plant, "train.reference_speed")) == state.reference_speed());
    vented = vented || valve[0] == 2.0;
  }
  CHECK(vented);
}

TEST_CASE("a controller alone: saved in a slide, it goes on with the same commands; another part refuses the state") {
  ControllerPlant plant(slide_protection());
  plant.start(1.0);
  int const input = index_of(plant, "axle_1.axle_speed"), valve = index_of(plant, "axle_1.valve_command");
  auto const run = [&](ControllerPlant& p, int from, int to) {
    std::vector<double> found;
    for (int k = from; k < to; ++k) {
      p.set_input(input, speed(5e-3 * k));
      p.advance(5e-3 * (k + 1));
      found.push_back(p.get(valve));
    }
    return found;
  };
  run(plant, 0, 50);
  auto const bytes = plant.save();
  auto const first = run(plant, 50, 90);
  ControllerPlant second(slide_protection());
  REQUIRE(second.restore(bytes));
  CHECK(second.time() == doctest::Approx(0.25));
  CHECK(run(second, 50, 90) == first);
  ControllerPart other = slide_protection();
  other.train_speed = 21.0;
  ControllerPlant third(other);
  CHECK(!third.restore(bytes));
  CHECK(!third.restore({}));
}

TEST_CASE("a controller alone: the same bytes for the same part; what is cut, changed or foreign is refused") {
  auto const bytes = write_part(slide_protection());
  CHECK(bytes == write_part(read_part(bytes)));
  CHECK(model_token(bytes).size() == 16);
  std::span<std::byte const> const all(bytes);
  for (std::size_t const size : {std::size_t{0}, std::size_t{20}, bytes.size() - 1})
    CHECK_THROWS_AS(read_part(all.first(size)), std::invalid_argument);
  for (std::size_t place = 0; place < bytes.size(); place += 7) {
    auto changed = bytes;
    changed[place] ^= std::byte{1};
    CHECK_THROWS_AS(read_part(changed), std::invalid_argument);
  }
}

TEST_CASE("a controller alone: numbers of axles that do not fit are refused, and inputs that are none") {
  ControllerPart part = slide_protection();
  part.axle_speed.pop_back();
  CHECK_THROWS_AS(ControllerPlant{part}, std::invalid_argument);
  part = slide_protection();
  part.axles.clear();
  CHECK_THROWS_AS(write_part(part), std::invalid_argument);
  ControllerPlant plant(slide_protection());
  plant.start(1.0);
  CHECK(!plant.set_input(index_of(plant, "axle_1.valve_command"), 1.0));
  CHECK(!plant.set_input(-1, 1.0));
  CHECK(!plant.set_input(1000, 1.0));
  CHECK(!plant.set_input(index_of(plant, "axle_1.axle_speed"), std::nan("")));
}

TEST_CASE(
    "a brake unit alone: two cylinders of one reservoir, one vented, as the same brakes in a plant; air is conserved") {
  ReservoirAir const air{.fill_conductance = 2.5e-7,
                         .vent_conductance = 2e-7,
                         .critical_ratio = 0.3,
                         .relay_band = 2e4,
                         .opening_time = 0.01,
                         .closing_time = 0.01,
                         .least_pulse = 0.02,
                         .reservoir_volume = 0.1,
                         .reservoir_pressure = 6e5,
                         .main_pipe_pressure = 6e5,
                         .charging_conductance = 1e-9,
                         .reference_pressure = 1e5,
                         .temperature = 293.15,
                         .pipe = {}};
  ControlValve const valve{2e5, 2e5, 20.0, 1e5, 5e-3};
  BrakeUnit const unit{.pneumatics = {valve, air}, .reservoir = {0, 0}, .relay_valve = {}};
  ControllerPart part = slide_protection();
  part.controller = {.sampling = {.every = 2}, .controller = unit};
  ControllerPlant plant(part);
  CHECK(plant.variables().size() == 12);  // two inputs, a pressure and what its dump valve does per axle, no parameter
  plant.start(1.0);
  BrakeCylinders inside(unit.pneumatics, unit.reservoir, {}, 2);
  for (int k = 0; k < 1000; ++k) {
    PerAxle<double> const command{k > 500 ? 2.0 : 0.0, 0.0}, demand{3e5, 2e5};
    inside.step(unit.pneumatics, command, demand, 2e-3);
    for (std::size_t i = 0; i < 2; ++i) {
      std::string const axle = part.axles[i];
      CHECK(plant.set_input(index_of(plant, axle + ".dump_valve"), command[i]));
      CHECK(plant.set_input(index_of(plant, axle + ".brake_demand"), demand[i]));
    }
    plant.advance(2e-3 * (k + 1));
    for (std::size_t i = 0; i < 2; ++i)
      REQUIRE(plant.get(index_of(plant, part.axles[i] + ".cylinder_pressure_command")) == inside.cylinder(i).pressure);
  }
  for (auto const& [name, value] : {std::pair{"inlet_open", 0.0}, {"outlet_open", 1.0}, {"dump_cycles", 1.0}})
    CHECK(plant.get(index_of(plant, part.axles[0] + "." + name)) == value);
  CHECK(inside.cylinder(0).pressure < 1e4);
  CHECK(inside.cylinder(1).pressure == doctest::Approx(2e5).epsilon(2e-3));
  double taken = 0.0;
  for (std::size_t i = 0; i < 2; ++i) taken += inside.cylinder(i).air;
  double const given = inside.drawn() + air.reservoir_volume * (6e5 - inside.supply(0).reservoir) / 1e5;
  CHECK(taken == doctest::Approx(given).epsilon(1e-9));
  CHECK(!plant.set_input(index_of(plant, "axle_1.dump_valve"), 0.5));
  CHECK(!plant.set_input(index_of(plant, "axle_1.brake_demand"), -1.0));
}
