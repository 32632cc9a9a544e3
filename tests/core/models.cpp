#include "plant/models.hpp"

namespace rollerrig::test {

Parts wheelset_parts(Setup const& setup) {
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
    c.friction.law = ConstantFriction{setup.friction};
    parts.described_contacts.push_back(c);
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

std::shared_ptr<Model const> wheelset_model(Setup const& setup) { return wheelset_parts(setup).build(); }

Line curved_line(double shift, double side) {
  Line line;
  auto const add = [shift, side](PiecewiseCubic& curve, double from, double length, double a, double b) {
    curve.start.push_back(from + shift);
    double const c = side * (b - a) / (length * length);
    curve.coefficient.push_back({side * a, 0.0, 3.0 * c, -2.0 * c / length});
  };
  for (auto [curve, size] : {std::pair{&line.curvature, 1.0 / 400.0}, std::pair{&line.cant, 0.12}}) {
    add(*curve, 10.0, 40.0, 0.0, size);
    add(*curve, 50.0, 30.0, size, size);
    add(*curve, 80.0, 60.0, size, -size);
    add(*curve, 140.0, 1.0, -size, -size);
  }
  return line;
}

void lay_rails(Line& line, double shift, double side) {
  auto const ramp = [shift](double size) {
    double const length = 30.0, c = size / (length * length);
    return PiecewiseCubic{{20.0 + shift, 20.0 + length + shift},
                          {{{0.0, 0.0, 3.0 * c, -2.0 * c / length}, {size, 0.0, 0.0, 0.0}}}};
  };
  line.left = {ramp(side * 4e-3), ramp(1e-3), ramp(side * 0.02)};
  line.right = {ramp(side * -2e-3), ramp(2e-3), ramp(side * -0.01)};
  if (side < 0.0) std::swap(line.left, line.right);
}

Irregularity waves(double side, double fade_in) {
  // The periodic cubic spline through a sine wave has second derivatives in proportion to it.
  auto const wave = [](double size, double count, double phase) {
    double const k = 2.0 * pi * count / 60.0, h = 0.25;
    double const bend = -6.0 * (2.0 - 2.0 * std::cos(k * h)) / (h * h * (4.0 + 2.0 * std::cos(k * h)));
    auto const at = [&](int i) { return size * std::sin(k * h * i + phase); };
    UniformSpline s{0.0, h, {}};
    for (int i = 0; i < 240; ++i)
      s.pieces.push_back({at(i), (at(i + 1) - at(i)) / h - h * bend * (2.0 * at(i) + at(i + 1)) / 6.0,
                          0.5 * bend * at(i), bend * (at(i + 1) - at(i)) / (6.0 * h)});
    return s;
  };
  Irregularity i{
      60.0, wave(side * 1.5e-3, 4, 0.3), wave(2e-3, 5, 1.1), wave(side * 1.0e-3, 6, 2.0), wave(1.5e-3, 3, 0.7), fade_in,
      true};
  if (side < 0.0) {
    std::swap(i.left_y, i.right_y);
    std::swap(i.left_z, i.right_z);
  }
  return i;
}

Parts vehicle_parts(VehicleSetup const& setup) {
  Parts parts = wheelset_parts({.roller_radius = 0.0, .speed = setup.speed, .lateral_spring = 0.0});
  auto const contacts = std::exchange(parts.described_contacts, {});
  parts.bodies[0] = {1800.0, {1000.0, 112.0, 1000.0}, {0.5 * setup.wheelbase, 0.0, 0.46}, true};
  parts.bodies.push_back(parts.bodies[0]);
  parts.bodies[1].position.x *= -1.0;
  parts.bodies.push_back({9000.0, {4000.0, 30000.0, 32000.0}, {0.0, 0.0, 0.9}});
  parts.bodies[2].locked[coord_x] = true;  // hauled
  for (int wheelset : {0, 1})
    for (double side : {1.0, -1.0}) {
      ForceElement e;
      e.body_a = 2, e.body_b = wheelset;
      e.r_b = {0.0, side, 0.0};
      e.law[coord_x] = {.laws = {LinearSpring{8e6}, SeriesDamper{15e3, 60e6}}};
      e.law[coord_y] = {.laws = {LinearSpring{4e6}, LinearDamper{2e3}}};
      e.law[coord_z] = {.preload = -9000.0 * 9.81 / 4.0, .laws = {LinearSpring{1.2e6}, LinearDamper{4e3}}};
      e.law[coord_roll] = {.laws = {LinearSpring{1e4}}};
      e.law[coord_yaw] = {.laws = {LinearSpring{2e4}}};
      parts.elements.push_back(e);
    }
  for (int wheelset : {0, 1})
    for (ContactDescription c : contacts) {
      c.wheelset = wheelset;
      if (setup.elastic_rails) {
        double const x = parts.bodies[static_cast<std::size_t>(wheelset)].position.x;
        Body rail{150.0, {1.0, 1.0, 1.0}, {x, c.right ? -0.76 : 0.76, -0.09}};
        rail.locked = {true, false, false, false, true, true};
        rail.in_moving_frame = false;
        c.roller = static_cast<int>(parts.bodies.size());
        parts.bodies.push_back(rail);
        ForceElement e;
        e.body_a = ground, e.body_b = c.roller;
        e.r_b = {0.0, 0.0, -0.08};  // its foot
        e.law[coord_y] = {.laws = {LinearSpring{3e7}, LinearDamper{5e4}}};
        e.law[coord_roll] = {.laws = {LinearSpring{4e5}, LinearDamper{5e2}}};
        e.law[coord_z] = {.preload = 150.0 * 9.81, .laws = {LinearSpring{6e7}, LinearDamper{1e5}}};
        parts.elements.push_back(e);
      }
      parts.described_contacts.push_back(c);
    }
  parts.start = setup.shift;
  return parts;
}

std::shared_ptr<Model const> vehicle_model(VehicleSetup const& setup) { return vehicle_parts(setup).build(); }

Parts small_parts(bool driven) {
  Setup setup;
  setup.driven = driven;
  Parts parts = wheelset_parts(setup);
  parts.profiles = {spline_of(s1002, -60e-3, 60e-3, 1e-3), spline_of(uic60, -42e-3, 28e-3, 1e-3)};
  parts.speed.points = {{0.0}, {setup.speed}};
  return parts;
}

AssembledModel assembled(Parts const& parts, std::optional<MechatronicSetup> setup) {
  AssembledModel a;
  a.name = "small";
  a.model = parts.build();
  Dynamics dynamics(a.model);
  a.start = solve_equilibrium(dynamics, 20.0, 0.0, {}).x;
  for (std::size_t i = 0; i < parts.bodies.size(); ++i) a.names.bodies.push_back("body_" + std::to_string(i));
  for (std::size_t i = 0; i < parts.elements.size(); ++i) a.names.elements.push_back("element_" + std::to_string(i));
  a.options.method = integrate::Method::rodas4;
  a.options.relative_tolerance = 1e-6;
  a.options.absolute_tolerance = {1e-8};
  a.options.maximum_step = 0.01;
  a.options.final_time = 1.0;
  a.setup = std::move(setup);
  if (a.setup) a.names.axles = {"axle_1"};
  return a;
}

AssembledModel braked() {
  Parts parts = small_parts(true);
  MechatronicSetup setup;
  setup.step = 1e-3, setup.speed = 20.0, setup.rail_cell = 0.05;
  AxleParts axle;
  axle.wheelset = 0, axle.axle_torque = 0, axle.contacts = {0, 1};
  parts.axle_torques.push_back({.wheelset = 0});
  setup.axles = {axle};
  Actuators& act = setup.actuators;
  act.by_traction_motors = true;
  act.brake_demand.points = {{0.0, 0.1}, {0.0, 3e5}};
  act.brake = {0.02, 500.0, {{0.0, 10.0}, {0.4, 0.35}}, 0.25, 2.0, 0.1};
  act.pneumatics.control_valve = {2e5, 2e5, 20.0, 1e5, 0.01};
  act.motor.bandwidth = act.roller_drive.bandwidth = 100.0;
  setup.sensors.axles = PulsePeriod{.teeth = 100.0, .pitch_error = 0.01, .timeout = 0.3};
  setup.sensors.rollers = setup.sensors.axles;
  setup.sensors.axle_load = {.bandwidth = 100.0, .noise = 10.0, .resolution = 1.0, .range = 1e6};
  SlipAndDeceleration law;
  law.vent_slip = 0.1, law.vent_slip_speed = 0.5, law.vent_deceleration = 3.0, law.fill_slip = 0.05,
  law.fill_slip_speed = 0.3;
  law.pulse_time = 0.02, law.pulse_pause = 0.1;
  WheelSlideProtection const protection{.law = law,
                                        .wheel_radius = 0.46,
                                        .reference_deceleration = 1.5,
                                        .filter_time = 0.02,
                                        .recovery_acceleration = 1.0,
                                        .longest_vent = 5.0};
  setup.controllers.push_back({{.every = 5, .delay = 3}, protection});
  return assembled(parts, setup);
}

}  // namespace rollerrig::test
