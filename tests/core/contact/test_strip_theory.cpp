// Creep forces strip by strip: on a flat ellipse, in the linear limit and in full sliding where they are known, and in general.
#include <doctest/doctest.h>

#include <random>

#include "explicit_real.hpp"
#include "rollerrig/contact/patch.hpp"
#include "rollerrig/math/dual.hpp"

using namespace rollerrig;
using test::ExplicitReal;

namespace {

KalkerTable const kalker(0.28);
double const G = 82e9, load = 5e4, mu = 0.3;
Vec3<double> const origin{0.0, 0.0, 0.0};

template <class T>
CreepQuery<T> query(Creepage<T> const& e, double a, double b, double direction = 1.0) {
  T const log_aspect(std::log(a / b));
  auto const stiffness = kalker_stiffness(kalker.at(log_aspect), G, T(a), T(b), T(direction));
  return {e, stiffness, T(mu * load), T(a), T(b), log_aspect, T(direction)};
}

/// Hertz' ellipse on a cylinder along rolling: curvature 0 is flat. Strips of equal width along the arc.
template <class T = double>
PatchStrips<T> bent_ellipse(double a, double b, double curvature) {
  PatchStrips<T> s;
  s.count = 48;
  for (std::size_t i = 0; i < 48; ++i) {
    double const from = i / 24.0 - 1.0, to = (i + 1.0) / 24.0 - 1.0, y = 0.5 * (from + to);
    auto const before = [](double t) { return 0.5 + 0.75 * t - 0.25 * t * t * t; };
    auto const area = [](double t) { return (t * std::sqrt(1.0 - t * t) + std::asin(t)) / pi; };
    double const arc = b * y, turn = curvature * arc;
    double const r = curvature > 0.0 ? std::sin(turn) / curvature : arc;
    double const drop = curvature > 0.0 ? (std::cos(turn) - 1.0) / curvature : 0.0;
    std::array const place{0.0, r, drop}, normal{0.0, std::sin(turn), std::cos(turn)};
    for (std::size_t k = 0; k < 3; ++k) s.point[k][i] = T(place[k]), s.normal[k][i] = T(normal[k]);
    s.force[i] = T(load * (before(to) - before(from)));
    s.area[i] = T(pi * a * b * (area(to) - area(from)));
    s.half_length[i] = T(a * std::sqrt(1.0 - y * y));
  }
  return s;
}

PointWrench<double> wrench(CreepQuery<double> const& q, PatchStrips<double> const& strips, Vec3<double> const& slip,
                           Vec3<double> const& turning) {
  return strip_wrench<Lanes<native_lanes>>(q, strips, origin, slip, turning, mu);
}

struct Any {
  std::mt19937 random{3};
  double sign() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); }
  /// Slip from stick to sliding, turning of a wheel on any angle of contact.
  std::array<Vec3<double>, 2> motion() {
    double const size = std::pow(10.0, -2.5 + sign());
    return {Vec3<double>{size * sign(), size * sign(), size * sign()},
            Vec3<double>{sign(), 2.0 * sign(), 2.0 * sign()}};
  }
};

}  // namespace

TEST_CASE("the strips of a flat ellipse are those of the closed form") {
  Any any;
  for (double a : {1.5e-3, 4e-3, 1e-2}) {
    double const b = 25e-6 / a;
    auto const strips = bent_ellipse(a, b, 0.0);
    for (int k = 0; k < 100; ++k) {
      auto [slip, turning] = any.motion();
      slip.z = turning.x = turning.y = 0.0;
      auto const q = query<double>({slip.x, slip.y, turning.z}, a, b);
      auto const strip = wrench(q, strips, slip, turning);
      auto const whole = ellipse_force<Lanes<native_lanes>>(q);
      // 16 nodes and 48 strips of equal width: spin alone turns the slip round within one of them.
      CHECK(std::abs(strip.force.x - whole.longitudinal) < 0.012 * mu * load);
      CHECK(std::abs(strip.force.y - whole.lateral) < 0.012 * mu * load);
      CHECK(std::abs(strip.moment.z - whole.spin_moment) < 0.012 * mu * load * std::max(a, b));
    }
  }
}

TEST_CASE("small creepages give Kalker's forces") {
  for (double a : {1.5e-3, 4e-3, 1e-2}) {
    double const b = 25e-6 / a;
    auto const f = query<double>({0, 0, 0}, a, b).stiffness;
    auto const x = ellipse_force<double>(query<double>({1e-7, 0.0, 0.0}, a, b));
    auto const y = ellipse_force<double>(query<double>({0.0, 1e-7, 0.0}, a, b));
    auto const s = ellipse_force<double>(query<double>({0.0, 0.0, 1e-5}, a, b));
    CHECK(x.longitudinal == doctest::Approx(-f.f11 * 1e-7).epsilon(1e-6));
    CHECK(y.lateral == doctest::Approx(-f.f22 * 1e-7).epsilon(1e-6));
    CHECK(s.lateral == doctest::Approx(-f.f23 * 1e-5).epsilon(1e-3));
    auto const back = ellipse_force<double>(query<double>({0.0, 0.0, 1e-5}, a, b, -1.0));
    CHECK(back.lateral == doctest::Approx(-s.lateral));
    CHECK(back.spin_moment == doctest::Approx(s.spin_moment));
  }
}

TEST_CASE("in full sliding every strip of a bent patch is pulled against its own slip") {
  double const a = 4e-3, b = 8e-3, curvature = 1.0 / 0.013;  // 70 degrees from edge to edge
  auto const strips = bent_ellipse(a, b, curvature);
  auto const q = query<double>({0.0, 0.0, 0.0}, a, b);
  for (Vec3<double> const& slip : {Vec3<double>{5.0, 0.0, 0.0}, {0.0, 5.0, 0.0}, {3.0, -4.0, 0.0}}) {
    Vec3<double> expected{};
    for (std::size_t i = 0; i < 48; ++i) {
      Vec3<double> const n{strips.normal[0][i], strips.normal[1][i], strips.normal[2][i]};
      Vec3<double> const tangential = slip - dot(slip, n) * n;
      expected -= (mu * strips.force[i] / std::sqrt(dot(tangential, tangential))) * tangential;
    }
    auto const found = wrench(q, strips, slip, {});
    CHECK(found.force.x == doctest::Approx(expected.x).scale(mu * load).epsilon(1e-3));
    CHECK(found.force.y == doctest::Approx(expected.y).scale(mu * load).epsilon(1e-3));
    CHECK(found.force.z == doctest::Approx(expected.z).scale(mu * load).epsilon(1e-3));
  }
}

TEST_CASE("strips brake, and the mirror image of a motion has the mirror image of the forces") {
  Any any;
  double const a = 5e-3, b = 6e-3;
  auto const strips = bent_ellipse(a, b, 50.0);
  auto const q = query<double>({0.0, 0.0, 0.0}, a, b);
  for (int k = 0; k < 2000; ++k) {
    auto const [slip, turning] = any.motion();
    auto const w = wrench(q, strips, slip, turning);
    CHECK(dot(w.force, slip) + dot(w.moment, turning) < 1e-3 * mu * load * std::sqrt(dot(slip, slip)));
    auto const m = wrench(q, strips, {slip.x, -slip.y, slip.z}, {-turning.x, turning.y, -turning.z});
    CHECK(m.force.x == doctest::Approx(w.force.x));
    CHECK(m.force.y == doctest::Approx(-w.force.y));
    CHECK(m.moment.z == doctest::Approx(-w.moment.z));
  }
}

TEST_CASE("forces of strips are C1, with exact derivatives") {
  using D = Dual<6>;
  Any any;
  double const a = 5e-3, b = 6e-3, h = 1e-7;
  auto const strips = bent_ellipse(a, b, 50.0);
  auto const dual_strips = bent_ellipse<D>(a, b, 50.0);
  auto const q = query<double>({0.0, 0.0, 0.0}, a, b);
  auto const dual_q = query<D>({D(0.0), D(0.0), D(0.0)}, a, b);
  for (int k = 0; k < 200; ++k) {
    auto const motion = any.motion();
    std::array<double, 6> const x{motion[0].x, motion[0].y, motion[0].z, motion[1].x, motion[1].y, motion[1].z};
    std::array<D, 6> d;
    for (int i = 0; i < 6; ++i) d[static_cast<std::size_t>(i)] = D::variable(x[static_cast<std::size_t>(i)], i);
    auto const exact =
        strip_wrench<D>(dual_q, dual_strips, lift<D>(origin), {d[0], d[1], d[2]}, {d[3], d[4], d[5]}, D(mu));
    for (std::size_t i = 0; i < 6; ++i) {
      double const step = i < 3 ? h : h / b;
      auto const at = [&](double by) {
        auto y = x;
        y[i] += by;
        return wrench(q, strips, {y[0], y[1], y[2]}, {y[3], y[4], y[5]});
      };
      auto const ahead = at(step), behind = at(-step);
      auto const scale = mu * load / (i < 3 ? 1e-3 : 1e-3 / b);
      auto const along = exact.force.x.d[static_cast<Eigen::Index>(i)],
                 across = exact.force.y.d[static_cast<Eigen::Index>(i)];
      CHECK(along == doctest::Approx((ahead.force.x - behind.force.x) / (2 * step)).scale(scale).epsilon(1e-4));
      CHECK(across == doctest::Approx((ahead.force.y - behind.force.y) / (2 * step)).scale(scale).epsilon(1e-4));
    }
  }
}

TEST_CASE("a strip's closed form asks a scalar for nothing but formulas") {
  auto const t =
      strip_traction(ExplicitReal(0.5), ExplicitReal(0.2), ExplicitReal(1.5), ExplicitReal(0.7), ExplicitReal(1.2));
  auto const d = strip_traction(0.5, 0.2, 1.5, 0.7, 1.2);
  // Not bit for bit: the compiler may fuse products and sums.
  CHECK(t.along.x == doctest::Approx(d.along).epsilon(1e-14));
  CHECK(t.across.x == doctest::Approx(d.across).epsilon(1e-14));
  CHECK(t.moment.x == doctest::Approx(d.moment).epsilon(1e-14));
}
