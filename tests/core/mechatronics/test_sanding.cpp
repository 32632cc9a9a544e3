// Sand: when it flows, where it lies on the rail, who finds it, and what it makes of the rail's friction.
#include <doctest/doctest.h>

#include <cmath>

#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/contact/adhesion/rail_memory.hpp"
#include "rollerrig/math/dual.hpp"
#include "rollerrig/mechatronics/sanding.hpp"

using namespace rollerrig;

namespace {

constexpr double cell = 0.05;

/// A vehicle of two axles, 2.56 m apart, that runs at a speed; the first one sands.
struct Vehicle {
  double kept;
  SandedRail rail{};
  double place{0.0};

  explicit Vehicle(double the_kept) : kept{the_kept} { rail.reset(cell); }

  void run(double way, double speed, double flow) {
    double const h = 1e-3;
    for (long k = std::lround(way / speed / h); k > 0; --k) {
      rail.run(place + 1.28, place + 1.28 + speed * h, flow * h, kept);
      rail.run(place - 1.28, place - 1.28 + speed * h, 0.0, kept);
      place += speed * h;
    }
  }
  double at_first() const { return rail.at(place + 1.28); }
  double at_second() const { return rail.at(place - 1.28); }
};

Sanding const on_slide{
    .start = SandOnSlide{}, .flow = 0.01, .delay = 0.0, .run_on = 0.5, .least_speed = 2.0, .kept = 0.7};

}  // namespace

TEST_CASE("the sanding axle finds flow over speed, the axle behind it what the first wheels left") {
  Vehicle vehicle(0.7);
  vehicle.run(5.0, 10.0, 0.01);
  CHECK(vehicle.at_first() == doctest::Approx(1e-3).epsilon(1e-9));
  CHECK(vehicle.at_second() == doctest::Approx(0.7e-3).epsilon(1e-9));
  vehicle.run(1.0, 10.0, 0.0);
  CHECK(vehicle.at_first() == 0.0);
  CHECK(vehicle.at_second() == doctest::Approx(0.7e-3).epsilon(1e-9));  // still in what fell before
  vehicle.run(2.0, 10.0, 0.0);
  CHECK(vehicle.at_second() == 0.0);
}

TEST_CASE("no sand gets lost: what flowed lies on the rail, whatever the speed, and standing too") {
  for (double speed : {0.3, 7.0, 41.7}) {
    Vehicle vehicle(1.0);
    vehicle.run(4.0, speed, 0.02);
    double const flowed = 0.02 * 1e-3 * static_cast<double>(std::lround(4.0 / speed / 1e-3));
    vehicle.rail.run(vehicle.place + 1.28, vehicle.place + 1.28, 0.003, 1.0);
    double lies = 0.0;
    for (double s = -2.0; s < 9.0; s += cell) lies += vehicle.rail.at(s + 0.5 * cell) * cell;
    CHECK(lies == doctest::Approx(flowed + 0.003).epsilon(1e-9));
  }
}

TEST_CASE(
    "sand is wanted while an axle slides and for its run-on, from a place, or from a time; never of a slow train") {
  SandingSwitch on;
  auto const wants = [&](bool slides, double speed = 20.0) {
    return on.step(on_slide, {0.0, 0.0, slides}, speed, 0.1);
  };
  CHECK_FALSE(wants(false));
  CHECK(wants(true));
  for (int k = 0; k < 4; ++k) CHECK(wants(false));
  CHECK_FALSE((wants(false), wants(false)));
  CHECK_FALSE(wants(true, 1.0));
  SandFromDistance const place{100.0, 200.0};
  CHECK_FALSE(place.wanted({0.0, 99.9, true}));
  CHECK(place.wanted({0.0, 100.0, false}));
  CHECK_FALSE(place.wanted({0.0, 200.0, false}));
  SandFromTime const time{3.0, 5.0};
  CHECK_FALSE(time.wanted({2.9, 1e3, true}));
  CHECK(time.wanted({3.0, 0.0, false}));
  CHECK_FALSE(time.wanted({5.0, 0.0, false}));
}

TEST_CASE("sand leads from the friction of the rail to that of a sanded one, 63 % of the way at q_0") {
  RailAdhesion rail{{FallingFriction{0.06, 0.4, 0.2}}, {FallingFriction{0.28, 0.4, 0.6}}, 0.0};
  rail.sanded = {FallingFriction{0.25, 0.6, 0.2}, 0.4, 0.2};
  rail.sand_constant = 1.0 / 5e-4;
  double const w = 1.7, bare = rail.at(w, 0.0).friction, much = rail.sanded.at(w).friction;
  CHECK(rail.at(w, 0.0, 0.0).friction == bare);
  CHECK(rail.at(w, 0.0, 5e-4).friction ==
        doctest::Approx(bare + (1.0 - std::exp(-1.0)) * (much - bare)).epsilon(1e-14));
  CHECK(rail.at(w, 0.0, 1.0).friction == doctest::Approx(much).epsilon(1e-14));
  CHECK(rail.at(w, 0.0, 1.0).k_S == doctest::Approx(0.2).epsilon(1e-14));
  using D = Dual<1>;
  double const h = 1e-6, slope = (rail.at(w + h, 0.0, 3e-4).friction - rail.at(w - h, 0.0, 3e-4).friction) / (2.0 * h);
  CHECK(rail.at(D::variable(w, 0), D(0.0), 3e-4).friction.d[0] == doctest::Approx(slope).epsilon(1e-7));
  AdhesionMap map;
  map.pieces = {rail, rail}, map.borders = {10.0}, map.blend = 2.0;
  CHECK(map(11.0, w, 0.0, 5e-4).friction == doctest::Approx(rail.at(w, 0.0, 5e-4).friction).epsilon(1e-14));
}
