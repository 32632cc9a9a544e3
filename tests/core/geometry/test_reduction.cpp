// The reduction of the contact problem: closed forms of simple shapes, the equations it must satisfy, the limit of a rail.
#include <doctest/doctest.h>

#include <random>

#include "explicit_real.hpp"
#include "profiles.hpp"
#include "rollerrig/geometry/gap_nodes.hpp"
#include "rollerrig/math/dual.hpp"

using namespace rollerrig;
using test::BenchmarkPair;
using test::ExplicitReal;
using test::pose_of;

namespace {

UniformSpline line(double slope) {
  return test::spline_of([slope](double y) { return slope * y; }, -40e-3, 40e-3, 1e-3);
}
UniformSpline arc(double radius) {  // convex rail head
  return test::spline_of([radius](double y) { return -y * y / (radius + std::sqrt(radius * radius - y * y)); }, -40e-3,
                         40e-3, 0.1e-3);
}

/// The two surfaces as the paper writes them, (1)-(6): points and outward normals, for a residual independent of the code.
struct Surfaces {
  WheelRollerPair const& pair;
  RelativePose<double> const& pose;

  Vec3<double> roller_axis_offset() const { return {0.0, 0.0, -1.0 / pair.inverse_radius}; }
  /// Outward normal of the wheel at its abscissa s and angle alpha from straight down, b components.
  Vec3<double> wheel_normal(double s, double alpha) const {
    double const slope = pair.wheel->at(s).slope;
    double const scale = 1.0 / std::sqrt(1.0 + slope * slope);
    return pose.R * (scale * Vec3<double>{std::sin(alpha), -slope, -std::cos(alpha)});
  }
  Vec3<double> wheel_point(double s, double alpha) const {
    double const r = pair.wheel_radius + pair.wheel->at(s).value;
    return pose.o + pose.R * Vec3<double>{r * std::sin(alpha), pair.tape_circle_y + s, -r * std::cos(alpha)};
  }
  /// Angle at which a point given in b lies on the wheel.
  double angle_of(Vec3<double> const& p) const {
    Vec3<double> const local = pose.R.transposed_times(p - pose.o);
    return std::atan2(local.x, -local.z);
  }
};

/// A random pose in which a wheel of the benchmark may stand, flange contact included.
RelativePose<double> random_pose(std::mt19937& random) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  return pose_of(5e-3 * any(random), 9e-3 * any(random), 0.46 + 1e-3 * any(random), 5e-3 * any(random),
                 50e-3 * any(random));
}

}  // namespace

TEST_CASE("a cylinder above a parallel cylinder: the gap is the distance of the axes less the radii") {
  auto const flat = line(0.0);
  for (double radius : {0.5, 0.725, 50.0}) {
    WheelRollerPair const pair{&flat, &flat, 0.46, 0.75, 0.75, 1.0 / radius};
    for (double x : {0.0, 3e-3, -20e-3}) {
      auto const at = reduce(pair, pose_of(x, 0.0, 0.47, 0.0, 0.0), 1e-3);
      double const distance = std::hypot(x, 0.47 + radius);
      CHECK(at.gap == doctest::Approx(distance - 0.46 - radius).epsilon(1e-12));
      CHECK(std::abs(at.residual) < 1e-14);
      auto const point = contact_point(pair, pose_of(x, 0.0, 0.47, 0.0, 0.0), {1e-3, -1.0});
      CHECK(point.n.x == doctest::Approx(x / distance).epsilon(1e-12));
      CHECK(point.wheel_curvature_along == doctest::Approx(1.0 / 0.46));
      CHECK(point.rail_curvature_along == doctest::Approx(1.0 / radius));
      CHECK(point.wheel_curvature_across == doctest::Approx(0.0));
    }
  }
}

TEST_CASE("a cylinder above a flat rail: the gap is its height less its radius") {
  auto const flat = line(0.0);
  WheelRollerPair const pair{&flat, &flat, 0.46, 0.75, 0.75, 0.0};
  auto const at = reduce(pair, pose_of(0.1, 2e-3, 0.4611, 0.0, 0.03), -4e-3);
  CHECK(at.gap == doctest::Approx(1.1e-3).epsilon(1e-12));
}

TEST_CASE("a sphere-like wheel on a sphere-like roller: the normal joins the centres") {
  // A wheel profile that is a circle of the wheel's own radius makes a sphere of it; the rail's arc makes one of the roller.
  double const r = 0.46, big = 0.725, y0 = 0.75;
  auto const wheel = arc(r);
  auto const rail = arc(big);
  WheelRollerPair const pair{&wheel, &rail, r, y0, y0, 1.0 / big};
  auto const pose = pose_of(4e-3, 3e-3, 0.4605, 2e-3, 5e-3);
  Vec3<double> const wheel_centre = pose.o + y0 * pose.R.ey;
  Vec3<double> const roller_centre{0.0, y0, -big};
  Vec3<double> const d = wheel_centre - roller_centre;
  double const distance = std::sqrt(dot(d, d));
  auto const found = find_minima(pair, GapNodes(wheel, 1.0), pose, 1e-2);
  REQUIRE(found.count == 1);
  auto const point = contact_point(pair, pose, found.minimum[0]);
  // The splines are the spheres to 1e-13 m in height and 1e-9 in slope.
  CHECK(point.gap == doctest::Approx(distance - r - big).epsilon(1e-8));
  CHECK(point.n.x == doctest::Approx(d.x / distance).epsilon(1e-7));
  CHECK(std::abs(point.n.y - d.y / distance) < 1e-8);
  CHECK(point.wheel_curvature_across == doctest::Approx(1.0 / r).epsilon(1e-5));
  CHECK(point.wheel_curvature_along == doctest::Approx(1.0 / r).epsilon(1e-7));
  CHECK(point.rail_curvature_along == doctest::Approx(1.0 / big).epsilon(1e-7));
  CHECK(point.rail_curvature_across == doctest::Approx(1.0 / big).epsilon(1e-5));
  // Spheres have no principal directions: whatever the twist, the combined curvature is round.
  auto const both = point.combined_curvature();
  CHECK(std::abs(point.twist.sin) > 1e-3);
  CHECK(both.along == doctest::Approx(0.5 / r + 0.5 / big).epsilon(1e-5));
  CHECK(both.across == doctest::Approx(0.5 / r + 0.5 / big).epsilon(1e-5));
  CHECK(std::abs(both.mixed) < 1e-5);
}

TEST_CASE(
    "at yaw the wheel's circumference is turned from the rail by the yaw angle over the cosine of the contact angle") {
  for (double slope : {0.0, -0.1, -2.0})
    for (double yaw : {0.0, 5e-3, -50e-3}) {
      auto const flank = line(slope), rail = line(-slope);
      WheelRollerPair const pair{&flank, &rail, 0.46, 0.75, 0.75, 0.0};
      auto const point = contact_point(pair, pose_of(0.0, 0.0, 0.46, 0.0, yaw), {0.0, -1.0});
      double const lean = std::hypot(point.n.x, point.n.z);
      CHECK(point.twist.sin ==
            doctest::Approx(std::sin(yaw) * std::sqrt(1.0 + slope * slope) * point.n.z / lean).epsilon(0.02));
      CHECK(point.twist.sin * point.twist.sin + point.twist.cos * point.twist.cos == doctest::Approx(1.0));
    }
}

TEST_CASE("a cone on a circular rail head touches where the head has the cone's slope") {
  double const conicity = 0.05, head = 0.3;
  auto const wheel = line(-conicity);
  auto const rail = arc(head);
  WheelRollerPair const pair{&wheel, &rail, 0.46, 0.75, 0.75, 0.0};
  auto const pose = pose_of(0.0, 1e-3, 0.46, 0.0, 0.0);
  auto const found = find_minima(pair, GapNodes(wheel, 1.0), pose, 1e-2);
  REQUIRE(found.count == 1);
  auto const point = contact_point(pair, pose, found.minimum[0]);
  double const slope_angle = std::atan(conicity);
  CHECK(point.rail_y == doctest::Approx(-head * std::sin(slope_angle) * 1.0).epsilon(1e-6));
  CHECK(point.n.y == doctest::Approx(-std::sin(slope_angle)).epsilon(1e-6));
}

TEST_CASE("at random poses the common normal satisfies equations (7) and (8) below 1e-10") {
  std::mt19937 random(7);
  int contacts = 0, flange = 0;
  for (double inverse_radius : {0.0, 1.0 / 0.725, 1.0 / 0.5, 1e-4}) {
    BenchmarkPair const benchmark(inverse_radius);
    GapNodes const nodes(benchmark.wheel, 1.0);
    for (int i = 0; i < 150; ++i) {
      auto const pose = random_pose(random);
      auto const found = find_minima(benchmark.pair, nodes, pose, 2e-3);
      Surfaces const surfaces{benchmark.pair, pose};
      for (std::size_t k = 0; k < found.count; ++k) {
        auto const point = contact_point(benchmark.pair, pose, found.minimum[k]);
        // The wheel's point lies on the normal through the roller's point, at the gap: (8).
        Vec3<double> const on_wheel = point.p + point.gap * point.n;
        double const alpha = surfaces.angle_of(on_wheel);
        Vec3<double> const off = on_wheel - surfaces.wheel_point(point.wheel_s, alpha);
        CHECK(std::sqrt(dot(off, off)) < 1e-10);
        // The normals are parallel: (7), as cross products.
        Vec3<double> const c = cross(surfaces.wheel_normal(point.wheel_s, alpha), point.n);
        CHECK(std::sqrt(dot(c, c)) < 1e-10);
        CHECK(dot(surfaces.wheel_normal(point.wheel_s, alpha), point.n) < 0.0);
        // The roller's normal from its own equation (6) at its own point (3).
        auto const h = benchmark.rail.at(point.rail_y);
        double const px = inverse_radius * point.p.x, pz = 1.0 + inverse_radius * point.p.z;
        double const length = std::hypot(px, pz);
        double const scale = 1.0 / std::sqrt(1.0 + h.slope * h.slope);
        Vec3<double> const n_b{scale * px / length, -scale * h.slope, scale * pz / length};
        Vec3<double> const miss = cross(n_b, point.n);
        CHECK(std::sqrt(dot(miss, miss)) < 1e-10);
        CHECK(std::abs(point.p.y - benchmark.pair.rail_origin_y - point.rail_y) < 1e-12);
        double const height =
            (inverse_radius * (point.p.x * point.p.x + point.p.z * point.p.z) + 2.0 * point.p.z) / (length + 1.0);
        CHECK(std::abs(height - h.value) < 1e-10);
        // The patch lies inside both profiles.
        CHECK(benchmark.wheel.contains(point.wheel_s));
        CHECK(benchmark.rail.contains(point.rail_y));
        ++contacts;
        flange += std::abs(point.n.y) > 0.3;
      }
    }
  }
  CHECK(contacts > 500);
  CHECK(flange > 50);
}

TEST_CASE("a contact is where the gap is stationary over the wheel's abscissa") {
  BenchmarkPair const benchmark(1.0 / 0.725);
  auto const pose = pose_of(0.0, 2e-3, 0.46, 1e-4, 3e-3);
  auto const found = find_minima(benchmark.pair, GapNodes(benchmark.wheel, 1.0), pose, 1e-3);
  REQUIRE(found.count >= 1);
  for (std::size_t k = 0; k < found.count; ++k) {
    double const h = 1e-5, s = found.minimum[k].s;
    double const middle = reduce(benchmark.pair, pose, s).gap;
    CHECK(reduce(benchmark.pair, pose, s + h).gap > middle);
    CHECK(reduce(benchmark.pair, pose, s - h).gap > middle);
    CHECK(found.minimum[k].gap == doctest::Approx(middle));
  }
}

TEST_CASE("a growing roller becomes the rail: the gap's difference falls as 1/R, down to round-off") {
  BenchmarkPair const rail(0.0);
  auto const pose = pose_of(3e-3, 1e-3, 0.4601, 1e-3, 10e-3);
  double const s = -5e-3;
  double const limit = reduce(rail.pair, pose, s).gap;
  double last = 0.0;
  for (double radius : {1e1, 1e2, 1e3, 1e4, 1e5, 1e6}) {
    BenchmarkPair const roller(1.0 / radius);
    double const difference = reduce(roller.pair, pose, s).gap - limit;
    if (last != 0.0) CHECK(difference / last == doctest::Approx(0.1).epsilon(2e-2));
    last = difference;
  }
  // No cancellation of large radii: at R = 1000 km the rest is still the 1/R term.
  CHECK(std::abs(last) < 1e-9);
  CHECK(std::abs(reduce(BenchmarkPair(1e-14).pair, pose, s).gap - limit) < 1e-15);
}

TEST_CASE("a contact point's derivatives with respect to the pose are those of differences") {
  using D = Dual<5>;
  std::mt19937 random(11);
  int checked = 0;
  for (double inverse_radius : {0.0, 1.0 / 0.725}) {
    BenchmarkPair const benchmark(inverse_radius);
    GapNodes const nodes(benchmark.wheel, 1.0);
    for (int i = 0; i < 40; ++i) {
      std::uniform_real_distribution<double> any(-1.0, 1.0);
      double const q[5] = {5e-3 * any(random), 7e-3 * any(random), 0.46 + 3e-4 * any(random), 3e-3 * any(random),
                           20e-3 * any(random)};
      auto const pose_at = [&](int seed, double by) {
        double v[5];
        for (int c = 0; c < 5; ++c) v[c] = q[c] + (c == seed ? by : 0.0);
        return pose_of(v[0], v[1], v[2], v[3], v[4]);
      };
      auto const found = find_minima(benchmark.pair, nodes, pose_at(0, 0.0), 1e-3);
      for (std::size_t k = 0; k < found.count; ++k) {
        auto const& minimum = found.minimum[k];
        if (std::abs(minimum.gradient) < 2.0) continue;  // near a fold the root runs away from any difference
        auto const point = contact_point(benchmark.pair,
                                         pose_of(D::variable(q[0], 0), D::variable(q[1], 1), D::variable(q[2], 2),
                                                 D::variable(q[3], 3), D::variable(q[4], 4)),
                                         minimum);
        for (int seed = 0; seed < 5; ++seed) {
          double const h = 1e-7;
          auto const moved = [&](double by) {
            auto const pose = pose_at(seed, by);
            auto const nearby = find_minima(benchmark.pair, nodes, pose, 2e-3);
            auto const away = [&](std::size_t m) { return std::abs(nearby.minimum[m].s - minimum.s); };
            std::size_t best = 0;
            for (std::size_t m = 1; m < nearby.count; ++m)
              if (away(m) < away(best)) best = m;
            return contact_point(benchmark.pair, pose, nearby.minimum[best]);
          };
          auto const up = moved(h), down = moved(-h);
          // Roots are known to 1e-14 m: 1e-7 of a difference over 2e-7; curvature of the root's way adds as much.
          double const ds = (up.wheel_s - down.wheel_s) / (2 * h);
          CHECK(std::abs(point.wheel_s.d[seed] - ds) < 1e-4 * (1.0 + std::abs(ds)));
          CHECK(std::abs(point.gap.d[seed] - (up.gap - down.gap) / (2 * h)) < 1e-6);
          double const dnx = (up.n.x - down.n.x) / (2 * h);
          CHECK(std::abs(point.n.x.d[seed] - dnx) < 1e-4 * (3.0 + std::abs(dnx)));
          double const dny = (up.n.y - down.n.y) / (2 * h);
          CHECK(std::abs(point.n.y.d[seed] - dny) < 1e-4 * (1.0 + std::abs(dny)));
          ++checked;
        }
      }
    }
  }
  CHECK(checked > 200);
}

TEST_CASE("the geometry holds for a scalar with no implicit conversions") {
  using E = ExplicitReal;
  BenchmarkPair const benchmark(1.0 / 0.725);
  auto const at = reduce(benchmark.pair, pose_of(E(1e-3), E(2e-3), E(0.46), E(1e-4), E(3e-3)), E(-5e-3));
  auto const plain = reduce(benchmark.pair, pose_of(1e-3, 2e-3, 0.46, 1e-4, 3e-3), -5e-3);
  // In any other scalar than double the contact point takes one Newton step more: the last digit may differ.
  CHECK(at.gap.x == doctest::Approx(plain.gap).epsilon(1e-12));
  CHECK(at.residual.x == doctest::Approx(plain.residual).epsilon(1e-12));
  auto const point =
      contact_point(benchmark.pair, pose_of(E(1e-3), E(2e-3), E(0.46), E(1e-4), E(3e-3)), {-11e-3, -5.0});
  CHECK(std::isfinite(point.gap.x));
}
