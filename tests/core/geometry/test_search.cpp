// Every root is found: cells against a brute-force scan, the warm search against the exhaustive one along motions.
#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "profiles.hpp"
#include "rollerrig/geometry/search.hpp"

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
  double const step = 0.02e-3;
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

void compare(ContactSearch const& search, std::vector<Found> const& expected, double edge) {
  // A minimum whose gap is within `edge` of the reach may fall on either side of it.
  std::size_t k = 0;
  for (int i = 0; i < search.count(); ++i) {
    while (k < expected.size() && expected[k].s < search[i].s - 1e-9) ++k;
    bool const same = k < expected.size() && std::abs(expected[k].s - search[i].s) < 1e-9;
    CHECK((same || search[i].gap > -edge));
    if (same) CHECK(std::abs(expected[k].gap - search[i].gap) < 1e-12);
  }
  CHECK(static_cast<std::size_t>(search.count()) >= expected.size());
}

}  // namespace

TEST_CASE("the cells find every minimum that a fine scan finds, at random poses with flange contact") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int several = 0, minima = 0;
  for (double inverse_radius : {0.0, 1.0 / 0.725}) {
    BenchmarkPair const benchmark(inverse_radius);
    ContactSearch search(benchmark.pair);
    for (int i = 0; i < 120; ++i) {
      double const yaw = (i % 3 == 0 ? 50e-3 : 5e-3) * any(random);
      auto const pose =
          pose_of(5e-3 * any(random), 8.5e-3 * any(random), 0.46 + 1e-3 * any(random), 5e-3 * any(random), yaw);
      double const reach = 1e-3;
      auto const expected = brute_force(benchmark.pair, pose, reach);
      search.find_all(pose, reach);
      CAPTURE(i);
      compare(search, expected, 1e-3 - 1e-9);
      CHECK(static_cast<std::size_t>(search.count()) == expected.size());
      several += expected.size() > 1;
      minima += static_cast<int>(expected.size());
    }
  }
  CHECK(several > 20);
  CHECK(minima > 150);
}

TEST_CASE("minima come in order and each is a minimum") {
  BenchmarkPair const benchmark(0.0);
  ContactSearch search(benchmark.pair);
  search.find_all(pose_of(0.0, 0.0, 0.4597, 0.0, 0.0), 1e-2);
  REQUIRE(search.count() >= 2);
  for (int i = 0; i < search.count(); ++i) {
    CHECK(search[i].gradient < 0.0);
    if (i > 0) CHECK(search[i - 1].s < search[i].s);
  }
}

TEST_CASE("between two minima stands the maximum of the gap") {
  BenchmarkPair const benchmark(0.0);
  ContactSearch search(benchmark.pair);
  auto const pose = pose_of(0.0, 0.0, 0.45975, 0.0, 0.0);
  REQUIRE(search.find_all(pose, 0.0) == 2);
  auto const& top = search.barrier(0);
  CHECK(top.s > search[0].s);
  CHECK(top.s < search[1].s);
  CHECK(top.gradient > 0.0);
  double highest = -1.0;
  for (double s = search[0].s; s < search[1].s; s += 1e-6)
    highest = std::max(highest, reduce(benchmark.pair, pose, s).gap);
  CHECK(top.gap == doctest::Approx(highest).epsilon(1e-6));  // the scan misses the top by up to 0.5 um
}

TEST_CASE("a wheel high above the rail has no contact, and nothing is found twice") {
  BenchmarkPair const benchmark(1.0 / 0.725);
  ContactSearch search(benchmark.pair);
  CHECK(search.find_all(pose_of(0.0, 0.0, 0.5, 0.0, 0.0), 0.0) == 0);
  CHECK(search.find_indented(pose_of(0.0, 0.0, 0.5, 0.0, 0.0)) == 0);
  CHECK(search.find_indented(pose_of(0.0, 0.003, 0.4597, 0.0, 0.0)) == 1);
}

TEST_CASE("steep flange contact near the end of the rail's table is found") {
  // The wheel's normals in the same cell miss the table beside it: such a cell must be searched as far as it is valid.
  BenchmarkPair const benchmark(0.0);
  ContactSearch search(benchmark.pair);
  auto const expected = brute_force(benchmark.pair, pose_of(0.0, 7.5e-3, 0.46331, 0.0, 0.0), 1e-3);
  REQUIRE(expected.size() == 1);
  REQUIRE(search.find_all(pose_of(0.0, 7.5e-3, 0.46331, 0.0, 0.0), 1e-3) == 1);
  CHECK(search[0].s == doctest::Approx(expected[0].s).epsilon(1e-8));
}

namespace {

/// Hunting with growing amplitude: slow weave, bounce and yaw at wheel loads, into the flange and off the rail.
RelativePose<double> hunting(double t) {
  double const amplitude = 8.2e-3 * std::min(1.0, 0.05 + t);
  double const y = amplitude * std::sin(2 * pi * 5.0 * t);
  double const yaw = 4e-3 * std::cos(2 * pi * 5.0 * t) * std::min(1.0, t);
  double const z = 0.4598 + 0.15e-3 * std::sin(2 * pi * 31.0 * t) + (std::abs(y) > 6e-3 ? 60.0 * (y * y - 36e-6) : 0.0);
  return pose_of(1e-4 * std::sin(2 * pi * 13.0 * t), y, z, 0.5e-3 * std::sin(2 * pi * 7.0 * t), yaw);
}

void along(BenchmarkPair const& benchmark, std::vector<RelativePose<double>> const& poses, int& minima, int& changes) {
  ContactSearch warm(benchmark.pair), exhaustive(benchmark.pair);
  int last = -1;
  for (auto const& pose : poses) {
    warm.find_indented(pose);
    exhaustive.find_all(pose, 0.0);
    REQUIRE(warm.count() == exhaustive.count());
    for (int k = 0; k < warm.count(); ++k) {
      // Both polish to 1e-14 m, from different starts; a root of slope 1 per metre is known to 1e-12.
      CHECK(std::abs(warm[k].s - exhaustive[k].s) < 1e-11);
      CHECK(std::abs(warm[k].gap - exhaustive[k].gap) < 1e-14);
    }
    changes += warm.count() != last;
    last = warm.count();
    minima += warm.count();
  }
}

}  // namespace

TEST_CASE("the warm search finds what the exhaustive one finds along a hunting motion, at any step") {
  for (double inverse_radius : {0.0, 1.0 / 0.725}) {
    BenchmarkPair const benchmark(inverse_radius);
    for (double step : {20e-6, 0.2e-3, 3e-3}) {
      std::vector<RelativePose<double>> poses;
      double const duration = step < 1e-4 ? 0.25 : 2.0;
      for (double t = 0.0; t < duration; t += step) poses.push_back(hunting(t + (step < 1e-4 ? 0.8 : 0.0)));
      int minima = 0, changes = 0;
      along(benchmark, poses, minima, changes);
      CHECK(minima > 100);
      CHECK(changes > 5);
    }
  }
}

TEST_CASE("the warm search survives jumps to any other pose and back") {
  BenchmarkPair const benchmark(1.0 / 0.725);
  std::mt19937 random(13);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::vector<RelativePose<double>> poses;
  for (int i = 0; i < 400; ++i) {
    auto const pose = pose_of(5e-3 * any(random), 8e-3 * any(random), 0.4599 + 5e-4 * any(random), 4e-3 * any(random),
                              20e-3 * any(random));
    for (int again = 0; again < 1 + i % 3; ++again) poses.push_back(pose);
    if (i % 5 == 0) poses.push_back(hunting(0.01 * i));
  }
  int minima = 0, changes = 0;
  along(benchmark, poses, minima, changes);
  CHECK(minima > 200);
}

TEST_CASE("the warm search survives slow walks in every direction, near the limit of what it may leave alone") {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int minima = 0, changes = 0;
  for (double inverse_radius : {0.0, 1.0 / 0.725, 1.0 / 0.3}) {
    BenchmarkPair const benchmark(inverse_radius);
    for (int walk = 0; walk < 40; ++walk) {
      double const yaw = (walk % 2 == 0 ? 50e-3 : 5e-3) * any(random);
      double q[5] = {10e-3 * any(random), 7.5e-3 * any(random), 0.0, 3e-3 * any(random), yaw};
      // Start where the deepest point of the wheel is a little in the rail.
      ContactSearch start(benchmark.pair);
      start.find_all(pose_of(q[0], q[1], 0.461, q[3], q[4]), 2e-2);
      if (start.count() == 0) continue;
      double gap = 1.0;
      for (int k = 0; k < start.count(); ++k) gap = std::min(gap, start[k].gap);
      q[2] = 0.461 - gap - 0.05e-3;
      // One direction for a while, then another; each coordinate also alone.
      double const size[5] = {2e-4, 4e-6, 2e-6, 8e-6, 2e-5};
      double direction[5] = {};
      std::vector<RelativePose<double>> poses;
      for (int i = 0; i < 250; ++i) {
        if (i % 50 == 0)
          for (int c = 0; c < 5; ++c) direction[c] = (i / 50 == c || i == 0 ? 1.0 : 0.2 * (walk % 3)) * any(random);
        for (int c = 0; c < 5; ++c) q[c] += direction[c] * size[c];
        poses.push_back(pose_of(q[0], q[1], q[2], q[3], q[4]));
      }
      along(benchmark, poses, minima, changes);
    }
  }
  CHECK(minima > 10000);
  CHECK(changes > 200);
}

TEST_CASE("the warm search needs a fraction of the exhaustive one's evaluations") {
  BenchmarkPair const benchmark(1.0 / 0.725);
  ContactSearch warm(benchmark.pair), exhaustive(benchmark.pair);
  for (double t = 0.0; t < 0.1; t += 1e-4) {
    warm.find_indented(hunting(t));
    exhaustive.find_all(hunting(t), 0.0);
  }
  CHECK(warm.node_evaluations() < exhaustive.node_evaluations() / 10);
}
