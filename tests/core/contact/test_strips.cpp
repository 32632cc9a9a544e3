// Non-elliptical contact patches: Hertz as a special case, derivatives, smoothness, and what overlaps is one patch.
#include <doctest/doctest.h>

#include "profiles.hpp"
#include "rollerrig/contact/normal/hertz_ellipses.hpp"
#include "rollerrig/contact/normal/strip_contact.hpp"

using namespace rollerrig;
using test::BenchmarkPair;
using test::pose_of;

namespace {

StripKernel const& kernel = strip_kernel();
Material const steel{};

/// Strips over the interpenetration of two bodies with half-curvatures A along and B across.
Strips<double> parabola(double a_curvature, double b_curvature, double approach) {
  Strips<double> s;
  s.regions = 1;
  double const half = std::sqrt(approach / b_curvature);
  int const n = s.count();
  s.width[0] = 2.0 * half / n;
  s.reach[0] = 1.0;
  for (int i = 0; i < n; ++i) {
    auto const k = static_cast<std::size_t>(i);
    s.position[k] = -half + (i + 0.5) * s.width[0];
    s.interpenetration[k] = approach - b_curvature * s.position[k] * s.position[k];
    s.curvature[k] = a_curvature;
  }
  solve_strips(steel, s);
  return s;
}

struct Sums {
  double force{0.0}, pressure{0.0}, length{0.0};
};
Sums sums(Strips<double> const& s) {
  Sums out;
  for (int i = 0; i < s.count(); ++i) {
    auto const k = static_cast<std::size_t>(i);
    if (!(s.load[k] > 0.0)) continue;
    out.force += s.load[k] * s.width[0];
    out.pressure = std::max(out.pressure, 2.0 * s.load[k] / (pi * s.half_length[k]));
    out.length = std::max(out.length, s.half_length[k]);
  }
  return out;
}

struct Wheel {
  BenchmarkPair profiles;
  ArcLength arc;
  ContactSearch search;

  explicit Wheel(double inverse_radius) : profiles(inverse_radius), arc(profiles.wheel), search(profiles.pair) {}
  StripSolution<double> at(double y, double depth, double roll = 0.0, double yaw = 0.0, double x = 0.0) {
    auto const pose = pose_of(x, y, 0.46 - depth, roll, yaw);
    search.find_all(pose, 0.0);
    return strip_contact({profiles.pair, steel, &arc}, pose, search);
  }
};

Vec3<double> total(StripSolution<double> const& c) {
  Vec3<double> sum{};
  for (int k = 0; k < c.count; ++k) {
    auto const& p = c.patch[static_cast<std::size_t>(k)];
    sum += p.weight * p.normal * p.direction;
  }
  return sum;
}

}  // namespace

TEST_CASE("kernel: slope of its integral is Boussinesq's strip, far away a point load, near a line contact") {
  // Far away the whole strip acts as its load at a point: a / y.
  double const far = 300.0, step = 1.0;
  CHECK((kernel.deflection(far + step) - kernel.deflection(far - step)) / (2.0 * step) ==
        doctest::Approx(1.0 / far).epsilon(1e-4));
  // A line of strips conforms as two cylinders do: all of Chi is 2 on either side.
  CHECK(kernel.curvature(1e4) == doctest::Approx(2.0).epsilon(1e-7));
  // Against direct integration over the strip's length, t = sin(theta).
  for (double k : {0.003, 0.1, 0.7, 3.0, 40.0}) {
    double deflection = 0.0, curvature = 0.0;
    int const n = 2000000;
    for (int i = 0; i < n; ++i) {
      double const theta = (i + 0.5) / n * pi / 2.0;
      deflection += square(std::cos(theta)) * std::asinh(k / std::sin(theta));
      curvature += k / std::sqrt(square(std::sin(theta)) + k * k);
    }
    CHECK(kernel.deflection(k) == doctest::Approx(2.0 * deflection / n).epsilon(1e-5));
    CHECK(kernel.curvature(k) == doctest::Approx(2.0 * curvature / n).epsilon(1e-5));
  }
}

TEST_CASE("a parabolic gap gives Hertz' ellipse") {
  for (double ratio : {0.02, 0.2, 1.0, 5.0, 20.0}) {
    double const across = 5.0, along_x = across * ratio, approach = 40e-6;
    auto const exact = hertz_contact(steel, along_x, across);
    double const root = std::sqrt(approach);
    double const force = exact.stiffness * approach * root;
    double const a = exact.a_per_root * root, b = exact.b_per_root * root;
    auto const found = sums(parabola(along_x, across, approach));
    CAPTURE(ratio);
    // Twenty strips over the overlap and two passes: 1.5 % in force, 3.5 % at a/b = 12, where few strips carry load.
    CHECK(found.force == doctest::Approx(force).epsilon(ratio < 0.1 ? 0.035 : 0.015));
    CHECK(found.pressure == doctest::Approx(1.5 * force / (pi * a * b)).epsilon(a > 4.0 * b ? 0.07 : 0.045));
    CHECK(found.length == doctest::Approx(a).epsilon(0.05));
  }
}

TEST_CASE("at yaw strips carry what the turned Hertz ellipse carries") {
  // A cone, steep as a flange, on a round rail head: one ellipse, 10 to 20 times as long as wide, turned and sheared.
  auto const cone = test::spline_of([](double s) { return -2.0 * s; }, -20e-3, 20e-3, 1e-3);
  auto const head = test::spline_of([](double y) { return 2.0 * y - std::sqrt(125.0) * square(y) / (2.0 * 40e-3); },
                                    -20e-3, 20e-3, 0.1e-3);
  ArcLength const arc(cone);
  for (double inverse_radius : {0.0, 2.0})
    for (double yaw : {0.0, 20e-3, 50e-3, -80e-3}) {
      WheelRollerPair const pair{&cone, &head, 0.46, 0.75, 0.75, inverse_radius};
      ContactSearch search(pair);
      double low = 0.44, high = 0.48;
      for (int i = 0; i < 60; ++i) {
        double const middle = 0.5 * (low + high);
        (search.find_all(pose_of(0.0, 0.0, middle, 0.0, yaw), 0.0) > 0 ? low : high) = middle;
      }
      auto const pose = pose_of(0.0, 0.0, low - 60e-6, 0.0, yaw);
      REQUIRE(search.find_all(pose, 0.0) == 1);
      NormalPatch<double> hertz;
      hertz.point = contact_point(pair, pose, search[0].s, search[0].gradient);
      hertz_patch(steel, hertz);
      auto const found = strip_contact({pair, steel, &arc}, pose, search);
      REQUIRE(found.count == 1);
      auto const& patch = found.patch[0];
      CAPTURE(inverse_radius);
      CAPTURE(yaw);
      // As without yaw above: a few strips carry load, two passes.
      CHECK(patch.normal == doctest::Approx(hertz.elastic).epsilon(0.04));
      CHECK(patch.peak_pressure == doctest::Approx(hertz.peak_pressure).epsilon(0.07));
      CHECK(patch.a * patch.b == doctest::Approx(hertz.a * hertz.b).epsilon(0.06));
      CHECK(patch.a / patch.b == doctest::Approx(hertz.a / hertz.b).epsilon(0.08));
      CHECK(patch.width == doctest::Approx(hertz.width).epsilon(0.08));
      CHECK(std::abs(patch.point.x - hertz.point.p.x) < 0.05 * patch.a);
    }
}

TEST_CASE("scaling of a half-space: twice the size, four times the force at the same pressure") {
  auto const small = sums(parabola(2.0, 3.0, 30e-6));
  auto const large = sums(parabola(1.0, 1.5, 60e-6));
  CHECK(large.force == doctest::Approx(4.0 * small.force).epsilon(1e-9));
  CHECK(large.pressure == doctest::Approx(small.pressure).epsilon(1e-9));
}

TEST_CASE("derivatives of the patches are those of differences, along every direction of the pose") {
  for (double inverse_radius : {0.0, 2.0})
    for (auto const& [y, depth, yaw0] : {std::array{0.3e-3, 0.30e-3, 4e-3},
                                         {2.5e-3, 0.06e-3, 4e-3},
                                         {-3e-3, 0.3e-3, 4e-3},
                                         {2.5e-3, inverse_radius > 0.0 ? 0.75e-3 : 0.12e-3, 50e-3},
                                         {6e-3, inverse_radius > 0.0 ? -0.72e-3 : -1.15e-3, 50e-3}}) {
      Wheel wheel(inverse_radius);
      double const x0 = 0.4e-3, roll0 = 0.02e-3;
      auto const force = [&](std::array<double, 5> const& q) {
        auto const c = wheel.at(q[1], q[2], q[3], q[4], q[0]);
        REQUIRE(c.count >= 1);
        auto const& p = c.patch[0];
        Vec3<double> const f = total(c);
        return std::array{f.x, f.y, f.z, p.point.x, p.point.y, p.a, p.b, p.moment.x};
      };
      std::array<double, 5> const q0{x0, y, depth, roll0, yaw0};
      using D = Dual<16>;
      auto const seed = [&](int i) { return D::variable(q0[static_cast<std::size_t>(i)], i); };
      auto const pose = pose_of(seed(0), seed(1), 0.46 - seed(2), seed(3), seed(4));
      wheel.at(y, depth, roll0, yaw0, x0);
      auto const c = strip_contact_of(NormalSetting{wheel.profiles.pair, steel, &wheel.arc}, pose, wheel.search);
      Vec3<D> sum{};
      for (int k = 0; k < c.count; ++k) {
        auto const& p = c.patch[static_cast<std::size_t>(k)];
        sum += p.weight * p.normal * p.direction;
      }
      auto const& p = c.patch[0];
      std::array const exact{sum.x, sum.y, sum.z, p.point.x, p.point.y, p.a, p.b, p.moment.x};
      std::array const scale{1.0, 1.0, 1.0, 1e-8, 1e-8, 1e-7, 1e-7, 1e-3};
      double const largest = std::abs(sum.z.d[2]);
      for (int i = 0; i < 5; ++i) {
        double const h = 1e-8;
        auto high = q0, low = q0;
        high[static_cast<std::size_t>(i)] += h;
        low[static_cast<std::size_t>(i)] -= h;
        auto const up = force(high), down = force(low);
        for (std::size_t k = 0; k < up.size(); ++k) {
          double const difference = (up[k] - down[k]) / (2.0 * h);
          // Places are exact to 1e-13 m along the rail and 4e-15 m across: 1e-5 and 2e-7 in such a difference. Large yaw shows it.
          double const noise = yaw0 > 10e-3 ? (k == 3 ? 0.1 : k == 4 ? 2e-3 : 0.0) : 0.0;
          CAPTURE(inverse_radius);
          CAPTURE(y);
          CAPTURE(i);
          CAPTURE(k);
          CHECK(exact[k].d[i] ==
                doctest::Approx(difference).epsilon(1e-4).scale(std::max(1e-4 * largest * scale[k], noise)));
        }
      }
    }
}

TEST_CASE("regions end where the gap vanishes, at yaw too") {
  for (double inverse_radius : {0.0, 2.0})
    for (double yaw : {0.0, 20e-3, 50e-3}) {
      Wheel wheel(inverse_radius);
      double height = 0.463;  // lowered until it carries load
      while (wheel.search.find_all(pose_of(0.4e-3, 6e-3, height, 0.0, yaw), 0.0) == 0) height -= 20e-6;
      auto const pose = pose_of(0.4e-3, 6e-3, height, 0.0, yaw);
      std::array<InterpenetrationRegion, max_regions> regions;
      int const n = find_regions(wheel.profiles.pair, pose, wheel.search, regions);
      for (int k = 0; k < n; ++k) {
        auto const& region = regions[static_cast<std::size_t>(k)];
        CAPTURE(yaw);
        if (region.left_is_root) CHECK(std::abs(reduce(wheel.profiles.pair, pose, region.left).gap) < 1e-11);
        if (region.right_is_root) CHECK(std::abs(reduce(wheel.profiles.pair, pose, region.right).gap) < 1e-11);
      }
    }
}

TEST_CASE("the force has no step in the shift, through merging and vanishing dips") {
  // S1002 on UIC60 at a fixed height: two dips merge, one of them folds away while indented by 40 um.
  for (double inverse_radius : {0.0, 2.0}) {
    Wheel wheel(inverse_radius);
    double const step = 1e-6;
    double last = 0.0, before = 0.0, largest = 0.0;
    Vec3<double> centre{};
    for (int i = 0; i <= 3000; ++i) {
      auto const c = wheel.at(-1.5e-3 + step * i, 0.25e-3);
      double const force = total(c).z;
      Vec3<double> now{};
      double load = 0.0;
      for (int k = 0; k < c.count; ++k) {
        auto const& p = c.patch[static_cast<std::size_t>(k)];
        now += p.weight * p.normal * p.point;
        load += p.weight * p.normal;
      }
      now = (1.0 / load) * now;
      // Kinks of the discrete problem where strips come and go, and a new division where regions join: below 1e-3.
      if (i > 1) CHECK(std::abs(force - 2.0 * last + before) < 1e-3 * force);
      if (i > 0) largest = std::max(largest, std::abs(now.y - centre.y));
      before = last, last = force, centre = now;
    }
    CHECK(largest < 0.02e-3);  // m per um of shift: no jump of the centre
  }
}

TEST_CASE("one wide patch where Hertz sees two ellipses, two patches where tread and flange touch") {
  Wheel wheel(0.0);
  auto const middle = wheel.at(0.0, 0.25e-3);
  CHECK(wheel.search.count() == 2);
  REQUIRE(middle.count == 1);
  CHECK(middle.patch[0].width > 15e-3);
  auto const root = wheel.at(5e-3, -0.2e-3);
  REQUIRE(root.count == 2);
  CHECK(std::abs(root.patch[1].wheel_s - root.patch[0].wheel_s) > 10e-3);
}

TEST_CASE("a roller that grows becomes a rail") {
  Wheel rail(0.0), large(1e-5);
  for (double y : {-2e-3, 0.0, 3e-3}) {
    double const depth = y > 2e-3 ? 0.03e-3 : 0.28e-3;
    auto const a = rail.at(y, depth, 0.0, 3e-3), b = large.at(y, depth, 0.0, 3e-3);
    REQUIRE(a.count == b.count);
    CHECK(total(a).z == doctest::Approx(total(b).z).epsilon(1e-5));
    CHECK(a.patch[0].a == doctest::Approx(b.patch[0].a).epsilon(1e-5));
  }
}

TEST_CASE("a patch comes from nothing: force and size vanish with the overlap") {
  Wheel wheel(0.0);
  double low = 0.0, high = 0.3e-3;  // depth of first touch
  for (int i = 0; i < 60; ++i) {
    double const middle = 0.5 * (low + high);
    wheel.search.find_all(pose_of(0.0, -3e-3, 0.46 - middle, 0.0, 0.0), 0.0);
    (wheel.search.count() == 0 ? low : high) = middle;
  }
  auto const force = [&](double overlap) { return total(wheel.at(-3e-3, high + overlap)).z; };
  // Hertz' 3/2 power down to a nanometre.
  CHECK(force(1e-9) / force(1e-7) == doctest::Approx(1e-3).epsilon(0.02));
  CHECK(force(1e-7) / force(1e-5) == doctest::Approx(1e-3).epsilon(0.05));
}
