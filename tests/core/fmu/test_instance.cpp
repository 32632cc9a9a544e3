#include "fmu/summing_plant.hpp"

#include <doctest/doctest.h>

using namespace rollerrig;
using namespace rollerrig::fmu;
using rollerrig::test::SummingPlant;

namespace {

struct Told {
  std::vector<std::string> lines;
  void operator()(Answer, char const*, char const* text) { lines.emplace_back(text); }
};

constexpr unsigned rate = 1, sum = 2, mass = 3;

struct Running {
  Told told;
  SummingPlant* plant = new SummingPlant;  ///< before a reset
  Instance fmu{std::unique_ptr<AnyPlant>(plant), {std::ref(told), "fmi2DoStep"}};

  Answer set(unsigned reference, double value) { return fmu.set(&reference, 1, &value); }
  double get(unsigned reference) {
    double value = -1.0;
    CHECK(fmu.get(&reference, 1, &value) == Answer::ok);
    return value;
  }
  void begin(double start = 0.0) {
    CHECK(fmu.setup(start, false, 0.0) == Answer::ok);
    CHECK(fmu.enter_initialization() == Answer::ok);
    CHECK(fmu.exit_initialization() == Answer::ok);
  }
};

}  // namespace

TEST_CASE("an FMU holds inputs over steps, and outputs stand at the communication points") {
  Running r;
  r.begin();
  CHECK(r.get(rate) == 2.0);
  CHECK(r.fmu.step(0.0, 0.5) == Answer::ok);
  CHECK(r.get(sum) == 1.0);
  CHECK(r.set(rate, -4.0) == Answer::ok);
  CHECK(r.fmu.step(0.5, 0.25) == Answer::ok);
  CHECK(r.get(sum) == 0.0);
  CHECK(r.get(0) == 0.75);
  CHECK(r.told.lines.empty());
}

TEST_CASE("what is set before the initialization is there at its start, and gone after a reset") {
  Running r;
  CHECK(r.set(rate, 5.0) == Answer::ok);
  r.begin();
  CHECK(r.get(rate) == 5.0);
  CHECK(r.fmu.step(0.0, 1.0) == Answer::ok);
  CHECK(r.fmu.reset() == Answer::ok);
  r.begin();
  CHECK(r.get(rate) == 2.0);
  CHECK(r.get(sum) == 0.0);
}

TEST_CASE("fixed parameters may be set until the end of the initialization, and a reset forgets them") {
  Running r;
  CHECK(r.set(mass, 9.0) == Answer::ok);
  CHECK(r.fmu.enter_initialization() == Answer::ok);
  CHECK(r.get(mass) == 9.0);
  CHECK(r.set(rate, 4.0) == Answer::ok);
  CHECK(r.set(mass, 11.0) == Answer::ok);
  CHECK(r.get(mass) == 11.0);
  CHECK(r.get(rate) == 4.0);
  CHECK(r.fmu.exit_initialization() == Answer::ok);
  CHECK(r.set(mass, 9.0) == Answer::error);
  CHECK(r.fmu.reset() == Answer::ok);
  r.begin();
  CHECK(r.get(mass) == 7.0);
}

TEST_CASE("the tool's clock may begin anywhere; the plant's begins with its case") {
  Running r;
  r.begin(100.0);
  CHECK(r.fmu.step(100.0, 0.5) == Answer::ok);
  CHECK(r.get(sum) == 1.0);
  CHECK(r.get(0) == 100.5);
}

TEST_CASE(
    "a step out of the model's validity is discarded; the log names time and wheel; then only reading is allowed") {
  Running r;
  r.plant->fails_at = 0.3;
  r.begin();
  CHECK(r.fmu.step(0.0, 0.5) == Answer::discard);
  REQUIRE(r.told.lines.size() == 1);
  CHECK(r.told.lines[0].starts_with("fmi2DoStep: at 0.3 s, wheelset_1_left: A wheelset derailed"));
  CHECK(r.fmu.last_step().run_over);
  CHECK(r.fmu.last_step().time == 0.3);
  CHECK(r.get(sum) == doctest::Approx(0.6));
  CHECK(r.fmu.step(0.3, 0.1) == Answer::error);
  CHECK(r.set(rate, 1.0) == Answer::error);
  CHECK(r.fmu.terminate() == Answer::ok);
  CHECK(r.fmu.reset() == Answer::ok);
}

TEST_CASE(
    "values out of limits, outputs, fixed parameters after the start, strange references: refused, nothing changed") {
  Running r;
  r.begin();
  for (double const value : {11.0, 0.5, std::nan(""), HUGE_VAL}) CHECK(r.set(rate, value) == Answer::error);
  CHECK(r.set(sum, 1.0) == Answer::error);
  CHECK(r.set(mass, 1.0) == Answer::error);
  for (unsigned const reference : {0u, 4u, ~0u}) CHECK(r.set(reference, 1.0) == Answer::error);
  unsigned const both[] = {rate, sum};
  double const values[] = {3.0, 3.0};
  CHECK(r.fmu.set(both, 2, values) == Answer::error);
  CHECK(r.get(rate) == 2.0);
  CHECK(r.fmu.set(static_cast<unsigned const*>(nullptr), 1, values) == Answer::error);
  double out = 0.0;
  unsigned const beyond = 4;
  CHECK(r.fmu.get(&beyond, 1, &out) == Answer::error);
  CHECK(r.told.lines.size() == 12);
}

TEST_CASE("steps that do not join, run backwards or pass the stop time are refused") {
  Running r;
  CHECK(r.fmu.setup(0.0, true, 1.0) == Answer::ok);
  CHECK(r.fmu.enter_initialization() == Answer::ok);
  CHECK(r.plant->end == 1.0);
  CHECK(r.fmu.step(0.0, 0.5) == Answer::error);
  CHECK(r.fmu.exit_initialization() == Answer::ok);
  CHECK(r.fmu.step(0.1, 0.5) == Answer::error);
  for (double const length : {0.0, -0.1, std::nan(""), 1.5}) CHECK(r.fmu.step(0.0, length) == Answer::error);
  double time = 0.0;
  for (int i = 0; i < 10; ++i, time += 0.1) CHECK(r.fmu.step(time, 0.1) == Answer::ok);  // 0.1 adds up to 0.9999...
  CHECK(r.fmu.step(time, 0.1) == Answer::error);
}

TEST_CASE("a step longer than a day, or lost in the round-off of the time, is refused") {
  Running r;
  r.begin();
  for (double const length : {1e300, 86401.0, HUGE_VAL}) CHECK(r.fmu.step(0.0, length) == Answer::error);
  CHECK(r.fmu.step(0.0, 86400.0) == Answer::ok);
  Running late;
  late.begin(1e18);
  CHECK(late.fmu.step(1e18, 0.01) == Answer::error);
  REQUIRE(late.told.lines.size() == 1);
  CHECK(late.told.lines[0] == "fmi2DoStep: at 1e+18 s a step of 0.01 s is lost in round-off");
  CHECK(late.fmu.time() == 1e18);
}

TEST_CASE("setups that cannot be, and a start that fails, are errors") {
  Running r;
  CHECK(r.fmu.setup(std::nan(""), false, 0.0) == Answer::error);
  CHECK(r.fmu.setup(1.0, true, 1.0) == Answer::error);
  CHECK(r.fmu.exit_initialization() == Answer::error);
  r.plant->starts = Status::not_finite;
  CHECK(r.fmu.enter_initialization() == Answer::error);
  CHECK(r.fmu.phase() == instantiated);
}
