// integrate/past_points.hpp - what a multistep method keeps of its last steps, all of one length.
//
//   accepted points -> [the last seven] -> backward differences; the same for half or twice the step
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "rollerrig/integrate/differential_equation.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig::integrate {

/// Values: a vector, or one column for each of several solutions that take the same steps.
template <class Values = Vector>
class PastPoints {
 public:
  static constexpr int needed = 4;  ///< by a step: a cubic
  static constexpr int most = 7;    ///< the same for twice the step

  /// One point: states, and what their rates and those of the quadratures bend away from L x.
  struct Point {
    Values x, nonlinear;

    void state(auto& archive) { archive(x, nonlinear); }
  };

  /// Of the size of these.
  PastPoints(Values const& x, Values const& nonlinear) { point_.fill({x, nonlinear}); }

  void clear() { known_ = 0; }
  int known() const { return known_; }
  bool enough() const { return known_ >= needed; }
  /// k steps ago.
  Point const& operator[](int k) const { return point_[at(k)]; }

  /// A new last point, to be filled.
  Point& add() {
    for (int k = most - 1; k > 0; --k) swap(point_[at(k)], point_[at(k - 1)]);
    known_ = std::min(known_ + 1, most);
    return point_[0];
  }

  /// The points at twice the step.
  void double_step() {
    for (int k = 1; k < needed; ++k) swap(point_[at(k)], point_[at(2 * k)]);
    known_ = needed;
  }

  /// The points at half the step, between the known ones on the cubic through the last four; too few: the last alone.
  void halve_step() {
    if (!enough()) {
      known_ = 1;
      return;
    }
    mix({5.0 / 16, 15.0 / 16, -5.0 / 16, 1.0 / 16}, point_[4]);
    mix({-1.0 / 16, 9.0 / 16, 9.0 / 16, -1.0 / 16}, point_[5]);
    swap(point_[2], point_[1]);
    swap(point_[1], point_[4]);
    swap(point_[3], point_[5]);
    known_ = needed;
  }

  /// After L has lost `part`.
  void add_linear(Eigen::MatrixXd const& part) {
    for (int k = 0; k < known_; ++k) point_[at(k)].nonlinear.noalias() += part * point_[at(k)].x;
  }

  void state(auto& archive) {
    archive(point_);
    archive.within(known_, 0, most);
  }

 private:
  static void swap(Point& a, Point& b) {
    a.x.swap(b.x);
    a.nonlinear.swap(b.nonlinear);
  }
  void mix(std::array<double, needed> const& weight, Point& out) const {
    auto const sum = [&](auto member, Values& v) {
      v = weight[0] * point_[0].*member + weight[1] * point_[1].*member + weight[2] * point_[2].*member +
          weight[3] * point_[3].*member;
    };
    sum(&Point::x, out.x);
    sum(&Point::nonlinear, out.nonlinear);
  }

  std::array<Point, most> point_;
  int known_ = 0;
};

}  // namespace rollerrig::integrate
