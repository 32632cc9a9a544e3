#include <doctest/doctest.h>

#include "rollerrig/system/equilibrium.hpp"
#include "rollerrig/system/static_wheelset_contact.hpp"
#include "system/models.hpp"

using namespace rollerrig;
using test::wheelset_model;

TEST_CASE("static preloads balance a frame on four springs, each by its lever") {
  std::vector<StandingBody> const bodies{
      {2600.0, {0.1, 0.0, 0.6}, false}, {1800.0, {1.28, 0.0, 0.46}, true}, {1800.0, {-1.28, 0.0, 0.46}, true}};
  std::vector<LoadSpring> springs;
  for (int wheelset : {1, 2})
    for (double y : {1.0, -1.0}) springs.push_back({0, wheelset, {wheelset == 1 ? 1.28 : -1.28, y, 0.46}});
  auto const loads = static_loads(bodies, springs, 9.81);
  auto const& p = loads.preload;
  REQUIRE(p.size() == 4);
  double const weight = 2600.0 * 9.81;
  CHECK(loads.imbalance < 1e-6);
  CHECK(p[0] + p[1] + p[2] + p[3] == doctest::Approx(-weight));  // pushes the axles down
  CHECK((p[0] + p[1]) * (1.28 - 0.1) == doctest::Approx((p[2] + p[3]) * (1.28 + 0.1)));
  CHECK(p[0] == doctest::Approx(p[1]));
  CHECK(loads.on_body[1] == doctest::Approx(1800.0 * 9.81 - 2.0 * p[0]));
  CHECK(std::abs(loads.on_body[0]) < 1e-6);
}

TEST_CASE("a body that nothing carries is reported as an imbalance") {
  auto const loads = static_loads({{100.0, {}, false}}, {}, 9.81);
  CHECK(loads.preload.empty());
  CHECK(loads.imbalance == doctest::Approx(981.0));
}

TEST_CASE("a loaded wheelset carries its load, free to roll without a roll moment") {
  auto const model = wheelset_model({.roller_radius = 0.0});
  StaticWheelsetContact contact(model, 0, 1);
  for (double y : {0.0, 2e-3, -5.5e-3}) {
    auto const r = contact.solve({.y = y}, 20e3, true);
    CHECK(r.converged);
    CHECK(r.vertical == doctest::Approx(20e3).epsilon(1e-6));
    CHECK(std::abs(r.roll_moment) < 1.0);  // [N m] of 7.5e3
  }
}

TEST_CASE("a wheelset loaded on the left mirrors one loaded on the right") {
  auto const model = wheelset_model({});
  StaticWheelsetContact contact(model, 0, 1);
  auto const left = contact.solve({.y = 3e-3, .yaw = 2e-3}, 20e3, true);
  auto const right = contact.solve({.y = -3e-3, .yaw = -2e-3}, 20e3, true);
  REQUIRE(left.patches.size() == right.patches.size());
  CHECK(left.position.z == doctest::Approx(right.position.z).epsilon(1e-9));
  CHECK(left.position.roll == doctest::Approx(-right.position.roll).epsilon(1e-6));
  auto const& a = left.patches.front();  // left wheel first
  auto const& b = right.patches.back();  // its mirror image: the right wheel
  CHECK_FALSE(a.right);
  CHECK(b.right);
  CHECK(a.wheel_s == doctest::Approx(b.wheel_s).epsilon(1e-6));
  CHECK(a.point.y == doctest::Approx(-b.point.y).epsilon(1e-9));
  CHECK(a.direction.y == doctest::Approx(-b.direction.y).epsilon(1e-6));
}

TEST_CASE("at the touch height the nearest gap is zero, and a little lower it is that much less") {
  auto const model = wheelset_model({});
  StaticWheelsetContact contact(model, 0, 1);
  for (double y : {-6.8e-3, 0.0, 4e-3, 7.5e-3})
    for (bool right : {false, true}) {
      WheelsetPosition position{.y = y};
      position.z = contact.touch_height(position, right);
      auto const at = contact.minima(position, right, 1e-3);
      REQUIRE(!at.empty());
      double deepest = -1.0;
      for (auto const& p : at) deepest = std::max(deepest, p.approach);
      CHECK(std::abs(deepest) < 1e-10);
      position.z -= 1e-6;
      double lower = -1.0;
      for (auto const& p : contact.minima(position, right, 1e-3)) lower = std::max(lower, p.approach / p.direction.z);
      CHECK(lower == doctest::Approx(1e-6).epsilon(1e-3));
    }
}
