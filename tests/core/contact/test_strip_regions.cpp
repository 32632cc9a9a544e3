// Interpenetration regions against an exhaustive scan; regions side by side in lanes against one after the other.
#include <doctest/doctest.h>

#include "contact/strip_wheel.hpp"

using namespace rollerrig;
using test::loaded_poses;
using test::sanitized;
using test::some_of;
using test::steel;
using test::Wheel;

namespace {

/// Lowest height of a circle of the wheel over the other surface, by halving: no normals, no slopes.
double lowest_height(WheelRollerPair const& pair, RelativePose<double> const& pose, double s) {
  double const r = pair.wheel_radius + pair.wheel->at(s).value, y_r = pair.tape_circle_y + s;
  double const kappa = pair.inverse_radius;
  auto const height = [&](double angle) {
    auto const p = pose.o + pose.R * Vec3<double>{r * std::sin(angle), y_r, -r * std::cos(angle)};
    double const y = p.y - pair.rail_origin_y;
    if (!pair.rail->contains(y)) return 1.0;
    double const radial = kappa > 0.0 ? std::hypot(p.x, p.z + 1.0 / kappa) - 1.0 / kappa : p.z;
    return radial - pair.rail->at(y).value;
  };
  double low = -0.2, high = 0.2;
  for (int i = 0; i < 80; ++i) {
    double const a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
    (height(a) < height(b) ? high : low) = height(a) < height(b) ? b : a;
  }
  return height(0.5 * (low + high));
}

}  // namespace

TEST_CASE("regions are all that an exhaustive scan of fine steps finds, thin ones too") {
  int regions = 0, thin = 0;
  for (double inverse_radius : {0.0, 2.0}) {
    Wheel const wheel(inverse_radius);
    auto const& arc = wheel.nodes.arc();
    double const end = arc.length(wheel.profiles.wheel.end()), step = 20e-6;
    for (auto const& pose : loaded_poses(wheel, some_of(150), 5, 20e-3)) {
      auto const scan = scan_gap(wheel.profiles.pair, wheel.nodes, pose);
      std::vector<std::array<double, 2>> expected;
      bool inside = false;
      double lowest = 0.0;
      std::vector<double> depth;
      for (double l = 0.0; l < end; l += step) {
        double const height = lowest_height(wheel.profiles.pair, pose, arc.abscissa(l));
        bool const now = height < 0.0;
        if (now && !inside) expected.push_back({l, l}), lowest = 0.0;
        if (now) expected.back()[1] = l, lowest = std::min(lowest, height);
        if (!now && inside) depth.push_back(-lowest);
        inside = now;
      }
      // Overlaps of nanometres come and go with the step of either scan.
      std::size_t found = 0;
      for (std::size_t k = 0; k < depth.size(); ++k) {
        if (depth[k] < 5e-9) continue;
        ++regions;
        thin += expected[k][1] - expected[k][0] < 1e-3;
        bool matched = false;
        for (int i = 0; i < scan.regions; ++i) {
          RegionPack<double> pack;
          test::put(wheel, pose, scan.region[static_cast<std::size_t>(i)], pack);
          auto const ends = strip_detail::ends_of(pack);  // as strips polish them
          matched =
              matched || (std::abs(ends[0] - expected[k][0]) < 60e-6 && std::abs(ends[1] - expected[k][1]) < 60e-6);
        }
        CAPTURE(expected[k][0]);
        CAPTURE(expected[k][1]);
        CHECK(matched);
        found += matched;
      }
      CHECK(found + 1 > static_cast<std::size_t>(scan.regions));
    }
  }
  if (sanitized) return;
  CHECK(regions > 300);
  CHECK(thin > 3);
}

TEST_CASE("the lowest point of a circle is found on the profile where its first guess lies beyond the end") {
  int beyond = 0, on_it = 0;
  for (double inverse_radius : {0.0, 2.0}) {
    Wheel const wheel(inverse_radius);
    auto const& arc = wheel.nodes.arc();
    LanePair<double> pair;
    pair.set_all(wheel.profiles.pair, arc.abscissae());
    for (auto const& pose : loaded_poses(wheel, 300, 5, 40e-3)) {
      for (double l = 22e-3; l < 30e-3; l += 0.1e-3) {
        double const height = lowest_height(wheel.profiles.pair, pose, arc.abscissa(l));
        if (std::abs(height) > 0.1e-3) continue;
        auto const circle = wheel_circle(pair, pose, arc.abscissa(l));
        auto const [sine, cosine] = facing_angle(pair, pose, circle);
        bool const first = circle_point(pair, pose, circle, sine, cosine).found;
        std::array<CirclePoint<double>, 1> at;
        lowest_points(pair, pose, std::array{arc.abscissa(l)}, at);
        // Places that only leave the profile between the angles of the exhaustive search are not of this test.
        if (at[0].rail_y < wheel.profiles.rail.start + 0.1e-3) continue;
        CHECK(at[0].found);
        CHECK(at[0].gap == doctest::Approx(height * at[0].n.z).epsilon(0.05));
        ++on_it;
        beyond += !first;
      }
    }
  }
  CHECK(beyond > 5);
  CHECK(on_it > 1000);
}

TEST_CASE("lanes and width 1 agree to round-off, and wheels do not see each other") {
  for (double inverse_radius : {0.0, 2.0}) {
    Wheel const wheel(inverse_radius);
    std::vector<StripWheel<double>> wheels;
    for (auto const& pose : loaded_poses(wheel, 40, 11, 30e-3)) wheels.push_back({&wheel.setting, pose, {}});
    auto one = wheels;
    strip_contacts<double>(wheels);
    strip_contacts<double, 1>(one);
    for (std::size_t i = 0; i < wheels.size(); ++i) {
      REQUIRE(wheels[i].found.count == one[i].found.count);
      auto const alone = strip_contact(wheel.setting, one[i].pose);
      for (std::size_t k = 0; k < static_cast<std::size_t>(one[i].found.count); ++k) {
        auto const &a = wheels[i].found.patch[k], &b = one[i].found.patch[k], &c = alone.patch[k];
        CHECK(a.normal == doctest::Approx(b.normal).epsilon(1e-9));
        CHECK(a.normal == doctest::Approx(c.normal).epsilon(1e-9));
        CHECK(a.a == doctest::Approx(b.a).epsilon(1e-9));
        CHECK(a.b == doctest::Approx(b.b).epsilon(1e-9));
        CHECK(a.point.y == doctest::Approx(b.point.y).epsilon(1e-12));
      }
    }
  }
}
