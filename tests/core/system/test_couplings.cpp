// Geared rotors and how their motors are held: momentum, energy, Jacobian.
#include <doctest/doctest.h>

#include <random>

#include "rollerrig/system/outputs.hpp"
#include "system/models.hpp"

using namespace rollerrig;
using test::wheelset_parts;

namespace {

enum class Mounting { ground, frame, axle };
constexpr double gear = -3.5, inertia = 4.0, torque = 2500.0;

/// A wheelset on rollers, a frame over it on springs, a motor between the two.
struct Driven {
  test::Parts model;
  std::unique_ptr<Dynamics> dynamics;
  std::vector<double> x;

  Driven(Mounting mounting, unsigned seed, double size, double rotor = inertia)
      : model(wheelset_parts({.driven = false})) {
    model.bodies.push_back({3000.0, {1500.0, 2000.0, 2500.0}, {1.2, 0.0, 0.6}});
    for (bool on_axle : {true, false}) {
      ForceElement
          e;  // one spring at the wheelset's centre, which cannot carry a moment about its axle; one to the ground
      e.body_a = on_axle ? 2 : ground, e.body_b = on_axle ? 0 : 2;
      e.r_b = {on_axle ? 0.0 : 1.2, 0.0, 0.0};
      for (std::size_t c = 0; c < 6; ++c)
        if (c != coord_pitch && (c < 3 || !on_axle)) e.law[c] = {.laws = {LinearSpring{2e6}, LinearDamper{1e4}}};
      e.law[coord_z].preload = (on_axle ? -1500.0 : 1500.0) * 9.81;
      model.elements.push_back(e);
    }
    double const link = mounting == Mounting::axle ? 0.9 : 0.0;
    model.axle_torques.push_back(
        {0, mounting == Mounting::ground ? ground : 2, {{{0.0}, {torque}}}, link, gear, rotor});
    dynamics = std::make_unique<Dynamics>(model);
    x = solve_equilibrium(*dynamics, 20.0, 0.0).x;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    auto const& map = dynamics->map();
    for (int i = 0; i < map.coordinates + map.rates; ++i)
      x[static_cast<std::size_t>(i)] += (i < map.coordinates ? 1.0 : 30.0) * size * any(random);
  }

  std::vector<double> derivative(std::vector<double> const& at, std::vector<double>& z) {
    std::vector<double> x_dot(at.size());
    z.resize(static_cast<std::size_t>(dynamics->sizes().quadratures));
    REQUIRE(dynamics->derivative(0.0, at.data(), x_dot.data(), z.data()) == Status::ok);
    return x_dot;
  }
  double rate(std::vector<double> const& f, std::size_t body, std::size_t c) const {
    return f[static_cast<std::size_t>(dynamics->map().rate[body][c])];
  }
};

}  // namespace

TEST_CASE("a rotor that the ground holds adds its inertia times the gear ratio squared to the axle's") {
  Driven with(Mounting::ground, 4, 2e-5), without(Mounting::ground, 4, 2e-5, 0.0);
  std::vector<double> z;
  with.x = without.x;
  auto const a = with.derivative(with.x, z), b = without.derivative(without.x, z);
  double const J = 112.0;
  CHECK(std::abs(with.rate(b, 0, coord_pitch)) > 0.1);
  // yaw and roll of 1e-5 couple a little into the axle's turning about its own axis
  CHECK(with.rate(a, 0, coord_pitch) ==
        doctest::Approx(with.rate(b, 0, coord_pitch) * J / (J + gear * gear * inertia)).epsilon(1e-6));
}

TEST_CASE("what a motor does to axle and frame leaves the angular momentum of both and its rotor") {
  // The same state with and without the motor: what it changes of the vehicle's accelerations is internal.
  for (auto mounting : {Mounting::frame, Mounting::axle}) {
    Driven with(mounting, 0, 0.0);
    Driven without(mounting, 0, 0.0, 0.0);
    without.model.axle_torques[0].torque = {{{0.0}, {0.0}}};
    // A state in motion, but upright: Euler's equations about y are then those of plane motion.
    with.x[static_cast<std::size_t>(with.dynamics->map().rate[0][coord_pitch])] += 0.5;
    with.x[static_cast<std::size_t>(with.dynamics->map().rate[2][coord_pitch])] += 0.02;
    std::vector<double> z;
    Dynamics bare(without.model);
    auto const a = with.derivative(with.x, z);
    std::vector<double> b(a.size());
    REQUIRE(bare.derivative(0.0, with.x.data(), b.data(), nullptr) == Status::ok);
    auto const change = [&](std::size_t body, std::size_t c) { return with.rate(a, body, c) - with.rate(b, body, c); };
    double const axle = change(0, coord_pitch), frame = change(2, coord_pitch);
    double const lift_axle = change(0, coord_z), lift_frame = change(2, coord_z);
    CHECK(std::abs(axle) > 1.0);
    // Vertical momentum. Two models solve the contacts: a rounding of the axle's height of 0.46 m, 6e-17 m, times the
    // 1e9 N/m of a wheel on its roller is 6e-8 N, of several wheels and operations a few 1e-7 N.
    CHECK(11000.0 * lift_axle + 3000.0 * lift_frame == doctest::Approx(0.0).scale(1000.0).epsilon(1e-9));
    // about the axle: the frame's mass is 1.2 m ahead, where lifting counts negative
    double const casing =
        mounting == Mounting::frame
            ? with.rate(a, 2, coord_pitch)
            : -(with.rate(a, 2, coord_z) - (0.9 - 1.2) * with.rate(a, 2, coord_pitch) - with.rate(a, 0, coord_z)) / 0.9;
    double const rotor = gear * with.rate(a, 0, coord_pitch) + (1 - gear) * casing;
    double const sum = 112.0 * axle + 2000.0 * frame - 1.2 * 3000.0 * lift_frame + inertia * rotor;
    CHECK(sum == doctest::Approx(0.0).scale(torque).epsilon(1e-6));
    if (mounting == Mounting::axle) CHECK(std::abs(lift_axle) > 0.01);
  }
}

TEST_CASE("power put in by a motor is power stored and dissipated, rotor included") {
  for (auto mounting : {Mounting::ground, Mounting::frame, Mounting::axle})
    for (unsigned seed = 0; seed < 4; ++seed) {
      Driven driven(mounting, seed, 3e-5);
      Dynamics& dynamics = *driven.dynamics;
      std::vector<double> z;
      auto const f = driven.derivative(driven.x, z);
      auto const account = [&](Account a) { return z[static_cast<std::size_t>(dynamics.map().angles + a)]; };
      double const h = 1e-8;
      auto up = driven.x, down = driven.x;
      for (std::size_t i = 0; i < f.size(); ++i) up[i] += h * f[i], down[i] -= h * f[i];
      auto const energy = [&](std::vector<double> const& state) {
        dynamics.evaluate(0.0, state.data());
        return kinetic_energy(dynamics) + gravity_energy(dynamics) + element_energy(dynamics);
      };
      double const stored = (energy(up) - energy(down)) / (2 * h);
      double const balance = account(work_of_drive) + account(work_of_torque) - account(dissipated_elements) -
                             account(dissipated_normal) - account(dissipated_creep) - account(stored_contacts);
      CHECK(stored == doctest::Approx(balance).epsilon(1e-6).scale(1e5));
    }
}

TEST_CASE("the Jacobian with a rotor and an ideal axle, which share a wheelset, is that of differences") {
  for (auto mounting : {Mounting::frame, Mounting::axle}) {
    Driven driven(mounting, 3, 2e-5);
    driven.model.rolling_wheelsets = {0};
    driven.dynamics = std::make_unique<Dynamics>(driven.model);
    Dynamics& dynamics = *driven.dynamics;
    JacobianData j(dynamics.sizes());
    REQUIRE(dynamics.jacobian(0.0, driven.x.data(), j) == Status::ok);
    for (std::size_t k = 0; k < driven.x.size(); ++k) {
      double const h = static_cast<int>(k) < dynamics.map().coordinates ? 1e-9 : 2e-6;
      auto up = driven.x, down = driven.x;
      up[k] += h, down[k] -= h;
      std::vector<double> z;
      auto const f_up = driven.derivative(up, z), f_down = driven.derivative(down, z);
      auto const column = static_cast<Eigen::Index>(k);
      double const scale = j.a.col(column).cwiseAbs().maxCoeff();
      for (std::size_t i = 0; i < driven.x.size(); ++i)
        CHECK(j.a(static_cast<Eigen::Index>(i), column) ==
              doctest::Approx((f_up[i] - f_down[i]) / (2 * h)).epsilon(1e-5).scale(10.0 * scale + 10.0));
    }
  }
}
