// track/rail_offset.hpp - one rail beside its place in the model: displacement of its head and lean over arc length.
//
//   gauge and inclination that change along the line -> [RailLayout] -> RailOffset <- irregularity
#pragma once
#include <cmath>

#include "rollerrig/math/spline.hpp"
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

  bool empty() const { return period <= 0.0; }

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

}  // namespace rollerrig
