// The line and the frame that travels along it.
#include <doctest/doctest.h>

#include "system/models.hpp"

using namespace rollerrig;
using test::curved_line;

namespace {

Vec3<double> column(Rotation<double> const& R, int i) { return i == 0 ? R.ex : i == 1 ? R.ey : R.ez; }
double size(Vec3<double> const& v) { return std::sqrt(dot(v, v)); }

/// Place and axes of the frame at s + distance in the ground, summed from s0 in steps short enough to be exact.
struct Absolute {
  Vec3<double> origin;
  Rotation<double> R;
};
Absolute absolute(Line const& line, double s) {
  PlanStep sum;
  double const cut = 2.0;
  for (double at = 0.0; at < s; at += cut) {
    auto const step = plan_step(line.curvature, at, std::min(cut, s - at));
    double const c = std::cos(sum.heading), n = std::sin(sum.heading);
    sum = {sum.x + c * step.x - n * step.y, sum.y + n * step.x + c * step.y, sum.heading + step.heading};
  }
  auto const f = track_frame<double>(line, {s, 1.0, 0.0}, 0.0);
  double const c = std::cos(sum.heading), n = std::sin(sum.heading);
  auto const turn = [&](Vec3<double> const& v) { return Vec3<double>{c * v.x - n * v.y, n * v.x + c * v.y, v.z}; };
  return {{sum.x, sum.y, centre_rise(line.cant.at(s).value).value}, {turn(f.R.ex), turn(f.R.ey), turn(f.R.ez)}};
}

}  // namespace

TEST_CASE("a piecewise cubic is constant beyond its ends, and its primitive is its integral") {
  PiecewiseCubic const f{{1.0, 2.0, 4.0}, {{{2.0, 1.0, 0.5, -0.3}, {3.0, -1.0, 0.2, 0.1}, {2.5, 9.0, 9.0, 9.0}}}};
  CHECK(f.at(-5.0).value == 2.0);
  CHECK(f.at(-5.0).slope == 0.0);
  CHECK(f.at(1.5).value == doctest::Approx(2.0 + 0.5 + 0.125 - 0.0375));
  CHECK(f.at(100.0).value == 2.5);
  CHECK(f.at(100.0).slope == 0.0);
  for (double s : {0.3, 1.3, 2.3, 3.9, 4.3}) {
    double const h = 1e-5;
    int const piece = f.piece_of(s);
    double const slope = (f.primitive(piece, s + h) - f.primitive(piece, s - h)) / (2 * h);
    CHECK(slope == doctest::Approx(f.at(s).value).epsilon(1e-9));
  }
  CHECK(f.at(Dual<1>::variable(1.5, 0)).value.d[0] == doctest::Approx(f.at(1.5).slope));
}

TEST_CASE("distance is the integral of the speed table, before, within and after it") {
  TimeTable const speed{{{1.0, 3.0, 7.0}, {10.0, 20.0, 16.0}}};
  double sum = 0.0;
  int const n = 100000;
  double const h = 10.0 / n;
  for (int i = 0; i < n; ++i) sum += h * speed.at((i + 0.5) * h);
  CHECK(travel_at(speed, 5.0, 10.0).s == doctest::Approx(5.0 + sum).epsilon(1e-9));
  auto const dual = travel_at(speed, 5.0, Dual<1>::variable(2.0, 0));
  CHECK(dual.s.d[0] == doctest::Approx(15.0));
  CHECK(dual.speed.d[0] == doctest::Approx(5.0));
}

TEST_CASE("the plan step along a circle is its chord, across breaks the sum of its parts") {
  PiecewiseCubic const circle{{0.0}, {{{1.0 / 150.0, 0.0, 0.0, 0.0}}}};
  for (double d : {12.5, -12.5}) {
    auto const step = plan_step(circle, 30.0, d);
    CHECK(step.x == doctest::Approx(150.0 * std::sin(d / 150.0)).epsilon(1e-14));
    CHECK(step.y == doctest::Approx(150.0 * (1.0 - std::cos(d / 150.0))).epsilon(1e-12));
  }
  auto const line = curved_line();
  for (double s : {4.0, 45.0, 78.0}) {
    auto const there = plan_step(line.curvature, s, 11.0);
    auto const back = plan_step(line.curvature, s + 11.0, -11.0);
    CHECK(there.heading == doctest::Approx(-back.heading).epsilon(1e-13));
    double const c = std::cos(there.heading), n = std::sin(there.heading);
    CHECK(std::abs(there.x + c * back.x - n * back.y) < 1e-13);
    CHECK(std::abs(there.y + n * back.x + c * back.y) < 1e-13);
  }
}

TEST_CASE("the centre line rises by half the cant, smoothly through zero") {
  CHECK(centre_rise(0.15).value == 0.075);
  CHECK(centre_rise(-0.15).value == 0.075);
  CHECK(centre_rise(-0.15).slope == -0.5);
  for (double h : {-0.01, 0.01}) {
    auto const in = centre_rise(h * (1 - 1e-9)), out = centre_rise(h * (1 + 1e-9));
    CHECK(in.value == doctest::Approx(out.value).epsilon(1e-8));
    CHECK(in.slope == doctest::Approx(out.slope).epsilon(1e-8));
    CHECK(std::abs(in.second - out.second) < 1e-6);
  }
}

TEST_CASE("in a curve to the left the right rail is raised, and the left one stays at its height") {
  auto const line = curved_line();
  auto const f = track_frame<double>(line, {60.0, 20.0, 0.0}, 0.0);
  Absolute const at = absolute(line, 60.0);
  CHECK(at.R.ey.z < 0.0);  // the left is down
  auto const rail = [&](double y) { return (at.origin + y * at.R.ey).z; };
  CHECK(std::abs(rail(0.75)) < 1e-12);
  CHECK(rail(-0.75) == doctest::Approx(0.12).epsilon(1e-12));
  CHECK(f.a.y > 0.0);  // towards the centre
  CHECK(std::hypot(f.a.y, f.a.z) == doctest::Approx(400.0 / 400.0));
}

TEST_CASE("velocities and accelerations of the frame are the derivatives of its place in the ground") {
  for (double side : {1.0, -1.0}) {
    auto const line = curved_line(0.0, side);
    double const V = 30.0, V_dot = 2.0;
    for (double s : {20.0, 37.0, 60.0, 95.0, 109.3, 118.0}) {
      auto const f = track_frame<double>(line, {s, V, V_dot}, 0.0);
      double const h = 3e-4;  // [s]; what the differences leave is below 1e-4 of V^2 / R
      auto const at = [&](double t) { return absolute(line, s + V * t + 0.5 * V_dot * t * t); };
      auto const low = at(-h), mid = at(0.0), high = at(h);
      auto const speed_at = [&](double t) {
        return track_frame<double>(line, {s + V * t + 0.5 * V_dot * t * t, V + V_dot * t, V_dot}, 0.0);
      };
      Vec3<double> const v = (0.5 / h) * (high.origin - low.origin);
      CHECK(size(mid.R.transposed_times(v) - f.v) < 1e-4);
      auto const before = low.R * speed_at(-h).v, after = high.R * speed_at(h).v;
      CHECK(size(mid.R.transposed_times((0.5 / h) * (after - before)) - f.a) < 1e-4);
      for (int i = 0; i < 3; ++i) {
        Vec3<double> const turning = (0.5 / h) * (column(high.R, i) - column(low.R, i));
        CHECK(size(mid.R.transposed_times(turning) - cross(f.omega, mid.R.transposed_times(column(mid.R, i)))) < 1e-5);
      }
      CHECK(size((0.5 / h) * (speed_at(h).omega - speed_at(-h).omega) - f.alpha) < 1e-4);
      CHECK(size((0.5 / h) * (speed_at(h).up - speed_at(-h).up) - f.up_rate) < 1e-5);
    }
  }
}

TEST_CASE("the place of one frame seen from another is that of the ground, and so is its derivative along the line") {
  auto const line = curved_line();
  for (double s : {5.0, 20.0, 44.0, 78.0, 100.0})
    for (double x : {9.5, -9.5}) {
      if (s + x < 0.0) continue;
      auto const f = track_frame<double>(line, {s, 20.0, 0.0}, x);
      Absolute const a = absolute(line, s + x), b = absolute(line, s);
      // H: the heading of b without its cant.
      Vec3<double> const ahead{b.R.ex.x, b.R.ex.y, 0.0}, left{-b.R.ex.y, b.R.ex.x, 0.0};
      auto const to_h = [&](Vec3<double> const& v) { return Vec3<double>{dot(v, ahead), dot(v, left), v.z}; };
      CHECK(size(to_h(a.origin - b.origin) - f.origin) < 1e-12);
      for (int i = 0; i < 3; ++i) CHECK(size(to_h(column(a.R, i)) - column(f.R, i)) < 1e-13);
      using D = Dual<1>;
      auto const d = track_frame<D>(line, {D::variable(s, 0), D(20.0), D(0.0)}, x);
      double const h = 1e-4;
      auto const up = track_frame<double>(line, {s + h, 20.0, 0.0}, x),
                 down = track_frame<double>(line, {s - h, 20.0, 0.0}, x);
      CHECK(d.origin.x.d[0] == doctest::Approx((up.origin.x - down.origin.x) / (2 * h)).epsilon(1e-6).scale(1e-3));
      CHECK(d.origin.y.d[0] == doctest::Approx((up.origin.y - down.origin.y) / (2 * h)).epsilon(1e-6).scale(1e-3));
      CHECK(d.origin.z.d[0] == doctest::Approx((up.origin.z - down.origin.z) / (2 * h)).epsilon(1e-6).scale(1e-3));
      CHECK(d.R.ey.x.d[0] == doctest::Approx((up.R.ey.x - down.R.ey.x) / (2 * h)).epsilon(1e-6).scale(1e-3));
      CHECK(d.R.ez.y.d[0] == doctest::Approx((up.R.ez.y - down.R.ez.y) / (2 * h)).epsilon(1e-6).scale(1e-3));
    }
}

TEST_CASE("an irregularity repeats with its period, and fades in with continuous derivatives") {
  auto const waves = test::waves();
  for (double s : {31.0, 59.9}) {
    auto const a = waves.at(false, s, 0.0), b = waves.at(false, s + 600.0, 0.0);
    CHECK(a.y.value == doctest::Approx(b.y.value).epsilon(1e-12));
    CHECK(a.z.slope == doctest::Approx(b.z.slope).epsilon(1e-12));
  }
  CHECK(waves.at(true, 3.0, 3.0).y.value == 0.0);
  for (double s : {7.1, 12.3, 19.99, 25.1}) {
    double const h = 1e-4;
    auto const low = waves.at(true, s - h, 3.0), mid = waves.at(true, s, 3.0), high = waves.at(true, s + h, 3.0);
    CHECK(mid.y.slope == doctest::Approx((high.y.value - low.y.value) / (2 * h)).epsilon(1e-5).scale(1e-5));
    CHECK(mid.y.second == doctest::Approx((high.y.slope - low.y.slope) / (2 * h)).epsilon(1e-4).scale(1e-5));
    CHECK(waves.at(true, Dual<1>::variable(s, 0), 3.0).z.slope.d[0] == doctest::Approx(mid.z.second).epsilon(1e-12));
  }
}
