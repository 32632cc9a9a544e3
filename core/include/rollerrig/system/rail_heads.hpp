// system/rail_heads.hpp - heads of rails that change along the line, and of rollers that change round them.
//
//   distance -> [which head, and how far on to the next] -> the head under a wheel
//
// Between two heads every height is on the straight line from one to the other, z = (1 - w) z_1 + w z_2, and on the same knots so are
// the coefficients of their splines. They are made anew wherever w is another one, some microseconds a wheel, and not at all where
// w = 0. The rise of the head under the wheel, z_2 - z_1 times dw/ds, is part of the surface's velocity. Source: docs/theory/track.md, (W14).
#pragma once
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "rollerrig/geometry/pair.hpp"
#include "rollerrig/math/curves.hpp"

namespace rollerrig {

/// Of all rails or rollers of one side.
struct RailHeads {
  std::vector<int> profiles{};  ///< of the model, in the order in which they are met; all on the same knots
  PiecewiseCubic place{};  ///< over the distance, with a continuous slope: 1.25 is a quarter of the way from [1] to [2]
  double period{0.0};      ///< of the distance, a roller's circumference [m]; 0: none

  static constexpr auto fields() {
    using P = RailHeads;
    return members(Member{"profiles", &P::profiles, an_index},
                   Member{"place", &P::place, "1", "number of the head that lies there, over the distance"},
                   Member{"period", &P::period, "m", "circumference of a roller; 0: none", not_negative});
  }
  bool empty() const { return profiles.empty(); }

  /// Which head, and dw/ds.
  template <Scalar T>
  CurvePoint<T> at(T const& distance) const {
    return place.at(period > 0.0 ? T(distance - period * std::floor(value_of(distance) / period)) : distance);
  }
};

/// The head under one wheel, with room for what lies between two.
class HeadUnderWheel {
 public:
  /// @param pieces  of the heads' splines
  explicit HeadUnderWheel(std::size_t pieces) { between_.pieces.resize(pieces); }

  /// Makes the head that lies at `place` of the heads.
  void move_to(double place, RailHeads const& heads,
               std::vector<std::shared_ptr<UniformSpline const>> const& profiles) {
    if (place == place_) return;
    place_ = place;
    auto const last = static_cast<double>(heads.profiles.size() - 1);
    double const whole = std::floor(std::clamp(place, 0.0, last)), w = std::clamp(place, 0.0, last) - whole;
    auto const head = [&](double i) {
      return profiles[static_cast<std::size_t>(heads.profiles[static_cast<std::size_t>(std::min(i, last))])].get();
    };
    first_ = head(whole), second_ = head(whole + 1.0);
    if (w == 0.0) return;
    between_.start = first_->start, between_.step = first_->step;
    for (std::size_t i = 0; i < between_.pieces.size(); ++i)
      for (std::size_t k = 0; k < 4; ++k)
        between_.pieces[i][k] = first_->pieces[i][k] + w * (second_->pieces[i][k] - first_->pieces[i][k]);
  }
  WheelRollerPair const& under(WheelRollerPair const& pair) {
    pair_ = pair;
    pair_.rail = place_ == std::floor(place_) ? first_ : &between_;
    return pair_;
  }
  /// How much higher the second head is than the first [m].
  template <Scalar T>
  T rise(T const& y) const {
    return second_->at(y).value - first_->at(y).value;
  }

 private:
  double place_{-1.0};
  UniformSpline const *first_{nullptr}, *second_{nullptr};
  UniformSpline between_{};
  WheelRollerPair pair_{};
};

}  // namespace rollerrig
