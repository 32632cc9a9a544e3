// A small vehicle on track for the tests: a frame on two wheelsets, S1002 on UIC60, in a curve with transitions.
#pragma once
#include <utility>

#include "system/models.hpp"

namespace rollerrig::test {

struct VehicleSetup {
  double speed = 20.0;         ///< [m/s]
  double wheelbase = 8.0;      ///< long: the frames of its wheelsets differ
  bool elastic_rails = false;  ///< each rail on springs under each wheelset; it rolls about its foot
  double shift = 0.0;          ///< the line, the irregularities and the start moved along by this [m]
  double side = 1.0;           ///< -1: everything mirrored
};

/// Curvature 0 to 1/400 m and cant 0 to 120 mm over 40 m from 10 m on, without corners, and back through zero to a reverse
/// curve without a straight between.
inline Line curved_line(double shift = 0.0, double side = 1.0) {
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

/// Rails that go apart, one more than the other, rise and lean over 30 m from 20 m on, and stay so.
inline void lay_rails(Line& line, double shift = 0.0, double side = 1.0) {
  auto const ramp = [shift](double size) {
    double const length = 30.0, c = size / (length * length);
    return PiecewiseCubic{{20.0 + shift, 20.0 + length + shift},
                          {{{0.0, 0.0, 3.0 * c, -2.0 * c / length}, {size, 0.0, 0.0, 0.0}}}};
  };
  line.left = {ramp(side * 4e-3), ramp(1e-3), ramp(side * 0.02)};
  line.right = {ramp(side * -2e-3), ramp(2e-3), ramp(side * -0.01)};
  if (side < 0.0) std::swap(line.left, line.right);
}

/// A wave of each rail, no two alike, over 60 m; right and left change places in the mirror.
inline Irregularity waves(double side = 1.0, double fade_in = 20.0) {
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

inline Parts vehicle_parts(VehicleSetup const& setup) {
  Parts parts = wheelset_parts({.roller_radius = 0.0, .speed = setup.speed, .lateral_spring = 0.0});
  auto const contacts = std::exchange(parts.contacts, {});
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
      parts.contacts.push_back(c);
    }
  parts.start = setup.shift;
  return parts;
}

inline std::shared_ptr<Model const> vehicle_model(VehicleSetup const& setup) { return vehicle_parts(setup).build(); }

}  // namespace rollerrig::test
