// Small models for the tests of the system: a wheelset on rollers or rails, on springs or free.
#pragma once
#include <memory>

#include "profiles.hpp"
#include "rollerrig/system/dynamics.hpp"
#include "rollerrig/system/equilibrium.hpp"

namespace rollerrig::test {

struct Setup {
  double roller_radius = 0.725;  ///< [m]; 0: rails
  double speed = 20.0;           ///< [m/s]
  double friction = 0.3;
  bool driven = true;           ///< rollers held in speed
  double lateral_spring = 2e6;  ///< [N/m], to ground, and the same along; 0: none
};

/// A wheelset of 11 t on its springs; S1002 on UIC60.
inline std::unique_ptr<Model> wheelset_model(Setup const& setup) {
  auto model = std::make_unique<Model>();
  bool const rig = setup.roller_radius > 0.0;
  model->hertz = std::make_shared<HertzTable const>();
  model->kalker_tables.emplace_back(0.28);
  model->profiles.push_back(spline_of(s1002, -60e-3, 60e-3, 0.1e-3));
  model->profiles.push_back(spline_of(uic60, -42.8e-3, 28.5e-3, 0.05e-3));
  model->bodies.push_back({11000.0, {1120.0, 112.0, 1120.0}, {0.0, 0.0, 0.46}, true, {}, false});
  model->driven_inverse_radius.push_back(0.0);
  if (rig) {
    Body roller{2980.0, {1800.0, 705.0, 1800.0}, {0.0, 0.0, -setup.roller_radius}, true, {}, setup.driven};
    roller.locked = {true, true, true, true, false, true};
    model->bodies.push_back(roller);
    model->driven_inverse_radius.push_back(setup.driven ? 1.0 / setup.roller_radius : 0.0);
  }
  for (bool right : {false, true}) {
    WheelContact c;
    c.roller = rig ? 1 : ground;
    c.right = right;
    c.rail = !rig;
    c.wheelset_from_crown = {0.0, 0.0, 0.46};
    c.crown_in_roller = {0.0, 0.0, setup.roller_radius};
    c.pair = {&model->profiles[0], &model->profiles[1], 0.46, 0.75, 0.7605385, rig ? 1.0 / setup.roller_radius : 0.0};
    c.laws.hertz = model->hertz.get();
    c.laws.kalker = &model->kalker_tables[0];
    c.laws.friction.coefficient = setup.friction;
    model->contacts.push_back(c);
  }
  if (setup.lateral_spring > 0.0)
    for (double side : {1.0, -1.0}) {
      ForceElement e;
      e.body_a = ground, e.body_b = 0;
      e.r_b = {0.0, side, 0.0};
      e.law[coord_x] = {.stiffness = 5.0 * setup.lateral_spring, .series_damping = 15e3, .series_stiffness = 60e6};
      e.law[coord_y] = {.stiffness = setup.lateral_spring, .damping = 2e3};
      e.node[coord_x] = side > 0.0 ? 0 : 1;
      model->elements.push_back(e);
    }
  model->speed = {{{0.0}, {setup.speed}}};
  return model;
}

}  // namespace rollerrig::test
