// Small models for the tests of the system: a wheelset on rollers or rails, on springs or free.
#pragma once
#include <memory>

#include "profiles.hpp"
#include "rollerrig/system/dynamics.hpp"
#include "rollerrig/system/equilibrium.hpp"
#include "rollerrig/system/model_builder.hpp"

namespace rollerrig::test {

/// Parts of a model, to be changed before it is built.
struct Parts {
  std::vector<UniformSpline> profiles;
  std::vector<Body> bodies;
  std::vector<ForceElement> elements;
  std::vector<ContactDescription> contacts;
  std::vector<AxleTorque> axle_torques;
  std::vector<RollerTorque> roller_torques;
  std::vector<int> rolling_wheelsets;  ///< with a rolling constraint
  TimeTable speed;
  Line line;
  double start = 0.0;
  Irregularity irregularity;
  double gravity = 9.81;
  double contact_loss_limit = 0.2;

  operator std::shared_ptr<Model const>() const { return build(); }
  std::shared_ptr<Model const> build() const {
    ModelBuilder builder(gravity);
    for (auto const& p : profiles) builder.add_profile(p);
    for (auto const& b : bodies) builder.add_body(b);
    for (auto const& e : elements) builder.add_element(e);
    for (auto const& c : contacts) builder.add_contact(c);
    for (auto const& t : axle_torques) builder.add_axle_torque(t);
    for (auto const& t : roller_torques) builder.add_roller_torque(t);
    for (int w : rolling_wheelsets) builder.add_rolling_constraint(w);
    builder.set_speed(speed);
    builder.set_line(line, start);
    if (!irregularity.empty()) builder.set_irregularity(irregularity);
    builder.set_contact_loss_limit(contact_loss_limit);
    return builder.finish();
  }
};

struct Setup {
  double roller_radius = 0.725;  ///< [m]; 0: rails
  double speed = 20.0;           ///< [m/s]
  double friction = 0.3;
  bool driven = true;           ///< rollers controlled in speed
  double lateral_spring = 2e6;  ///< [N/m], to ground, and the same along; 0: none
};

/// A wheelset of 11 t on its springs; S1002 on UIC60.
inline Parts wheelset_parts(Setup const& setup) {
  Parts parts;
  bool const rig = setup.roller_radius > 0.0;
  parts.profiles = {spline_of(s1002, -60e-3, 60e-3, 0.1e-3), spline_of(uic60, -42.8e-3, 28.5e-3, 0.05e-3)};
  parts.bodies.push_back({11000.0, {1120.0, 112.0, 1120.0}, {0.0, 0.0, 0.46}, true});
  if (rig) {
    Body roller{2980.0, {1800.0, 705.0, 1800.0}, {0.0, 0.0, -setup.roller_radius}, true};
    roller.speed_controlled_radius = setup.driven ? setup.roller_radius : 0.0;
    roller.locked = {true, true, true, true, false, true};
    parts.bodies.push_back(roller);
  }
  for (bool right : {false, true}) {
    ContactDescription c{.roller = rig ? 1 : ground,
                         .roller_radius = setup.roller_radius,
                         .right = right,
                         .rail_profile = 1,
                         .wheel_radius = 0.46,
                         .tape_circle_y = 0.75,
                         .rail_origin_y = 0.7605385};
    c.laws.friction.law = ConstantFriction{setup.friction};
    parts.contacts.push_back(c);
  }
  if (setup.lateral_spring > 0.0)
    for (double side : {1.0, -1.0}) {
      ForceElement e;
      e.body_a = ground, e.body_b = 0;
      e.r_b = {0.0, side, 0.0};
      e.law[coord_x] = {.laws = {LinearSpring{5.0 * setup.lateral_spring}, SeriesDamper{15e3, 60e6}}};
      e.law[coord_y] = {.laws = {LinearSpring{setup.lateral_spring}, LinearDamper{2e3}}};
      parts.elements.push_back(e);
    }
  parts.speed = {{{0.0}, {setup.speed}}};
  return parts;
}

inline std::shared_ptr<Model const> wheelset_model(Setup const& setup) { return wheelset_parts(setup).build(); }

}  // namespace rollerrig::test
