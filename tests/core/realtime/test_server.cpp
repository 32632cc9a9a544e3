// The server's loop against a plant, a controller and a clock of the test's own.
#include <doctest/doctest.h>

#include <memory>

#include "realtime/rig.hpp"

using namespace rollerrig::realtime;
using namespace rollerrig::test;

namespace {

using TestServer = Server<SummingPlant, WiredPort, JumpingClock>;

struct Bench {
  SummingPlant plant;
  WiredPort port;
  JumpingClock clock;
  std::unique_ptr<TestServer> server;

  TestServer& serve(ServerSettings settings) {
    settings.session = session;
    server = std::make_unique<TestServer>(plant, port, clock, two_inputs(), std::string(1500, 'x'), settings);
    return *server;
  }
};

/// Answers every frame of sensors with the same command, as long as it is told to.
auto steady(std::vector<double> values, std::uint32_t from = 0, std::uint32_t until = 0xffffffffu) {
  return [=, sequence = 0u](WiredPort& port, Frame const& frame) mutable {
    Heard const h = heard(frame);
    if (h.header.kind != RR_SENSORS || h.header.state == RR_ENDED) return;
    if (h.header.sequence < from || h.header.sequence > until) return;
    port.inbox.emplace_back(command(++sequence, h.header.sequence, values), us);
  };
}

ServerSettings of(int periods) {
  ServerSettings settings;
  settings.periods = periods;
  return settings;
}

}  // namespace

TEST_CASE("a command acts on the period after the sensors that it answers were sent") {
  Bench bench;
  bench.port.inbox.emplace_back(asking(), us);
  bench.port.controller = steady({1.0, 2.0});
  TestServer& server = bench.serve(of(100));
  CHECK(server.run() == Ending::ran);
  CHECK(bench.plant.steps == 100);
  CHECK(bench.plant.sum == 100.0);
  CHECK(server.statistics().misses.get() == 0);
  CHECK(server.statistics().waited.get() == 1);  // the controller asked in the first period
  CHECK(server.statistics().step.count() == 100);
  CHECK(server.gate().counted(Verdict::accepted) == 100);
  Heard const last = heard(bench.port.sent.back());
  CHECK(last.header.state == RR_ENDED);
  CHECK(last.header.time_ns == 100'000'000);
  CHECK(last.values[0] == 100.0);
}

TEST_CASE("the description comes in parts to whoever asks first; another one is told that the rig is taken") {
  Bench bench;
  bench.port.inbox.emplace_back(asking(0), us);
  bench.port.inbox.emplace_back(asking(1), us);
  bench.port.inbox.emplace_back(asking(2), us);  // there are two
  bench.port.inbox.emplace_back(asking(0), somebody);
  bench.port.controller = steady({0.0, 0.0});
  bench.serve(of(3)).run();
  std::vector<std::pair<std::size_t, std::uint32_t>> parts;
  for (Frame const& frame : bench.port.sent) {
    rr_header header;
    REQUIRE(rr_open(frame.data(), frame.size(), &header) == RR_OK);
    if (header.kind == RR_DESCRIPTION) parts.emplace_back(header.count, header.answers);
  }
  CHECK(parts == std::vector<std::pair<std::size_t, std::uint32_t>>{{1024, 2}, {476, 2}, {0, 0}});
  CHECK(bench.server->gate().counted(Verdict::refused) == 1);
}

TEST_CASE(
    "a silent controller: what acts goes to the safe state on a ramp, and stays there until it is asked for again") {
  Bench bench;
  bench.port.inbox.emplace_back(asking(), us);
  auto first = steady({8.0, 1.0}, 0, 20);
  auto again = steady({4.0, 0.0}, 61);
  bench.port.controller = [=](WiredPort& port, Frame const& frame) mutable {
    first(port, frame);
    if (heard(frame).header.sequence > 60) {
      again(port, frame);  // counts its frames anew: reordered until it is past the first one
    }
  };
  ServerSettings settings = of(200);
  settings.patience = 5, settings.ramp = 4;
  settings.record = true;
  TestServer& server = bench.serve(settings);
  CHECK(server.run() == Ending::ran);
  auto const& record = server.recorded();
  auto const acting = [&](std::size_t k, std::size_t i) { return record.commands[2 * k + i]; };
  std::size_t k = 0;
  while (acting(k, 0) == 8.0) ++k;
  CHECK(acting(k, 0) == 6.0);  // a quarter of the way from 8 to 0
  CHECK(acting(k, 1) == 2.0);  // a valve has nothing between
  CHECK(acting(k + 1, 0) == 4.0);
  CHECK(acting(k + 3, 0) == 0.0);
  CHECK(acting(k + 100, 0) == 0.0);  // though commands come again
  CHECK(server.statistics().state.load() == RR_ENDED);
  CHECK(server.statistics().trips.get() == 1);
  CHECK(server.gate().counted(Verdict::reordered) > 0);
  CHECK(server.gate().counted(Verdict::accepted) > 20);
  bool told = false;
  for (Frame const& frame : bench.port.sent) told = told || heard(frame).header.state == RR_SAFE;
  CHECK(told);
}

TEST_CASE("RR_REARM takes the rig up again") {
  Watchdog dog(two_inputs(), 2, 0);
  std::vector<double> const command{5.0, 1.0};
  CHECK(dog.step({}, false)[1] == 1.0);
  CHECK(dog.state() == Watchdog::waiting);  // it has never heard anything
  dog.step(command, false);
  dog.step({}, false);
  CHECK(dog.state() == Watchdog::running);
  CHECK(dog.step({}, false)[0] == 0.0);
  CHECK(dog.state() == Watchdog::safe);
  CHECK(dog.step(command, false)[0] == 0.0);
  CHECK(dog.step(command, true)[0] == 5.0);
  CHECK(dog.state() == Watchdog::running);
}

TEST_CASE("lock-step: each step waits for its own command") {
  Bench bench;
  ServerSettings settings = of(50);
  settings.lock_step = true;
  bench.port.inbox.emplace_back(asking(1), us);  // its last part: sensors follow
  bench.port.controller = [sequence = 0u](WiredPort& port, Frame const& frame) mutable {
    Heard const h = heard(frame);
    if (h.header.kind != RR_SENSORS || h.header.state == RR_ENDED) return;
    if (h.header.sequence > 1) port.inbox.emplace_back(command(++sequence, h.header.sequence - 1, {9.0, 0.0}), us);
    port.inbox.emplace_back(command(++sequence, h.header.sequence, {h.values[0] == 0.0 ? 1.0 : -1.0, 0.0}), us);
  };
  TestServer& server = bench.serve(settings);
  CHECK(server.run() == Ending::ran);
  CHECK(bench.plant.steps == 50);
  CHECK(bench.plant.sum == 0.0);
  CHECK(server.gate().counted(Verdict::late) == 49);
  CHECK(server.statistics().misses.get() == 0);
}

TEST_CASE("lock-step: a controller that falls silent ends the run") {
  Bench bench;
  ServerSettings settings = of(50);
  settings.lock_step = true;
  bench.port.inbox.emplace_back(asking(1), us);
  bench.port.controller = steady({1.0, 0.0}, 0, 10);
  bench.clock.at_a_look = 1'000'000;
  CHECK(bench.serve(settings).run() == Ending::controller_silent);
  CHECK(bench.plant.steps == 10);
}

TEST_CASE("misses are counted, deadlines that have passed are given up") {
  Bench bench;
  bench.clock.at_a_look = 900'000;  // three looks in a period of 1 ms
  ServerSettings settings = of(20);
  settings.at_once = true;
  TestServer& server = bench.serve(settings);
  CHECK(server.run() == Ending::ran);
  CHECK(server.statistics().misses.get() == 20);
  CHECK(server.statistics().skipped.get() > 0);
}

TEST_CASE("the plant's end ends the run") {
  Bench bench;
  bench.plant.last = 7;
  ServerSettings settings = of(20);
  settings.at_once = true;
  CHECK(bench.serve(settings).run() == Ending::plant_ended);
  CHECK(bench.plant.steps == 7);
}

TEST_CASE("histogram: quantiles within 1/32, the largest exactly") {
  Histogram histogram;
  CHECK(histogram.quantile(0.5) == 0);
  for (int i = 1; i <= 100'000; ++i) histogram.add(i);
  for (double const q : {0.001, 0.01, 0.5, 0.99, 0.9999}) {
    double const exact = 100'000 * q;
    CHECK(static_cast<double>(histogram.quantile(q)) >= exact);
    CHECK(static_cast<double>(histogram.quantile(q)) <= exact * (1.0 + 1.0 / 32) + 1.0);
  }
  CHECK(histogram.quantile(1.0) == 100'000);
  CHECK(histogram.largest() == 100'000);
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < Histogram::bins(); ++i) {
    sum += histogram.in_bin(i);
    if (i > 0) CHECK(Histogram::upper_edge(i) > Histogram::upper_edge(i - 1));
  }
  CHECK(sum == 100'000);
  histogram.add(-5);
  histogram.add(std::int64_t{1} << 60);
  CHECK(histogram.count() == 100'002);
  CHECK(histogram.largest() == (std::uint64_t{1} << 40) - 1);
}
