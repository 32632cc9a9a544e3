// Few strips against many, at thousands of random poses, by the worst; regions that have not settled are solved again.
#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "contact/strip_wheel.hpp"
#include "rollerrig/contact/normal/strip_patch.hpp"
#include "rollerrig/geometry/gap_nodes.hpp"

using namespace rollerrig;
using test::loaded_poses;
using test::Wheel;

namespace {

struct Solved {
  double force, peak_pressure, change;
};

/// A region by itself with n strips.
template <std::size_t n>
Solved solved(Wheel const& wheel, RelativePose<double> const& pose, InterpenetrationRegion const& region, int passes) {
  RegionPack<double> pack;
  test::put(wheel, pose, region, pack);
  Strips<double, n> strips;
  StripPlaces<double, n> places;
  lay_strips(strip_tables(), pack, strips, places);
  solve_strips(strip_tables(), strips, passes);
  StripRow<double, n> share;
  share.fill(1.0);
  auto const part = part_of(strip_tables(), strips, places, share);
  return {part.normal, part.peak_pressure, std::abs(strips.change)};
}

/// As a wheel gets it: with few strips, and with many as far as these have not settled.
Solved shipped(Wheel const& wheel, RelativePose<double> const& pose, InterpenetrationRegion const& region) {
  auto const few = solved<strip_count>(wheel, pose, region, strip_passes);
  if (!(few.change > 0.01)) return few;
  auto const many = solved<20>(wheel, pose, region, 8);
  double const s = strip_detail::smooth_step(std::min(1.0, (few.change - 0.01) / 0.01));
  return {few.force + s * (many.force - few.force), few.peak_pressure + s * (many.peak_pressure - few.peak_pressure),
          few.change};
}

double force_of(StripSolution<double> const& found) {
  double sum = 0.0;
  for (int k = 0; k < found.count; ++k) {
    auto const& patch = found.patch[static_cast<std::size_t>(k)];
    sum += patch.weight * patch.normal;
  }
  return sum;
}

/// The part of the values that is not above.
double quantile(std::vector<double> values, double part) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
}

}  // namespace

TEST_CASE("a few strips carry what many carry, at any pose on tread and flange") {
  for (double inverse_radius : {0.0, 1.0 / 0.725, 1.0 / 0.3}) {
    Wheel const wheel(inverse_radius);
    std::vector<double> force, peak;
    int flange = 0;
    for (auto const& pose : loaded_poses(wheel, 1000, 11, 40e-3)) {
      auto const scan = scan_gap(wheel.profiles.pair, wheel.nodes, pose);
      for (int k = 0; k < scan.regions; ++k) {
        auto const& region = scan.region[static_cast<std::size_t>(k)];
        auto const few = shipped(wheel, pose, region);
        auto const many = solved<48>(wheel, pose, region, 16);
        if (many.force < 500.0) continue;
        flange += wheel.nodes.arc().abscissa(region.right.position) < -26e-3;
        force.push_back(std::abs(few.force / many.force - 1.0));
        peak.push_back(std::abs(few.peak_pressure / many.peak_pressure - 1.0));
      }
    }
    REQUIRE(force.size() > 1000);
    REQUIRE(flange > 100);
    CAPTURE(inverse_radius);
    MESSAGE(inverse_radius, ": ", force.size(), " regions, ", flange, " on the flange; force ", quantile(force, 0.5),
            " ", quantile(force, 0.99), " ", quantile(force, 1.0), ", peak pressure ", quantile(peak, 0.5), " ",
            quantile(peak, 0.99), " ", quantile(peak, 1.0));
    // Asked is 3 % of the force at the worst pose. Measured, rail, 725 and 300 mm: 0.0028, 0.0030, 0.0032 in the median, 0.019,
    // 0.018, 0.016 at 99 %, 0.021, 0.019, 0.023 at the worst; peak pressure up to 0.0048, 0.048, 0.26. Sixteen strips: 0.0018,
    // 0.011, 0.016; 0.002, 0.031, 0.20. Against the exact half-space twelve are no worse: test_half_space_pairs.py.
    CHECK(quantile(force, 0.5) < 4e-3);
    CHECK(quantile(force, 0.99) < 0.022);
    CHECK(quantile(force, 1.0) < 0.03);
    CHECK(quantile(peak, 0.5) < 6e-3);
    CHECK(quantile(peak, 0.99) < 0.06);
    CHECK(quantile(peak, 1.0) < 0.3);
  }
}

TEST_CASE("a region that has not settled is solved again with many strips, and counted") {
  Wheel const wheel(0.0);
  int refined = 0, alone = 0;
  for (auto const& pose : loaded_poses(wheel, 3000, 12, 60e-3)) {
    auto const found = strip_contact(wheel.setting, pose);
    refined += found.refined;
    for (int k = 0; k < found.count; ++k) {
      auto const& direction = found.patch[static_cast<std::size_t>(k)].direction;
      CHECK(dot(direction, direction) == doctest::Approx(1.0).epsilon(1e-14));
    }
    auto const scan = scan_gap(wheel.profiles.pair, wheel.nodes, pose);
    if (scan.minima != 1) continue;
    auto const few = solved<strip_count>(wheel, pose, scan.region[0], strip_passes);
    CHECK((few.change > 0.01) == (found.refined == 1));
    if (found.refined != 1 || found.count != 1) continue;
    ++alone;
    double const many = solved<20>(wheel, pose, scan.region[0], 8).force;
    double const s = strip_detail::smooth_step(std::min(1.0, (few.change - 0.01) / 0.01));
    CHECK(force_of(found) == doctest::Approx(few.force + s * (many - few.force)).epsilon(1e-9));
  }
  CHECK(refined > 0);
  CHECK(alone > 0);
}
