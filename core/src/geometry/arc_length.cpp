#include "rollerrig/geometry/arc_length.hpp"

#include <cmath>

namespace rollerrig {
namespace {

/// Slopes of the pieces' ends are given: cubic Hermite pieces.
UniformSpline hermite_spline(double start, double step, std::vector<double> const& value,
                             std::vector<double> const& slope) {
  UniformSpline spline{start, step, {}};
  for (std::size_t i = 0; i + 1 < value.size(); ++i)
    spline.pieces.push_back(hermite(step, value[i], value[i + 1], slope[i], slope[i + 1]));
  return spline;
}

}  // namespace

ArcLength::ArcLength(UniformSpline const& profile) {
  auto const rate = [&](double s) {
    double const slope = profile.at(s).slope;
    return std::sqrt(1.0 + slope * slope);
  };
  double const step = 0.1e-3;
  auto const n = at(std::ceil((profile.end() - profile.start) / step - 1e-9));
  std::vector<double> length{0.0}, slope{rate(profile.start)};
  for (std::size_t i = 0; i < n; ++i) {
    double const s = profile.start + step * static_cast<double>(i);
    slope.push_back(rate(s + step));
    length.push_back(length.back() + step / 6.0 * (slope[i] + 4.0 * rate(s + 0.5 * step) + slope.back()));
  }
  length_ = hermite_spline(profile.start, step, length, slope);

  auto const m = at(length.back() / step) + 1;
  std::vector<double> abscissa, inverse;
  double s = profile.start;
  for (std::size_t i = 0; i <= m; ++i) {
    double const wanted = step * static_cast<double>(i);
    for (int k = 0; k < 4; ++k) {
      auto const at_s = length_.at(s);
      s -= (at_s.value - wanted) / at_s.slope;
    }
    abscissa.push_back(s);
    inverse.push_back(1.0 / length_.at(s).slope);
  }
  abscissa_ = hermite_spline(0.0, step, abscissa, inverse);
}

}  // namespace rollerrig
