// track/rail_offset.hpp - one rail beside its place in the model: displacement of its head and lean over arc length.
//
//   gauge and inclination that change along the line -> [RailLayout] -> RailOffset <- irregularity
#pragma once
#include "rollerrig/math/piecewise_cubic.hpp"
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

}  // namespace rollerrig
