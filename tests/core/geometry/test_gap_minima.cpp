// Every minimum of the gap is found: the search on the nodes against a brute-force scan, in poses of all kinds.
#include "rollerrig/geometry/gap_nodes.hpp"

#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "profiles.hpp"

using namespace rollerrig;
using test::BenchmarkPair;
using test::pose_of;

namespace {

struct Found {
  double s, gap;
};

/// Minima of the gap by a scan in steps of 0.02 mm and bisection; slow and simple.
std::vector<Found> brute_force(WheelRollerPair const& pair, RelativePose<double> const& pose, double reach) {
  std::vector<Found> list;
  double const step = 0.02e-3 * pair.size;
  auto const f = [&](double s, bool& valid) {
    auto const at = reduce(pair, pose, s);
    valid = at.rail_point.found;
    return at.residual;
  };
  bool last_valid = false;
  double last = 0.0, last_s = 0.0;
  for (double s = pair.wheel->start; s <= pair.wheel->end() + 1e-12; s += step) {
    bool valid = false;
    double const value = f(s, valid);
    if (valid && last_valid && last > 0.0 && value <= 0.0) {
      double low = last_s, high = s;
      for (int i = 0; i < 60; ++i) {
        bool ignored = false;
        double const middle = 0.5 * (low + high);
        (f(middle, ignored) > 0.0 ? low : high) = middle;
      }
      double const gap = reduce(pair, pose, low).gap;
      if (gap < reach) list.push_back({low, gap});
    }
    last_valid = valid, last = value, last_s = s;
  }
  return list;
}

/// What a comparison has seen.
struct Tally {
  int poses{0}, minima{0}, several{0}, flange{0};
};

/// Every minimum of the brute-force scan must be there, at the same place, and none beside them.
void compare(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose, double reach,
             Tally& tally) {
  auto const expected = brute_force(pair, pose, reach);
  auto const found = find_minima(pair, nodes, pose, reach);
  ++tally.poses, tally.minima += static_cast<int>(expected.size()), tally.several += expected.size() > 1;
  CAPTURE(tally.poses);
  std::size_t matched = 0;
  for (auto const& e : expected) {
    tally.flange += std::abs(pair.wheel->at(e.s).slope) > 0.7;
    CAPTURE(e.s);
    CAPTURE(e.gap);
    bool there = false;
    for (std::size_t k = 0; k < found.count; ++k) {
      // Round-off of F, 1e-14, over its least slope at which a minimum is 0.02 mm from the maximum beside it.
      if (!(std::abs(found.minimum[k].s - e.s) < 1e-9)) continue;
      there = true;
      CHECK(std::abs(found.minimum[k].gap - e.gap) < 1e-13);
    }
    CHECK(there);
    matched += there;
  }
  // Closer together than the scan's step it sees neither of a minimum and a maximum: the search may.
  CHECK(found.count <= matched + 1);
}

/// The wheel lowered until it overlaps by `depth` at most.
RelativePose<double> lowered(WheelRollerPair const& pair, GapNodes const& nodes, double x, double y, double roll,
                             double yaw, double depth) {
  double low = pair.wheel_radius - 0.02 * pair.size, high = pair.wheel_radius + 0.03 * pair.size;
  for (int i = 0; i < 40; ++i) {
    double const middle = 0.5 * (low + high);
    (scan_gap(pair, nodes, pose_of(x, y, middle, roll, yaw)).regions > 0 ? low : high) = middle;
  }
  return pose_of(x, y, low - depth, roll, yaw);
}

}  // namespace

TEST_CASE("every minimum that a fine scan finds is found in poses under load, tread to flange, yaw to 50 mrad") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (double inverse_radius : {0.0, 1.0 / 0.725, 1.0 / 0.3}) {
    BenchmarkPair const benchmark(inverse_radius);
    GapNodes const nodes(benchmark.wheel, 1.0);
    Tally tally;
    for (int i = 0; i < 600; ++i) {
      double const yaw = (i % 3 == 0 ? 50e-3 : 5e-3) * any(random);
      double const x = 5e-3 * any(random), y = 8.5e-3 * any(random), roll = 5e-3 * any(random);
      compare(benchmark.pair, nodes, lowered(benchmark.pair, nodes, x, y, roll, yaw, 170e-6 * (1.0 + any(random))), 0.0,
              tally);
    }
    CHECK(tally.minima > 500);
    CHECK(tally.several > 30);
    CHECK(tally.flange > 50);
  }
}

TEST_CASE("every minimum that a fine scan finds within a millimetre of the other surface is found") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  Tally tally;
  for (double inverse_radius : {0.0, 1.0 / 0.725}) {
    BenchmarkPair const benchmark(inverse_radius);
    GapNodes const nodes(benchmark.wheel, 1.0);
    for (int i = 0; i < 240; ++i) {
      double const yaw = (i % 3 == 0 ? 50e-3 : 5e-3) * any(random);
      auto const pose =
          pose_of(5e-3 * any(random), 8.5e-3 * any(random), 0.46 + 1e-3 * any(random), 5e-3 * any(random), yaw);
      compare(benchmark.pair, nodes, pose, 1e-3, tally);
    }
  }
  CHECK(tally.several > 40);
  CHECK(tally.minima > 300);
}

TEST_CASE("a model of a fifth of the size has the same minima in proportion") {
  BenchmarkPair const full(1.0 / 0.725);
  UniformSpline wheel = full.wheel, rail = full.rail;
  for (UniformSpline* spline : {&wheel, &rail}) {
    spline->start *= 0.2, spline->step *= 0.2;
    for (auto& c : spline->pieces) c = {0.2 * c[0], c[1], c[2] / 0.2, c[3] / square(0.2)};
  }
  auto const& p = full.pair;
  WheelRollerPair const pair{
      &wheel, &rail, 0.2 * p.wheel_radius, 0.2 * p.tape_circle_y, 0.2 * p.rail_origin_y, p.inverse_radius / 0.2,
      {},     0.2};
  GapNodes const nodes(full.wheel, 1.0), small_nodes(wheel, 0.2);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  Tally tally;
  for (int i = 0; i < 200; ++i) {
    double const y = 8e-3 * any(random), roll = 5e-3 * any(random), yaw = 20e-3 * any(random);
    auto const pose = lowered(p, nodes, 0.0, y, roll, yaw, 50e-6);
    RelativePose<double> const small{0.2 * pose.o, pose.R};
    auto const here = find_minima(p, nodes, pose), there = find_minima(pair, small_nodes, small);
    REQUIRE(here.count == there.count);
    for (std::size_t k = 0; k < here.count; ++k) CHECK(std::abs(there.minimum[k].s - 0.2 * here.minimum[k].s) < 1e-9);
    compare(pair, small_nodes, small, 0.0, tally);
  }
  CHECK(tally.minima > 150);
}

TEST_CASE("minima come in order and each is a minimum") {
  BenchmarkPair const benchmark(0.0);
  GapNodes const nodes(benchmark.wheel, 1.0);
  auto const found = find_minima(benchmark.pair, nodes, pose_of(0.0, 0.0, 0.4597, 0.0, 0.0), 1e-2);
  REQUIRE(found.count >= 2);
  for (std::size_t i = 0; i < found.count; ++i) {
    CHECK(found.minimum[i].gradient < 0.0);
    if (i > 0) CHECK(found.minimum[i - 1].s < found.minimum[i].s);
  }
}

TEST_CASE("between two minima stands the maximum of the gap") {
  BenchmarkPair const benchmark(0.0);
  GapNodes const nodes(benchmark.wheel, 1.0);
  auto const pose = pose_of(0.0, 0.0, 0.45975, 0.0, 0.0);
  auto const found = find_minima(benchmark.pair, nodes, pose);
  REQUIRE(found.count == 2);
  auto const& top = found.barrier[0];
  CHECK(top.s > found.minimum[0].s);
  CHECK(top.s < found.minimum[1].s);
  CHECK(top.gradient > 0.0);
  double highest = -1.0;
  for (double s = found.minimum[0].s; s < found.minimum[1].s; s += 1e-6)
    highest = std::max(highest, reduce(benchmark.pair, pose, s).gap);
  CHECK(top.gap == doctest::Approx(highest).epsilon(1e-6));  // the scan misses the top by up to 0.5 um
}

TEST_CASE("a wheel high above the rail has no contact") {
  BenchmarkPair const benchmark(1.0 / 0.725);
  GapNodes const nodes(benchmark.wheel, 1.0);
  CHECK(find_minima(benchmark.pair, nodes, pose_of(0.0, 0.0, 0.5, 0.0, 0.0)).count == 0);
  CHECK(find_minima(benchmark.pair, nodes, pose_of(0.0, 0.003, 0.4597, 0.0, 0.0)).count == 1);
}

TEST_CASE("steep flange contact near the end of the rail's table is found") {
  // The wheel's normals in the same millimetre miss the table beside it.
  BenchmarkPair const benchmark(0.0);
  GapNodes const nodes(benchmark.wheel, 1.0);
  auto const pose = pose_of(0.0, 7.5e-3, 0.46331, 0.0, 0.0);
  auto const expected = brute_force(benchmark.pair, pose, 1e-3);
  REQUIRE(expected.size() == 1);
  auto const found = find_minima(benchmark.pair, nodes, pose, 1e-3);
  REQUIRE(found.count == 1);
  CHECK(found.minimum[0].s == doctest::Approx(expected[0].s).epsilon(1e-8));
}

TEST_CASE("every minimum is found along a hunting motion into the flange and off the rail") {
  for (double inverse_radius : {0.0, 1.0 / 0.725}) {
    BenchmarkPair const benchmark(inverse_radius);
    GapNodes const nodes(benchmark.wheel, 1.0);
    Tally tally;
    for (double t = 0.0; t < 2.0; t += 3e-3) {
      double const y = 8.2e-3 * std::min(1.0, 0.05 + t) * std::sin(2 * pi * 5.0 * t);
      double const yaw = 4e-3 * std::cos(2 * pi * 5.0 * t) * std::min(1.0, t);
      double const climb = std::abs(y) > 6e-3 ? 60.0 * (y * y - 36e-6) : 0.0;
      double const z = 0.4598 + 0.15e-3 * std::sin(2 * pi * 31.0 * t) + climb;
      auto const pose = pose_of(1e-4 * std::sin(2 * pi * 13.0 * t), y, z, 0.5e-3 * std::sin(2 * pi * 7.0 * t), yaw);
      compare(benchmark.pair, nodes, pose, 0.0, tally);
    }
    CHECK(tally.minima > 100);
  }
}

TEST_CASE("every minimum is found on walks through the folds where minima appear and vanish") {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int changes = 0;
  Tally tally;
  BenchmarkPair const benchmark(1.0 / 0.725);
  GapNodes const nodes(benchmark.wheel, 1.0);
  for (int walk = 0; walk < 20; ++walk) {
    double const x = 10e-3 * any(random), yaw = (walk % 2 == 0 ? 50e-3 : 5e-3) * any(random);
    double const roll = 3e-3 * any(random), rate = 20e-6 * any(random);
    double y = 7.5e-3 * any(random);
    std::size_t last = 0;
    for (int i = 0; i < 50; ++i, y += rate) {
      auto const pose = lowered(benchmark.pair, nodes, x, y, roll, yaw, 60e-6);
      compare(benchmark.pair, nodes, pose, 0.0, tally);
      std::size_t const now = find_minima(benchmark.pair, nodes, pose).count;
      changes += i > 0 && now != last;
      last = now;
    }
  }
  CHECK(changes > 5);
}
