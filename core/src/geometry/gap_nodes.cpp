#include "rollerrig/geometry/gap_nodes.hpp"

#include <algorithm>
#include <span>

#include "rollerrig/geometry/lane_pair.hpp"

namespace rollerrig {
namespace {

using V = Lanes<native_lanes>;
constexpr double no_gap = 1.0;  // where the normal misses the generatrix [m]
using Row = std::array<double, GapNodes::capacity + native_lanes>;

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

V load(double const* x) {
  V out;
  load_lanes(x, out);
  return out;
}

/// Gap at a row of nodes. One step to the generatrix and series for small angles: exact enough to see which nodes overlap; the
/// sign of the gap is that of the wheel point's height over the generatrix.
template <bool round>
[[gnu::always_inline]] inline void look(WheelRollerPair const& pair, GapNodes const& nodes,
                                        RelativePose<double> const& pose, int first, int last, double* gap) {
  auto const& R = pose.R;
  UniformSpline const& rail = *pair.rail;
  double const kappa = pair.geometry_curvature();
  double const last_piece = static_cast<double>(rail.pieces.size()) - 1.0;
  double const inverse_step = 1.0 / rail.step;
  for (int k = first; k < last; k += native_lanes) {
    V const slope = load(&nodes.slope[at(k)]), cosine = load(&nodes.cosine[at(k)]);
    V const r = pair.wheel_radius + load(&nodes.height[at(k)]);
    V const y_r = pair.tape_circle_y + load(&nodes.abscissa[at(k)]);
    // Towards the apex, (1), not scaled to one: (t, 1).
    V w_x(R.ex.x), w_y(R.ey.x), w_z(R.ez.x), t(0.0);
    if constexpr (round) {
      V const apex = y_r + r * slope;
      t = kappa * (pose.o.x + apex * R.ey.x) / (1.0 + kappa * (pose.o.z + apex * R.ey.z));
      w_x = w_x - t * R.ex.z, w_y = w_y - t * R.ey.z, w_z = w_z - t * R.ez.z;
    }
    V const c = slope * w_y;
    V const excess = w_y * w_y - t * t;
    V const inverse_rho2 = 1.0 + excess * (1.0 + excess * (1.0 + excess * (1.0 + excess)));
    V const off = 0.5 * (excess + c * c);
    V const root = 1.0 - off * (1.0 + 0.5 * off * (1.0 + off * (1.0 + 1.25 * off)));
    V const sine = (c * w_x + w_z * root) * inverse_rho2;
    V const cos_alpha = (w_x * root - c * w_z) * inverse_rho2;
    V const n_y = (R.ex.y * sine - R.ey.y * slope - R.ez.y * cos_alpha) * cosine;
    V n_u = (R.ex.z * sine - R.ey.z * slope - R.ez.z * cos_alpha) * cosine;
    V const r_sine = r * sine, r_cos = r * cos_alpha;
    V const p_y = pose.o.y + R.ex.y * r_sine + R.ey.y * y_r - R.ez.y * r_cos;
    V height = pose.o.z + R.ex.z * r_sine + R.ey.z * y_r - R.ez.z * r_cos;
    if constexpr (round) {
      V const n_x = (R.ex.x * sine - R.ey.x * slope - R.ez.x * cos_alpha) * cosine;
      V const t2 = t * t;
      n_u = (n_x * t + n_u) * (1.0 - t2 * (0.5 - 0.375 * t2));
      V const p_x = pose.o.x + R.ex.x * r_sine + R.ey.x * y_r - R.ez.x * r_cos;
      V const level = 1.0 + kappa * height, turn = kappa * p_x / level;
      height = height + 0.5 * turn * p_x * (1.0 - 0.25 * turn * turn);
    }
    V const y = p_y - pair.rail_origin_y;
    auto const place = table_place(clamped(V((y - rail.start) * inverse_step), 0.0, last_piece));
    RowsOf<V> row;
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = rail.pieces[at(index_in(place.index, i))].data();
    auto const h = turned(row);
    V const u = y - (rail.start + rail.step * place.number);
    V const value = ((h[3] * u + h[2]) * u + h[1]) * u + h[0];
    V const rail_slope = (3.0 * h[3] * u + 2.0 * h[2]) * u + h[1];
    V const fall = rail_slope * n_y - n_u;
    V const distance = (height - value) / select(fall > parallel_line, fall, V(1.0));
    V const foot = y + distance * n_y;
    auto const meets = fall > parallel_line && foot > V(rail.start) && foot < V(rail.end());
    store_lanes(select(meets, distance, V(no_gap)), gap + k - first);
  }
}

/// One wheel in one pose.
class Scan {
 public:
  Scan(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose)
      : pair_(pair), nodes_(nodes), pose_(pose), h_(nodes.step()) {}

  GapScan run() {
    // Nodes above the generatrix: beyond its ends there is nothing to touch.
    double const shift = pair_.rail_origin_y - pose_.o.y - pair_.tape_circle_y;
    double const reach = 5e-3 * pair_.size;  // turned and leaning wheels
    first_ = std::max(0, nodes_.first_from(shift + pair_.rail->start - reach) / native_lanes * native_lanes);
    int const last = std::min(nodes_.count(), nodes_.first_from(shift + pair_.rail->end() + reach) + 2);
    count_ = last - first_;
    if (count_ < 3) return out_;
    if (pair_.geometry_curvature() != 0.0)
      look<true>(pair_, nodes_, pose_, first_, last, gap_.data());
    else
      look<false>(pair_, nodes_, pose_, first_, last, gap_.data());
    Row const& g = gap_;
    double const near = deepest_hidden * h_ * h_;
    if (g[0] < 0.0) open({place(0), place(0), place(0), false});
    for (int k = 0; k + 1 < count_; ++k) {
      if (std::min(g[at(k)], g[at(k + 1)]) > near) continue;  // nearly all are
      cell(point(k - 1), point(k), point(k + 1), point(k + 2), 0);
    }
    if (open_) close({place(count_ - 1), place(count_ - 1), place(count_ - 1), false});
    return out_;
  }

 private:
  struct Point {
    double position, gap;
    bool found() const { return gap < no_gap; }
    bool inside() const { return gap < 0.0; }
  };
  /// Between two nodes h apart the gap lies at most this times h^2 below the lower one: flange root on rail corner [1/m].
  static constexpr double deepest_hidden = 50.0;
  static constexpr int levels = 3;
  static constexpr double narrow = 5.0;  ///< regions of fewer nodes are looked at closer
  static constexpr int inner = 8;        ///< nodes laid between two

  double place(int k) const { return h_ * (first_ + k); }
  Point point(int k) const { return {place(k), k < 0 || k >= count_ ? no_gap : gap_[at(k)]}; }

  /// The stretch from b to c, with the nodes beside it.
  void cell(Point const& a, Point const& b, Point const& c, Point const& d, int level) {
    if (b.found() != c.found()) {
      Point const& meets = b.found() ? b : c;
      if (!meets.inside()) return refine(b, c, level);
      if (c.found()) return open(profile_end(c, b));
      note_extreme(a, b, c);
      close(profile_end(b, c));
    } else if (!b.inside() && c.inside()) {
      open(end(a, b, c, d));
    } else if (b.inside() && !c.inside()) {
      note_extreme(a, b, c);
      close(end(d, c, b, a));
    } else if (!b.inside()) {
      dip(a, b, c, d, level);
    }
    if (b.inside() && c.inside()) note_extreme(a, b, c);
  }

  /// Minima and maxima at node b inside a region: by the parabola through the three.
  void note_extreme(Point const& a, Point const& b, Point const& c) {
    if (b.gap < lowest_.gap) lowest_ = {b.position, b.gap};
    if (!a.found() || !c.found()) return;
    double const left = b.gap - a.gap, right = c.gap - b.gap;
    bool const low = left <= 0.0 && right > 0.0, high = left >= 0.0 && right < 0.0;
    if (!low && !high) return;
    double const h = b.position - a.position, k = c.position - b.position;
    double const bend = right / k - left / h, slope = (right / k * h + left / h * k) / (h + k);
    double const step = std::clamp(-slope * 0.5 * (h + k) / bend, -h, k);
    GapExtreme const e{b.position + step, b.gap + 0.5 * slope * step};
    if (low) return add_minimum(e);
    if (e.gap > rise_.gap) rise_ = e;
  }

  /// Where the gap vanishes between b, outside, and c, inside: the cubic through four nodes, or the chord where one is missing.
  static RegionEnd end(Point const& a, Point const& b, Point const& c, Point const& d) {
    double const h = c.position - b.position;
    double t = b.gap / (b.gap - c.gap);
    if (a.found() && d.found() && std::abs(b.position - a.position - h) < 1e-3 * std::abs(h)) {
      double const m0 = 0.5 * (c.gap - a.gap), m1 = 0.5 * (d.gap - b.gap), jump = c.gap - b.gap;
      double const c2 = 3.0 * jump - 2.0 * m0 - m1, c3 = m0 + m1 - 2.0 * jump;
      for (int i = 0; i < 2; ++i) {
        double const next = t - (((c3 * t + c2) * t + m0) * t + b.gap) / ((3.0 * c3 * t + 2.0 * c2) * t + m0);
        if (next > 0.0 && next < 1.0) t = next;
      }
    }
    return {b.position + h * t, c.position, b.position, true};
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
    region_ = {left, {}, out_.minima, out_.minima};
  }

  void close(RegionEnd const& right) {
    if (!open_) return;
    open_ = false;
    if (out_.regions == max_regions || (!has_minimum_ && out_.minima == GapScan::most_minima)) return;
    if (!has_minimum_) add_minimum(lowest_);
    region_.right = right;
    if (right.position - region_.left.position < narrow * h_) {
      look_closer(region_.left);
      look_closer(region_.right);
    }
    region_.last = out_.minima - 1;
    out_.region[at(out_.regions++)] = region_;
  }

  /// Points between two, exact, with both.
  std::array<Point, inner + 2> between(Point const& a, Point const& b) {
    if (!lanes_ready_) {
      for (int i = 0; i < native_lanes; ++i) {
        lane_pair_.set(i, pair_, nodes_.arc().abscissae());
        set_lane(lane_pose_, i, pose_);
      }
      lanes_ready_ = true;
    }
    double const h = (b.position - a.position) / (inner + 1);
    std::array<Point, inner + 2> row;
    row[0] = a;
    for (int k = 0; k < inner; k += native_lanes) {
      V s(0.0);
      for (int i = 0; i < native_lanes; ++i) set_lane(s, i, nodes_.arc().abscissa(a.position + h * (k + i + 1)));
      auto const g = gap_along_normal(lane_pair_, lane_pose_, s);
      for (int i = 0; i < native_lanes && k + i < inner; ++i)
        row[at(k + i + 1)] = {a.position + h * (k + i + 1), lane(g.found, i) ? lane(g.gap, i) : no_gap};
    }
    row[inner + 1] = b;
    return row;
  }

  /// The end of a region that is narrow for its nodes.
  void look_closer(RegionEnd& e) {
    double const h = std::abs(e.outside - e.inside);
    if (!e.is_root || !(h > 0.5 * h_)) return;
    auto const row = between({e.outside, 1.0}, {e.inside, -1.0});
    for (std::size_t i = 1; i < row.size(); ++i)
      if (row[i].inside() || i + 1 == row.size()) {
        Point const before = i > 2 ? row[i - 2] : Point{0.0, no_gap};
        Point const behind = i + 2 < row.size() ? row[i + 1] : Point{0.0, no_gap};
        Point const from = i > 1 ? row[i - 1] : Point{e.outside, 1e-6};
        Point const to = i + 1 < row.size() ? row[i] : Point{e.inside, -1e-6};
        e = end(before, from, to, behind);
        return;
      }
  }

  void refine(Point const& a, Point const& b, int level) {
    if (level == levels) return;
    auto const row = between(a, b);
    for (std::size_t i = 0; i + 1 < row.size(); ++i)
      cell(i > 0 ? row[i - 1] : Point{0.0, no_gap}, row[i], row[i + 1],
           i + 2 < row.size() ? row[i + 2] : Point{0.0, no_gap}, level + 1);
  }

  /// b and c are apart: does the gap dip below zero between them? It falls towards the stretch from both sides.
  void dip(Point const& a, Point const& b, Point const& c, Point const& d, int level) {
    double const h = c.position - b.position;
    if (std::min(b.gap, c.gap) > deepest_hidden * h * h) return;
    // A curve that bends upwards lies above the lines through its neighbours, beyond them.
    double const falls = a.found() ? (a.gap - b.gap) / (b.position - a.position) : 1.0;
    double const rises = d.found() ? (d.gap - c.gap) / (d.position - c.position) : 1.0;
    double const allowance = 0.05 * h;  // for a curve that bends downwards there: its slope changes by as much
    double const left = falls + allowance, right = rises + allowance;
    if (left + right <= 0.0) return;
    if (left <= 0.0 || right <= 0.0) return;
    double const crossing = (b.gap * right + c.gap * left - left * right * h) / (left + right);
    if (crossing >= 0.0) return;
    refine(b, c, level);
  }

  /// The gap is negative at one point and at the next the normal misses the generatrix.
  RegionEnd profile_end(Point inside, Point outside) {
    for (int level = 0; level < levels; ++level) {
      auto const row = between(inside, outside);
      for (std::size_t i = 1; i < row.size(); ++i) {
        if (!row[i].found()) {
          inside = row[i - 1], outside = row[i];
          break;
        }
        if (!row[i].inside()) return end({0.0, no_gap}, row[i], row[i - 1], {0.0, no_gap});
      }
    }
    return {inside.position, inside.position, inside.position, false};
  }

  WheelRollerPair const& pair_;
  GapNodes const& nodes_;
  RelativePose<double> const& pose_;
  double h_;
  int first_{0}, count_{0};
  Row gap_;
  GapScan out_;
  InterpenetrationRegion region_;
  GapExtreme rise_{0.0, -no_gap}, lowest_;
  bool open_{false}, has_minimum_{false}, lanes_ready_{false};
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
  double const length = arc_.length(std::clamp(s, abscissa.front(), abscissa[static_cast<std::size_t>(count_ - 1)]));
  return std::clamp(static_cast<int>(length / step_), 0, count_ - 1);
}

GapScan scan_gap(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose) {
  return Scan(pair, nodes, pose).run();
}

}  // namespace rollerrig
