#include "rollerrig/geometry/gap_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "rollerrig/geometry/reduction.hpp"
#include "rollerrig/math/dual.hpp"

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

namespace {

using V = Lanes<native_lanes>;
constexpr double no_gap = 1.0;  // where there is no generatrix under the wheel [m]
using Row = std::array<double, GapNodes::capacity + native_lanes>;

/// One wheel in one pose.
class Scan {
 public:
  /// @param reach          height over the other surface up to which it counts as inside [m]
  /// @param every_minimum  those that share a region, too, however near they are to each other
  Scan(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose, double reach,
       bool every_minimum)
      : pair_(pair),
        nodes_(nodes),
        pose_(pose),
        h_(nodes.step()),
        near_(steepest_hidden * h_),
        reach_(reach),
        every_minimum_(every_minimum) {
    lane_pair_.set_all(pair_, nodes_.arc().abscissae());
    lane_pose_ = lift<V>(pose_);
  }

  GapScan run() {
    // Nodes above the generatrix: beyond its ends there is nothing to touch.
    double const shift = pair_.rail_origin_y - pose_.o.y - pair_.tape_circle_y;
    double const reach = 5e-3 * pair_.size;  // turned and leaning wheels
    first_ = std::max(0, nodes_.first_from(shift + pair_.rail->start - reach) / native_lanes * native_lanes);
    int const last = std::min(nodes_.count(), nodes_.first_from(shift + pair_.rail->end() + reach) + 2);
    count_ = last - first_;
    if (count_ < 3) return out_;
    look();
    far_ =
        every_minimum_ && (reach_ > 0.0 || *std::min_element(gap_.begin(), gap_.begin() + count_) < -deep * pair_.size);
    if (far_)
      for (int k = 0; k < count_; ++k) {
        Point const p = by_reduction(point(k));
        gap_[at(k)] = p.gap, slope_[at(k)] = p.slope;
      }
    if (gap_[0] < 0.0) open({place(0), place(0), place(0), false});
    for (int k = 0; k + 1 < count_; ++k) {
      highest_between_ = std::max(highest_between_, gap_[at(k)]);
      if (std::min(gap_[at(k)], gap_[at(k + 1)]) > near_) continue;  // nearly all are
      cell(point(k), point(k + 1), 0);
    }
    if (open_) close({place(count_ - 1), place(count_ - 1), place(count_ - 1), false});
    return out_;
  }

 private:
  struct Point {
    double position, gap, slope;
    bool found() const { return gap < no_gap; }
    bool inside() const { return gap < 0.0; }
  };
  /// Between two nodes h apart the gap lies at most this times h below the lower one: a bend of radius 2.5 mm [-].
  static constexpr double steepest_hidden = 0.05;
  /// For a gap that bends downwards between two nodes: its slope changes by as much [-].
  static constexpr double slope_allowance = 0.01;
  static constexpr int hidden_levels = 2;      ///< nearer than 12 um a minimum and a maximum are about to merge
  static constexpr double hidden_turn = 3e-4;  ///< by as much a slope may turn back and forth between two nodes [-]
  static constexpr double nearly_touching = 0.1e-3;  ///< gap or overlap of full-scale surfaces [m]
  static constexpr double deep = 0.3e-3;             ///< overlap from which nodes are not to be trusted [m]
  static constexpr double settled_tilt = 3e-5;       ///< by which the gap is 1 nm above that of the lowest point [-]
  static constexpr int levels = 3;
  static constexpr int inner = 8;  ///< nodes laid between two

  double place(int k) const { return h_ * (first_ + k); }
  Point point(int k) const { return {place(k), gap_[at(k)], slope_[at(k)]}; }

  /// Gap and slope at every node: exact where they may be near contact.
  void look() {
    for (int k = 0; k < count_; k += native_lanes) {
      auto const load = [&](std::vector<double> const& row) { return loaded<V>(&row[at(first_ + k)]); };
      V const s = load(nodes_.abscissa);
      WheelCircle<V> const circle{pair_.wheel_radius + load(nodes_.height), load(nodes_.slope), load(nodes_.cosine),
                                  lane_pose_.o + V(pair_.tape_circle_y + s) * lane_pose_.R.ey};
      auto [sine, cosine] = facing_angle(lane_pair_, lane_pose_, circle);
      auto here = circle_point(lane_pair_, lane_pose_, circle, sine, cosine);
      // The lowest point of the circle lies lower by about tilt^2 / (4 curvature); twice that is sure.
      V const lowest = here.gap - reach_ - 0.5 * here.tilt * here.tilt * reciprocal(here.curvature);
      if (any(lowest < near_)) {  // found or not: the lowest point may be on the profile where the first is not
        for (int i = 0; i < 2 && any(here.tilt > settled_tilt || here.tilt < -settled_tilt); ++i) {
          turn_by(towards_lowest(here, circle), sine, cosine);
          here = circle_point(lane_pair_, lane_pose_, circle, sine, cosine);
        }
      }
      store(select(here.found, here.gap - reach_, V(no_gap)), &gap_[at(k)]);
      store(here.slope, &slope_[at(k)]);
    }
  }

  /// A point so far from the other surface, or so deep in it, that the osculating circle under it is no estimate of the foot on
  /// it, and may lie beyond its end: by (G2), exactly.
  Point by_reduction(Point const& p) const {
    if (p.found() && !(p.gap < near_ && std::abs(p.gap + reach_) > nearly_touching * pair_.size)) return p;
    using Along = Dual<1>;
    double const s = nodes_.arc().abscissa(p.position);
    auto const exact = reduce(pair_, lift<Along>(pose_), Along::variable(s, 0));
    if (!exact.rail_point.found) return {p.position, no_gap, 0.0};
    double const slope = pair_.wheel->at(s).slope;
    return {p.position, exact.gap.value - reach_, exact.gap.d[0] / std::sqrt(1.0 + slope * slope)};
  }

  /// The stretch from b to c.
  void cell(Point const& b, Point const& c, int level) {
    if (b.inside() && b.gap < lowest_.gap) lowest_ = {b.position, b.gap};
    if (b.found() != c.found()) {
      if (!(b.found() ? b : c).inside() || level < levels) return refine(b, c, level);
      return c.found() ? open({c.position, c.position, c.position, false})
                       : close({b.position, b.position, b.position, false});
    }
    if (!b.found()) return;
    if (every_minimum_ && level < hidden_levels && (b.inside() || c.inside()) && may_hide_extremes(b, c, level))
      return refine(b, c, level);
    bool const falls = b.slope < slope_allowance && c.slope > -slope_allowance;  // a minimum may lie between
    bool const climbs = b.slope > -slope_allowance && c.slope < slope_allowance;
    if (!b.inside() && !c.inside()) {
      highest_between_ = std::max({highest_between_, b.gap, c.gap});
      if (falls && level < levels && lower_bound(b, c) < 0.0) refine(b, c, level);
    } else if (b.inside() && c.inside()) {
      if (climbs && level < levels &&
          -lower_bound({b.position, -b.gap, -b.slope}, {c.position, -c.gap, -c.slope}) > 0.0)
        return refine(b, c, level);
      note_extreme(b, c);
    } else {
      // Steep and narrow ends within a node's distance, or a hidden extreme beside the end.
      if (level < 1 && (b.inside() ? b.slope < 0.0 : c.slope > 0.0)) return refine(b, c, level);
      if (c.inside()) open(end(b, c));
      if (every_minimum_) note_extreme(b, c);
      if (b.inside()) close(end(c, b));
    }
  }

  /// The lowest that a gap between b and c can be which bends upwards, up to the allowance.
  static double lower_bound(Point const& b, Point const& c) {
    double const h = c.position - b.position;
    double const left = slope_allowance - b.slope, right = slope_allowance + c.slope;
    if (!(left > 0.0 && right > 0.0)) return std::min(b.gap, c.gap);
    return (b.gap * right + c.gap * left - left * right * h) / (left + right);
  }

  /// Whether more minima and maxima may lie between b and c than their slopes tell: not where the slope runs straight, and its
  /// mean is that of both ends. A slope that dips to zero and back has a mean lower by half the lesser one at least; half of that
  /// is looked for. Where it changes its sign anyway, it is to run nearly straight; so is one near zero, once a finer row is laid.
  bool may_hide_extremes(Point const& b, Point const& c, int level) const {
    double const h = c.position - b.position, least = std::min(std::abs(b.slope), std::abs(c.slope));
    double const bend = std::abs((c.gap - b.gap) / h - 0.5 * (b.slope + c.slope));
    if (least < hidden_turn * h / h_) return level == 0 || bend > 0.05 * std::abs(b.slope - c.slope);
    return bend > ((b.slope < 0.0) != (c.slope < 0.0) ? 0.1 * std::abs(b.slope - c.slope) : 0.25 * least);
  }

  /// The cubic through both points with their slopes, t from 0 to 1.
  struct Cubic {
    std::array<double, 4> c;
    Cubic(Point const& a, Point const& b)
        : c(hermite(1.0, a.gap, b.gap, (b.position - a.position) * a.slope, (b.position - a.position) * b.slope)) {}
    double value(double t) const { return ((c[3] * t + c[2]) * t + c[1]) * t + c[0]; }
    double slope(double t) const { return (3.0 * c[3] * t + 2.0 * c[2]) * t + c[1]; }
    double bend(double t) const { return 6.0 * c[3] * t + 2.0 * c[2]; }
  };

  /// A minimum or maximum between two nodes inside a region.
  void note_extreme(Point const& b, Point const& c) {
    bool const low = b.slope <= 0.0 && c.slope > 0.0, high = b.slope > 0.0 && c.slope <= 0.0;
    if (!low && !high) return;
    Cubic const cubic(b, c);
    double t = b.slope / (b.slope - c.slope);
    for (int i = 0; i < 3; ++i)
      if (double const bend = cubic.bend(t); low ? bend > 0.0 : bend < 0.0)
        t = std::clamp(t - cubic.slope(t) / bend, 0.0, 1.0);
    GapExtreme const e{b.position + t * (c.position - b.position), cubic.value(t) + reach_, b.position, c.position};
    if (low) return add_minimum(e);
    if (e.gap > rise_.gap) rise_ = e;
  }

  /// Where the gap vanishes between b, outside, and c, inside: by the cubic, within the bracket.
  static RegionEnd end(Point const& b, Point const& c) {
    Cubic const cubic(b, c);
    double low = 0.0, high = 1.0, t = b.gap / (b.gap - c.gap);
    for (int i = 0; i < 6; ++i) {
      double const value = cubic.value(t);
      (value > 0.0 ? low : high) = t;
      double const next = t - value / cubic.slope(t);
      t = next > low && next < high ? next : 0.5 * (low + high);
    }
    return {b.position + t * (c.position - b.position), c.position, b.position, true};
  }

  void add_minimum(GapExtreme const& e) {
    if (out_.minima == GapScan::most_minima) return;
    if (has_minimum_) out_.rise[at(out_.minima - 1)] = rise_;
    rise_ = {e.position, -no_gap};
    out_.minimum[at(out_.minima++)] = e;
    has_minimum_ = true;
  }

  void open(RegionEnd const& left) {
    open_ = true;
    has_minimum_ = false;
    lowest_ = {left.inside, 0.0};
    rise_ = {left.inside, -no_gap};
    region_ = {left, {}, out_.minima, out_.minima, highest_between_};
  }

  void close(RegionEnd const& right) {
    if (!open_) return;
    open_ = false;
    highest_between_ = 0.0;
    if (out_.regions == max_regions || (!has_minimum_ && out_.minima == GapScan::most_minima)) return;
    if (!has_minimum_) add_minimum(lowest_);
    region_.right = right;
    region_.last = out_.minima - 1;
    if (region_.first > 0) {
      double const before = out_.region[at(out_.regions - 1)].right.position;
      out_.rise[at(region_.first - 1)] = {0.5 * (before + region_.left.position), region_.rise_before};
    }
    out_.region[at(out_.regions++)] = region_;
  }

  void refine(Point const& a, Point const& b, int level) {
    if (level == levels) return;
    double const h = (b.position - a.position) / (inner + 1);
    std::array<Point, inner + 2> row;
    row[0] = a, row[inner + 1] = b;
    for (int k = 0; k < inner; k += native_lanes) {
      std::array<V, 1> s;
      for (int i = 0; i < native_lanes; ++i) set_lane(s[0], i, nodes_.arc().abscissa(a.position + h * (k + i + 1)));
      std::array<CirclePoint<V>, 1> p;
      lowest_points(lane_pair_, lane_pose_, s, p);
      for (int i = 0; i < native_lanes && k + i < inner; ++i) {
        Point const here{a.position + h * (k + i + 1), lane(p[0].found, i) ? lane(p[0].gap, i) - reach_ : no_gap,
                         lane(p[0].slope, i)};
        row[at(k + i + 1)] = far_ ? by_reduction(here) : here;
      }
    }
    for (std::size_t i = 0; i + 1 < row.size(); ++i) cell(row[i], row[i + 1], level + 1);
  }

  WheelRollerPair const& pair_;
  GapNodes const& nodes_;
  RelativePose<double> const& pose_;
  double h_, near_, reach_;
  bool every_minimum_, far_{false};
  int first_{0}, count_{0};
  Row gap_, slope_;
  GapScan out_;
  InterpenetrationRegion region_;
  GapExtreme rise_{0.0, -no_gap}, lowest_;
  double highest_between_{no_gap};
  bool open_{false}, has_minimum_{false};
  LanePair<V> lane_pair_;
  RelativePose<V> lane_pose_;
};

}  // namespace

GapNodes::GapNodes(UniformSpline const& wheel, double size) : arc_(wheel), step_(node_distance * size) {
  double const length = arc_.length(wheel.end());
  step_ = std::max(step_, length / (capacity - native_lanes));
  count_ = static_cast<int>(length / step_) + 1;
  int const filled = (count_ + native_lanes - 1) / native_lanes * native_lanes + native_lanes;
  for (int k = 0; k < filled; ++k) {
    double const s = arc_.abscissa(step_ * std::min(k, count_ - 1));
    auto const z = wheel.at(s);
    abscissa.push_back(s);
    height.push_back(z.value);
    slope.push_back(z.slope);
    cosine.push_back(1.0 / std::sqrt(1.0 + z.slope * z.slope));
  }
}

int GapNodes::first_from(double s) const {
  double const length = arc_.length(std::clamp(s, abscissa.front(), abscissa[at(count_ - 1)]));
  return std::clamp(static_cast<int>(length / step_), 0, count_ - 1);
}

GapScan scan_gap(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose) {
  return Scan(pair, nodes, pose, 0.0, false).run();
}

GapScan scan_minima(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose,
                    double reach) {
  return Scan(pair, nodes, pose, reach, true).run();
}

namespace {

using Along = Dual<1>;

/// Newton on F near the scan's place, halving where it leaves the bracket. That is the scan's, and as much wider as the surfaces are
/// apart: so far off may the scan have taken the foot on the other one.
///
/// @param falling  +1: F falls through its root, a minimum of the gap; -1: it rises, a maximum
/// @return         whether there is such a root
bool polish(WheelRollerPair const& pair, ArcLength const& arc, RelativePose<Along> const& pose, GapExtreme const& near,
            double falling, GapRoot& root) {
  constexpr int most_steps = 40;
  constexpr double last_step = 1e-9;  // from here on a step of Newton leaves round-off [m]
  if (!(near.low < near.high)) return false;
  double const margin = std::abs(near.gap);
  double low = arc.abscissa(near.low) - margin, high = arc.abscissa(near.high) + margin;
  double s = arc.abscissa(near.position);
  for (int i = 0; i < most_steps; ++i) {
    auto const at = reduce(pair, pose, Along::variable(s, 0));
    if (!at.rail_point.found) return false;
    double const residual = at.residual.value, gradient = at.residual.d[0];
    root = {s, gradient, at.gap.value};
    (falling * residual > 0.0 ? low : high) = s;
    double const next = s - residual / gradient;
    bool const regular = falling * gradient < 0.0;
    if (regular && std::abs(next - s) < last_step) {
      root.s = next;  // the gap is stationary there
      return true;
    }
    if (high - low < last_step) return false;
    s = regular && next >= low && next <= high ? next : 0.5 * (low + high);
  }
  return false;
}

}  // namespace

GapMinima find_minima(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose,
                      double reach) {
  GapScan const scan = scan_minima(pair, nodes, pose, reach);
  auto const at_rest = lift<Along>(pose);
  GapMinima out;
  GapRoot top{0.0, 1.0, -1.0};  // the highest since the minimum before
  for (int i = 0; i < scan.minima; ++i) {
    GapRoot root;
    if (polish(pair, nodes.arc(), at_rest, scan.minimum[at(i)], 1.0, root) && root.gap < reach) {
      if (out.count > 0) out.barrier[out.count - 1] = top;
      out.minimum[out.count++] = root;
      top.gap = -1.0;
    }
    if (i + 1 == scan.minima) break;
    GapExtreme const& rise = scan.rise[at(i)];
    GapRoot maximum;
    if (!polish(pair, nodes.arc(), at_rest, rise, -1.0, maximum))
      maximum = {nodes.arc().abscissa(rise.position), 1.0, 1.0};
    if (maximum.gap > top.gap) top = maximum;
  }
  return out;
}

}  // namespace rollerrig
