// track/line.hpp - the line as it was laid: plan curvature, cant and place of the rails over arc length, and the frame that moves
// along it.
//
//   curvature, cant, travel -> [track frame F at s(t) + x] -> bodies in their own frames, elements in a common one
//
// Frame F  origin on the centre line at the top of rail, x along the plan of the line, y in the canted plane to the left,
//          z out of it. Every body has its own, at its design position x along the vehicle; its state is the displacement
//          from the design position in F and stays small however long the run.
// Frame H  at the vehicle's reference point s(t): x along the plan of the line, z up. What elements join is expressed in H;
//          the way from one frame to another is integrated over the few metres between them, never over the line.
// Signs    curvature > 0: a curve to the left. Cant h > 0: the right rail is raised, by h over the base; the inner rail stays
//          at its height, so the centre line rises by |h|/2.
// Source   docs/theory/track.md, (W1)-(W6).
#pragma once
#include <cmath>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/curves.hpp"
#include "rollerrig/math/vector.hpp"

namespace rollerrig {

/// One rail at one arc length: displacement and its derivatives along the line.
template <Scalar T>
struct RailOffset {
  CurvePoint<T> y{T(0.0), T(0.0), T(0.0)};     ///< [m], to the left
  CurvePoint<T> z{T(0.0), T(0.0), T(0.0)};     ///< [m], up
  CurvePoint<T> roll{T(0.0), T(0.0), T(0.0)};  ///< [rad], of its head about x at its highest point
  bool rolled{false};                          ///< false: there is no roll anywhere

  /// Axes of the head in those of the rail without roll.
  Rotation<T> lean() const {
    using std::cos;
    using std::sin;
    T const c = cos(roll.value), s = sin(roll.value);
    return {{T(1.0), T(0.0), T(0.0)}, {T(0.0), c, s}, {T(0.0), -s, c}};
  }
};

/// Where one rail was laid, each with a continuous slope; an empty curve: as the model's contacts have it.
struct RailLayout {
  PiecewiseCubic y{}, z{};  ///< of the highest point of its head [m]
  PiecewiseCubic roll{};    ///< about that point; positive where a left rail leans inwards [rad]

  static constexpr auto fields() {
    using P = RailLayout;
    return members(Member{"y", &P::y, "m", "displacement of the head's highest point to the left"},
                   Member{"z", &P::z, "m", "displacement of it upwards"},
                   Member{"roll", &P::roll, "rad", "turn of the head about it"});
  }
  bool empty() const { return y.empty() && z.empty() && roll.empty(); }

  template <Scalar T>
  void add_to(RailOffset<T>& offset, T const& arc_length) const {
    auto const add = [&](CurvePoint<T>& to, PiecewiseCubic const& curve) {
      auto const here = curve.at(arc_length);
      to = {to.value + here.value, to.slope + here.slope, to.second + here.second};
    };
    add(offset.y, y);
    add(offset.z, z);
    add(offset.roll, roll);
    offset.rolled = !roll.empty();
  }
};

/// Where a rail really lies: displacement from its design position over arc length.
///
/// Four curves, y (to the left) and z (up) of the left and of the right rail, over one period of the line and repeated from
/// there on. They fade in from where the foremost wheel starts, so that a run begins on perfect track.
struct Irregularity {
  double period{0.0};  ///< [m]; the splines start at 0 and end here
  UniformSpline left_y{}, left_z{}, right_y{}, right_z{};
  double fade_in{0.0};  ///< distance over which they grow to full size [m]
  bool steered{true};   ///< on a rig: rollers turn into the direction of the rail they stand for

  static constexpr auto fields() {
    using P = Irregularity;
    return members(Member{"period", &P::period, "m", "distance after which it repeats itself", positive},
                   Member{"left_y", &P::left_y}, Member{"left_z", &P::left_z}, Member{"right_y", &P::right_y},
                   Member{"right_z", &P::right_z},
                   Member{"fade_in", &P::fade_in, "m", "distance over which it grows to full size", not_negative},
                   Member{"steered", &P::steered});
  }

  /// @param arc_length  s + x of the wheel [m]
  /// @param fade_start  s + x of the foremost wheel at the start [m]
  template <Scalar T>
  RailOffset<T> at(bool right, T const& arc_length, double fade_start) const {
    T const u = arc_length - period * std::floor(value_of(arc_length) / period);
    auto const fade = fade_at(arc_length - fade_start);
    return {faded(fade, (right ? right_y : left_y).at(u)), faded(fade, (right ? right_z : left_z).at(u))};
  }

 private:
  /// 0 up to the start, 1 from fade_in on, in between a polynomial with two continuous derivatives.
  template <Scalar T>
  CurvePoint<T> fade_at(T const& distance) const {
    double const x = value_of(distance);
    if (x >= fade_in) return {T(1.0), T(0.0), T(0.0)};
    if (x <= 0.0) return {T(0.0), T(0.0), T(0.0)};
    double const inverse = 1.0 / fade_in;
    T const u = distance * inverse;
    return {u * u * u * (10.0 + u * (6.0 * u - 15.0)), (30.0 * inverse) * (u * u * (1.0 + u * (u - 2.0))),
            (60.0 * inverse * inverse) * (u * (1.0 + u * (2.0 * u - 3.0)))};
  }

  template <Scalar T>
  static CurvePoint<T> faded(CurvePoint<T> const& fade, CurvePoint<T> const& curve) {
    return {fade.value * curve.value, fade.value * curve.slope + fade.slope * curve.value,
            fade.value * curve.second + 2.0 * (fade.slope * curve.slope) + fade.second * curve.value};
  }
};

/// Position and motion of the vehicle's reference point along the line.
template <Scalar T>
struct Travel {
  T s;             ///< arc length [m]
  T speed;         ///< V [m/s]
  T acceleration;  ///< dV/dt [m/s^2]
};

/// Travel with a speed given over time: s = start + integral of V from time 0 on, in closed form. (W1)
template <Scalar T>
Travel<T> travel_at(TimeTable const& speed, double start, T const& t) {
  double const now = value_of(t);
  double const acceleration = speed.rate(now);
  T const v = speed.at(t);
  T const since = t - now;  // zero, but for its derivative
  return {start + speed.integral(now) + value_of(v) * since, v, T(acceleration)};
}

struct Line {
  PiecewiseCubic curvature{};  ///< kappa(s) of the plan [1/m]
  PiecewiseCubic cant{};       ///< h(s) [m], with a continuous slope: F turns with it
  double cant_base{1.5};       ///< distance over which cant is measured [m]
  RailLayout left{}, right{};  ///< gauge and inclination

  static constexpr auto fields() {
    using P = Line;
    return members(Member{"curvature", &P::curvature, "1/m", "curvature of the plan"},
                   Member{"cant", &P::cant, "m", "cant, positive where the right rail is raised"},
                   Member{"cant_base", &P::cant_base, "m", "distance over which cant is measured", positive},
                   Member{"left", &P::left}, Member{"right", &P::right});
  }

  bool empty() const { return curvature.empty() && cant.empty() && !moves_rails(); }
  bool moves_rails() const { return !left.empty() || !right.empty(); }
  /// Straight and level everywhere from `low` to `high`.
  bool straight(double low, double high) const { return curvature.vanishes(low, high) && cant.vanishes(low, high); }
};

/// Motion of a frame F and its position in H. Components in F unless it says H.
template <Scalar T>
struct TrackFrame {
  Vec3<T> v;        ///< velocity of the origin [m/s]
  Vec3<T> omega;    ///< angular velocity [rad/s]
  Vec3<T> a;        ///< acceleration of the origin [m/s^2]
  Vec3<T> alpha;    ///< angular acceleration [rad/s^2]
  Vec3<T> up;       ///< unit vector against gravity
  Vec3<T> up_rate;  ///< how its components change [1/s]
  Vec3<T> along;    ///< v per speed [-]
  Vec3<T> twist;    ///< omega per speed [1/m]
  Vec3<T> origin;   ///< from the origin of H, H components [m]
  Rotation<T> R;    ///< F -> H
};

/// Half the absolute value of the cant, rounded where it is below 10 mm so that its second derivative stays continuous.
template <Scalar T>
CurvePoint<T> centre_rise(T const& cant) {
  double const width = 10e-3;  // [m]
  T const u = cant * (1.0 / width);
  T const u2 = u * u;
  double const sign = value_of(cant) < 0.0 ? -1.0 : 1.0;
  bool const beyond = value_of(u2) > 1.0;
  return {0.5 * select(beyond, sign * cant, width * (0.375 + u2 * (0.75 - 0.125 * u2))),
          0.5 * select(beyond, T(sign), u * (1.5 - 0.5 * u2)),
          0.5 * select(beyond, T(0.0), (1.5 - 1.5 * u2) * (1.0 / width))};
}

/// Heading and plan position at the arc length s + distance seen from H at s.
struct PlanStep {
  double x{0.0}, y{0.0};  ///< [m]
  double heading{0.0};    ///< [rad]
};

/// (W6): integrated piece by piece, so that a break of the curvature costs no accuracy.
PlanStep plan_step(PiecewiseCubic const& curvature, double s, double distance);

/// The frame at s + distance. (W2), (W3), (W6)
template <Scalar T>
TrackFrame<T> track_frame(Line const& line, Travel<T> const& travel, double distance) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  T const& V = travel.speed;
  T const arc_length = travel.s + distance;
  auto const [kappa, kappa_slope, unused] = line.curvature.at(arc_length);
  auto const [cant, cant_slope, cant_second] = line.cant.at(arc_length);
  double const inverse_base = 1.0 / line.cant_base;
  auto const rise = centre_rise(cant);
  T const climb = rise.slope * cant_slope;  // r'
  T const climb_slope = rise.second * cant_slope * cant_slope + rise.slope * cant_second;
  // Roll of F about x: the right rail raised is a roll to the right. (W2)
  T const s_roll = -(inverse_base * cant);
  T const c_roll = sqrt(1.0 - s_roll * s_roll);
  T const roll_slope = -(inverse_base * cant_slope) / c_roll;
  T const roll_second = (s_roll * roll_slope * roll_slope - inverse_base * cant_second) / c_roll;

  TrackFrame<T> f;
  f.up = {T(0.0), s_roll, c_roll};
  Vec3<T> const level{T(0.0), c_roll, -s_roll};  // the horizontal to the left
  f.up_rate = (V * roll_slope) * level;
  f.along = Vec3<T>{T(1.0), T(0.0), T(0.0)} + climb * f.up;
  f.twist = {roll_slope, kappa * s_roll, kappa * c_roll};
  f.v = V * f.along;
  f.omega = V * f.twist;
  f.a = Vec3<T>{travel.acceleration, T(0.0), T(0.0)} + (V * V * kappa) * level +
        (travel.acceleration * climb + V * V * climb_slope) * f.up;  // (W3)
  Vec3<T> const twist_slope = Vec3<T>{roll_second, T(0.0), T(0.0)} + kappa_slope * f.up + (kappa * roll_slope) * level;
  f.alpha = travel.acceleration * f.twist + (V * V) * twist_slope;  // (W3)

  // (W6): the step between the frames in double; its derivative along the line is known in closed form.
  double const here = value_of(travel.s);
  PlanStep const step = plan_step(line.curvature, here, distance);
  double const kappa_0 = line.curvature.at(here).value;
  double const c = std::cos(step.heading), s = std::sin(step.heading);
  T const moved = travel.s - here;
  T const heading = step.heading + (value_of(kappa) - kappa_0) * moved;
  T const c_yaw = cos(heading), s_yaw = sin(heading);
  f.origin = {step.x + (c - 1.0 + kappa_0 * step.y) * moved, step.y + (s - kappa_0 * step.x) * moved,
              rise.value - centre_rise(line.cant.at(travel.s).value).value};
  f.R = {
      {c_yaw, s_yaw, T(0.0)}, {-(s_yaw * c_roll), c_yaw * c_roll, s_roll}, {s_yaw * s_roll, -(c_yaw * s_roll), c_roll}};
  return f;
}

}  // namespace rollerrig
