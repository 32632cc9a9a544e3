// geometry/arc_length.hpp - arc length along a wheel profile and back.
#pragma once
#include "rollerrig/math/spline.hpp"

namespace rollerrig {

/// Both functions as cubic pieces with exact slopes, 0.1 mm each.
class ArcLength {
 public:
  explicit ArcLength(UniformSpline const& profile);
  template <Scalar T>
  T length(T const& abscissa) const {
    return length_.at(abscissa).value;
  }
  template <Scalar T>
  T abscissa(T const& length) const {
    return abscissa_.at(length).value;
  }
  UniformSpline const& abscissae() const { return abscissa_; }

 private:
  UniformSpline length_, abscissa_;
};

}  // namespace rollerrig
