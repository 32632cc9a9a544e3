#include "rollerrig/geometry/interpenetration.hpp"

#include <cmath>

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct End {
  double s;
  bool is_root;
};

/// From a minimum outwards to where the surfaces part: steps until the gap is positive, then Newton inside that bracket.
End find_end(WheelRollerPair const& pair, RelativePose<double> const& pose, GapMinimum const& minimum, double limit) {
  double const direction = limit > minimum.s ? 1.0 : -1.0;
  double const slope = pair.wheel->at(minimum.s).slope;
  double const bend = std::max(1e-3, -minimum.gradient / std::sqrt(1.0 + slope * slope));  // second derivative [1/m]
  double step = std::sqrt(-2.0 * minimum.gap / bend);
  double inside = minimum.s;
  double outside = minimum.s + direction * step;
  ReducedSlope f;
  for (int i = 0; i < 60; ++i) {
    bool const beyond = direction * (outside - limit) >= 0.0;
    if (beyond) outside = limit;
    f = reduce_with_slope(pair, pose, outside);
    if (f.found && f.gap >= 0.0) break;
    if (!f.found || beyond) {
      // A profile ends: the last abscissa that still meets the other one.
      double missing = outside;
      if (f.found) return {outside, false};
      while (std::abs(missing - inside) > 1e-7) {
        double const middle = 0.5 * (missing + inside);
        auto const there = reduce_with_slope(pair, pose, middle);
        if (there.found && there.gap >= 0.0) {
          outside = middle;
          f = there;
          break;
        }
        (there.found ? inside : missing) = middle;
      }
      if (f.found) break;
      return {inside, false};
    }
    inside = outside;
    outside += direction * step;
    step *= 1.5;
  }
  double s = outside;
  double const resolution = 3e-9;  // of a step [m]: the next one, with a slope good to some thousandths, is below 1e-11
  for (int i = 0; i < 60; ++i) {
    double next = s - f.gap / f.gap_slope;
    if (!(direction * (next - inside) > 0.0 && direction * (outside - next) >= 0.0)) next = 0.5 * (inside + outside);
    double const change = std::abs(next - s);
    s = next;
    if (change < resolution) break;
    f = reduce_with_slope(pair, pose, s);
    (f.found && f.gap < 0.0 ? inside : outside) = s;
  }
  return {s, true};
}

/// Slopes of the pieces' ends are given: cubic Hermite pieces.
UniformSpline hermite(double start, double step, std::vector<double> const& value, std::vector<double> const& slope) {
  UniformSpline spline{start, step, {}};
  for (std::size_t i = 0; i + 1 < value.size(); ++i) {
    double const jump = (value[i + 1] - value[i]) / step;
    spline.pieces.push_back({value[i], slope[i], (3.0 * jump - 2.0 * slope[i] - slope[i + 1]) / step,
                             (slope[i] + slope[i + 1] - 2.0 * jump) / (step * step)});
  }
  return spline;
}

}  // namespace

int find_regions(WheelRollerPair const& pair, RelativePose<double> const& pose, ContactSearch const& search,
                 std::array<InterpenetrationRegion, max_regions>& regions) {
  int const n = search.count();
  if (n == 0) return 0;
  // Which rises between neighbouring minima part two regions: those above the other surface; the highest ones if too many.
  std::array<char, ContactSearch::max_minima> parts{};
  int count = 1;
  for (int i = 0; i + 1 < n; ++i) count += parts[at(i)] = search.barrier(i).gap > 0.0;
  for (; count > max_regions; --count) {
    int lowest = -1;
    for (int i = 0; i + 1 < n; ++i)
      if (parts[at(i)] && (lowest < 0 || search.barrier(i).gap < search.barrier(lowest).gap)) lowest = i;
    parts[at(lowest)] = 0;
  }
  int found = 0;
  for (int first = 0; first < n;) {
    int last = first;
    while (last + 1 < n && !parts[at(last)]) ++last;
    double const lowest = first > 0 ? search.barrier(first - 1).s : pair.wheel->start;
    double const highest = last + 1 < n ? search.barrier(last).s : pair.wheel->end();
    End const left = find_end(pair, pose, search[first], lowest);
    End const right = find_end(pair, pose, search[last], highest);
    regions[at(found++)] = {left.s, right.s, left.is_root, right.is_root, first, last};
    first = last + 1;
  }
  return found;
}

ArcLength::ArcLength(UniformSpline const& profile) {
  auto const rate = [&](double s) {
    double const slope = profile.at(s).slope;
    return std::sqrt(1.0 + slope * slope);
  };
  double const step = 0.1e-3;
  auto const n = static_cast<std::size_t>(std::ceil((profile.end() - profile.start) / step - 1e-9));
  std::vector<double> length{0.0}, slope{rate(profile.start)};
  for (std::size_t i = 0; i < n; ++i) {
    double const s = profile.start + step * static_cast<double>(i);
    slope.push_back(rate(s + step));
    length.push_back(length.back() + step / 6.0 * (slope[i] + 4.0 * rate(s + 0.5 * step) + slope.back()));
  }
  length_ = hermite(profile.start, step, length, slope);

  auto const m = static_cast<std::size_t>(length.back() / step) + 1;
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
  abscissa_ = hermite(0.0, step, abscissa, inverse);
}

}  // namespace rollerrig
