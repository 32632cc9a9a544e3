// One patch from contact point to force: creepages of simple motions, frames, power, standstill.
#include <doctest/doctest.h>

#include <random>

#include "explicit_real.hpp"
#include "profiles.hpp"
#include "rollerrig/contact/patch.hpp"
#include "rollerrig/geometry/gap_nodes.hpp"
#include "rollerrig/math/dual.hpp"

using namespace rollerrig;
using test::BenchmarkPair;
using test::ExplicitReal;
using test::pose_of;

namespace {

ContactLaws laws() {
  ContactLaws l;
  l.kalker = std::make_shared<KalkerTable const>(l.material.poisson_ratio);
  return l;
}

template <class T>
Patch<T> patch_force(ContactLaws const& laws, ContactPoint<T> const& point, RelativePose<T> const& pose,
                     ContactMotion<T> const& motion, T const& time) {
  Patch<T> patch;
  patch.point = point;
  hertz_patch<T>(laws.material, patch);
  Friction const friction;
  add_creep_force(laws, time, MovingPatch<T>{&patch, &pose.o, &motion, &friction});
  return patch;
}

/// A wheel on a roller of radius R, both cylinders' crowns touching at the origin of b, 0.08 mm deep.
ContactPoint<double> on_the_crown(double inverse_radius, double tilt = 0.0) {
  ContactPoint<double> p;
  p.wheel_s = p.rail_y = 0.0;
  p.gap = -0.08e-3;
  p.p = {0.0, 0.75, 0.0};
  p.n = {0.0, -std::sin(tilt), std::cos(tilt)};
  p.wheel_curvature_along = 1.0 / 0.46;
  p.wheel_curvature_across = 0.0;
  p.rail_curvature_along = inverse_radius;
  p.rail_curvature_across = 1.0 / 0.3;
  return p;
}

RelativePose<double> const above = pose_of(0.0, 0.0, 0.46, 0.0, 0.0);
double const V = 20.0, R = 0.725;

/// Pure rolling on a rig: wheel +V/r, roller -V/R.
ContactMotion<double> rolling(double speed) {
  return {{0, 0, 0}, {0.0, speed / 0.46, 0.0}, {-speed, 0.0, 0.0}, {0.0, -speed / R, 0.0}};
}

}  // namespace

TEST_CASE("pure rolling on a level contact has no slip and no spin") {
  auto const p = patch_force(laws(), on_the_crown(1 / R), above, rolling(V), 0.0);
  CHECK(std::abs(p.slip_longitudinal) < 1e-14);
  CHECK(std::abs(p.slip_lateral) < 1e-14);
  CHECK(std::abs(p.spin_rate) < 1e-13);
  CHECK(p.rolling_speed == doctest::Approx(V));
  CHECK(p.force.z > 0.0);
  CHECK(std::abs(p.force.x) < 1e-6);
}

TEST_CASE("spin creepage on a rig is (1/r + 1/R) sin(delta), on track 1/r sin(delta)") {
  double const delta = 0.05;
  auto const rig_patch = patch_force(laws(), on_the_crown(1 / R, delta), above, rolling(V), 0.0);
  CHECK(rig_patch.creepage.spin == doctest::Approx(-(1 / 0.46 + 1 / R) * std::sin(delta)).epsilon(1e-4));  // V_s: 1e-5
  ContactMotion<double> const track{{0, 0, 0}, {0.0, V / 0.46, 0.0}, {-V, 0.0, 0.0}, {}};
  auto const rail_patch = patch_force(laws(), on_the_crown(0.0, delta), above, track, 0.0);
  CHECK(rail_patch.creepage.spin == doctest::Approx(-std::sin(delta) / 0.46).epsilon(1e-4));
}

TEST_CASE("a wheel that turns too fast is driven forward, one that slides left is pushed right") {
  auto motion = rolling(V);
  motion.omega_wheel.y *= 1.001;
  auto const fast = patch_force(laws(), on_the_crown(1 / R), above, motion, 0.0);
  CHECK(fast.creepage.longitudinal < 0.0);  // the wheel's point moves backwards over the roller's
  CHECK(fast.force.x > 0.0);
  CHECK(fast.creepage.longitudinal == doctest::Approx(-0.001).epsilon(1e-3));  // over the mean speed

  motion = rolling(V);
  motion.v_wheel.y = 0.01;
  auto const left = patch_force(laws(), on_the_crown(1 / R), above, motion, 0.0);
  CHECK(left.slip_lateral == doctest::Approx(0.01));
  CHECK(left.force.y < 0.0);
}

TEST_CASE("seen from a train or from the rig, the rolling speed is the same") {
  // A rail that rests and a wheelset that travels at V, against a wheelset at rest and a rail that comes at -V.
  ContactMotion<double> const from_ground{{V, 0, 0}, {0.0, V / 0.46, 0.0}, {0, 0, 0}, {}};
  ContactMotion<double> const from_train{{0, 0, 0}, {0.0, V / 0.46, 0.0}, {-V, 0, 0}, {}};
  auto const a = patch_force(laws(), on_the_crown(0.0), above, from_ground, 0.0);
  auto const b = patch_force(laws(), on_the_crown(0.0), above, from_train, 0.0);
  CHECK(a.rolling_speed == doctest::Approx(b.rolling_speed));
  CHECK(a.creepage.longitudinal == doctest::Approx(b.creepage.longitudinal).scale(1.0));
}

TEST_CASE("running backwards mirrors the forces of running forwards") {
  auto forward = rolling(V), backward = rolling(-V);
  forward.v_wheel.y = backward.v_wheel.y = 0.004;
  auto const f = patch_force(laws(), on_the_crown(1 / R, 0.05), above, forward, 0.0);
  auto const b = patch_force(laws(), on_the_crown(1 / R, 0.05), above, backward, 0.0);
  CHECK(b.rolling_speed == doctest::Approx(-f.rolling_speed));
  // Turn of the sense of running: lateral slip as before, spin rate opposite; the spin force pushes the same way.
  CHECK(b.creep.lateral == doctest::Approx(f.creep.lateral).epsilon(1e-9));
  CHECK(b.creep.spin_moment == doctest::Approx(-f.creep.spin_moment).epsilon(1e-9));
}

TEST_CASE("at standstill forces are finite, and zero where nothing moves") {
  auto motion = rolling(0.0);
  auto const still = patch_force(laws(), on_the_crown(1 / R, 0.1), above, motion, 0.0);
  CHECK(still.creep.longitudinal == 0.0);
  CHECK(still.creep.spin_moment == 0.0);
  CHECK(still.normal.total() > 0.0);
  motion.v_wheel.y = 1e-6;
  auto const creeping = patch_force(laws(), on_the_crown(1 / R, 0.1), above, motion, 0.0);
  CHECK(std::isfinite(creeping.creep.lateral));
  CHECK(creeping.creep.lateral < 0.0);
}

TEST_CASE("without spin a patch never feeds energy in") {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int i = 0; i < 500; ++i) {
    auto motion = rolling(30.0 * any(random));
    motion.v_wheel = {0.3 * any(random), 0.3 * any(random), 0.05 * any(random)};
    auto const p = patch_force(laws(), on_the_crown(1 / R), above, motion, 0.0);
    CHECK(p.creep_dissipation() >= 0.0);
    CHECK(p.normal.total() >= 0.0);
    CHECK(dot(p.force, on_the_crown(1 / R).n) >= 0.0);
    CHECK(std::hypot(p.creep.longitudinal, p.creep.lateral) <= 0.3 * p.normal.total() * (1 + 1e-12) + 1e-9);
  }
}

TEST_CASE("the power of the force on both bodies is elastic, damping and creep power") {
  std::mt19937 random(22);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int i = 0; i < 50; ++i) {
    auto motion = rolling(V);
    motion.v_wheel = {0.1 * any(random), 0.1 * any(random), 0.02 * any(random)};
    motion.omega_wheel = {0.1 * any(random), V / 0.46 + any(random), 0.1 * any(random)};
    auto const point = on_the_crown(1 / R, 0.3 * any(random));
    auto const p = patch_force(laws(), point, above, motion, 0.0);
    auto const power_of = [&](Vec3<double> const& v, Vec3<double> const& omega, Vec3<double> const& arm) {
      return dot(p.force, v + cross(omega, arm)) + dot(p.moment, omega);
    };
    double const power = power_of(motion.v_wheel, motion.omega_wheel, point.p - above.o) -
                         power_of(motion.v_roller, motion.omega_roller, point.p);
    CHECK(power == doctest::Approx(p.normal.total() * p.gap_rate - p.creep_dissipation()).epsilon(1e-10).scale(1.0));
  }
}

TEST_CASE("the patch is Hertz' ellipse at this approach") {
  auto const p = patch_force(laws(), on_the_crown(1 / R), above, rolling(V), 0.0);
  auto const h = hertz_contact(Material{}, 0.5 * (1 / 0.46 + 1 / R), 0.5 / 0.3);
  CHECK(p.a == doctest::Approx(h.a_per_root * std::sqrt(0.08e-3)));
  CHECK(p.b == doctest::Approx(h.b_per_root * std::sqrt(0.08e-3)));
  CHECK(p.normal.elastic == doctest::Approx(h.stiffness * std::pow(0.08e-3, 1.5)));
}

TEST_CASE("a patch holds for a scalar with no implicit conversions") {
  using E = ExplicitReal;
  auto const up = [](Vec3<double> const& v) { return lift<E>(v); };
  auto const d = on_the_crown(1 / R, 0.05);
  ContactPoint<E> const point{E(d.wheel_s),
                              E(d.rail_y),
                              E(d.gap),
                              up(d.p),
                              up(d.n),
                              E(d.wheel_curvature_along),
                              E(d.wheel_curvature_across),
                              E(d.rail_curvature_along),
                              E(d.rail_curvature_across)};
  auto const m = rolling(V);
  auto const p =
      patch_force(laws(), point, RelativePose<E>{up(above.o), {up(above.R.ex), up(above.R.ey), up(above.R.ez)}},
                  ContactMotion<E>{up(m.v_wheel), up(m.omega_wheel), up(m.v_roller), up(m.omega_roller)}, E(0.0));
  auto const plain = patch_force(laws(), d, above, m, 0.0);
  CHECK(p.force.x.x == plain.force.x);
  CHECK(p.force.z.x == plain.force.z);
}

// ---------------------------------------------------------------------------------------------------- blending weights
namespace {

/// Weights of all patches of the benchmark wheel at one lateral position.
std::vector<double> weights(double y, double height, double barrier, std::vector<double>* gaps = nullptr) {
  static BenchmarkPair const benchmark(1.0 / R);
  static GapNodes const nodes(benchmark.wheel, 1.0);
  auto const pose = pose_of(0.0, y, height, 0.0, 0.0);
  auto const found = find_minima(benchmark.pair, nodes, pose);
  std::vector<ContactPoint<double>> points;
  for (std::size_t k = 0; k < found.count; ++k) points.push_back(contact_point(benchmark.pair, pose, found.minimum[k]));
  auto const s = blending_weights(benchmark.pair, pose, found, points.data(), barrier);
  std::vector<double> out;
  for (std::size_t k = 0; k < found.count; ++k) {
    out.push_back(s[k]);
    if (gaps) gaps->push_back(found.minimum[k].gap);
  }
  return out;
}

}  // namespace

TEST_CASE("a lone patch and well separated patches count in full") {
  auto const lone = weights(3e-3, 0.46, 0.02);
  REQUIRE(lone.size() == 1);
  CHECK(lone[0] == 1.0);
  for (double weight : weights(0.0, 0.45975, 0.0)) CHECK(weight == 1.0);
}

TEST_CASE("weights stay between zero and one, one patch always counts in full, and they change continuously") {
  // 4e-5 m/s of lateral drift past the fold where the tread patch of S1002 on UIC60 disappears.
  double const height = 0.45978, step = 0.2e-6;
  double least = 1.0;
  std::vector<double> last;
  for (double y = 0.0; y < 0.7e-3; y += step) {
    auto const s = weights(y, height, 0.05);
    REQUIRE(!s.empty());
    CHECK(*std::max_element(s.begin(), s.end()) == doctest::Approx(1.0));
    for (double weight : s) {
      CHECK(weight >= 0.0);
      CHECK(weight <= 1.0);
      least = std::min(least, weight);
    }
    if (s.size() == last.size())
      for (std::size_t k = 0; k < s.size(); ++k) CHECK(std::abs(s[k] - last[k]) < 0.1);
    last = s;
  }
  CHECK(least < 0.05);  // at the fold itself the weight is zero
}

TEST_CASE(
    "each of a roller's differences from a rail can be left out, and the power on the roller stays what the velocities "
    "say") {
  double const delta = 0.05;
  auto point = on_the_crown(1 / R, delta);
  point.p = {2e-3, 0.75, -1e-3};  // off the crown, where all of them show
  auto motion = rolling(V);
  motion.v_wheel.y = 0.01;
  auto const patch_with = [&](RollerEffects const& effects) {
    auto l = laws();
    l.roller = effects;
    return patch_force(l, point, above, motion, 0.0);
  };
  auto const all = patch_with({});
  Vec3<double> const n = point.n;
  double const omega = motion.omega_roller.y;

  auto const no_spin = patch_with({.spin = false});
  CHECK(no_spin.spin_rate - all.spin_rate == doctest::Approx(omega * n.y));  // (1/R) V sin(delta)
  CHECK(no_spin.slip_longitudinal == all.slip_longitudinal);
  auto const no_conicity = patch_with({.conicity = false});
  CHECK(no_conicity.slip_longitudinal - all.slip_longitudinal == doctest::Approx(omega * point.p.z));  // i = x here
  CHECK(no_conicity.spin_rate == all.spin_rate);
  auto const no_yaw = patch_with({.yaw = false});
  CHECK(no_yaw.gap_rate - all.gap_rate == doctest::Approx(-omega * point.p.x * n.z));
  CHECK(no_yaw.slip_longitudinal == doctest::Approx(all.slip_longitudinal));

  for (RollerEffects const& effects :
       {RollerEffects{}, RollerEffects{.conicity = false}, RollerEffects{.spin = false}, RollerEffects{.yaw = false},
        RollerEffects{.curvature = false, .conicity = false, .spin = false, .yaw = false}}) {
    auto const p = patch_with(effects);
    Vec3<double> const arm = point.p - above.o;
    double const on_wheel = dot(p.force, motion.v_wheel) + dot(cross(arm, p.force) + p.moment, motion.omega_wheel);
    double const on_roller = dot(p.force, motion.v_roller) +
                             dot(moment_about_crown(effects, p.point.p, p.force, p.moment), motion.omega_roller);
    double const lost = p.creep_dissipation() - p.normal.total() * p.gap_rate;
    CHECK(on_roller - on_wheel == doctest::Approx(lost).epsilon(1e-9));  // round-off of terms 1e4 times as large
  }
}
