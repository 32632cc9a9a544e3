#include <algorithm>
#include <cmath>

#include "rollerrig/geometry/search.hpp"

namespace rollerrig {
namespace {

/// How far a point of the wheel can have moved between two poses [m] (lever arm of a rotation: 1 m at full scale).
double motion_between(RelativePose<double> const& a, RelativePose<double> const& b, double lever) {
  auto const largest = [](Vec3<double> const& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
  return largest(a.o - b.o) + lever * (largest(a.R.ey - b.R.ey) + largest(a.R.ex - b.R.ex));
}

}  // namespace

ContactSearch::ContactSearch(WheelRollerPair const& pair)
    : pair_(&pair), size_(pair.size), cell_(cell_width * pair.size), first_(pair.wheel->start) {
  auto const n = static_cast<std::size_t>(std::floor((pair.wheel->end() - first_) / cell_ + 1e-9));
  cells_.resize(n);
  nodes_.resize(n + 1);
  node_rail_y_.resize(n + 1, 0.0);
  UniformSpline const& rail = *pair.rail;
  auto const bins = static_cast<std::size_t>(std::ceil((rail.end() - rail.start) / cell_)) + 1;
  lowest_second_.assign(bins, 0.0);
  highest_second_.assign(bins, 0.0);
  for (std::size_t i = 0; i <= rail.pieces.size(); ++i) {
    double const y = rail.start + rail.step * static_cast<double>(i);
    auto const bin = std::min(bins - 1, static_cast<std::size_t>((y - rail.start) / cell_));
    double const second = rail.at(std::min(y, rail.end())).second;
    lowest_second_[bin] = std::min(lowest_second_[bin], second);
    highest_second_[bin] = std::max(highest_second_[bin], second);
  }
}

/// Range of the generatrix' second derivative from one millimetre before to one behind a stretch, zero included.
void ContactSearch::bound_rail(double y0, double y1, double& lowest, double& highest) const {
  double const margin = cell_;
  int const last = static_cast<int>(lowest_second_.size()) - 1;
  int const i0 = std::clamp(static_cast<int>((std::min(y0, y1) - margin - pair_->rail->start) / cell_), 0, last);
  int const i1 = std::clamp(static_cast<int>((std::max(y0, y1) + margin - pair_->rail->start) / cell_), 0, last);
  lowest = highest = 0.0;
  for (int i = i0; i <= i1; ++i) {
    lowest = std::min(lowest, lowest_second_[static_cast<std::size_t>(i)]);
    highest = std::max(highest, highest_second_[static_cast<std::size_t>(i)]);
  }
}

ContactSearch::Node const& ContactSearch::node(RelativePose<double> const& pose, int i) {
  auto const index = static_cast<std::size_t>(i);
  Node& n = nodes_[index];
  if (n.call == call_) return n;
  n.call = call_;
  ++node_evaluations_;
  auto const f = reduce_with_slope(*pair_, pose, left(i));
  n.valid = f.found;
  n.residual = f.residual;
  n.gradient = f.gradient;
  n.gap = f.gap;
  n.y = f.y;
  node_rail_y_[index] = f.rail_y;
  return n;
}

/// Newton on F inside a bracket, halving where Newton leaves it.
///
/// @param falling  +1: F(low) > 0 > F(high), a minimum of the gap; -1: F rises, a maximum
bool ContactSearch::polish(RelativePose<double> const& pose, double low, double high, double guess, double falling,
                           GapMinimum& root, ReducedSlope& f) const {
  double s = guess;
  double const resolution = 1e-14;  // of the abscissa [m]
  for (int iteration = 0; iteration < 60; ++iteration) {
    f = reduce_with_slope(*pair_, pose, s);
    if (!f.found) return false;
    double const residual = f.residual;
    root = {s, f.gradient, f.gap};
    (falling * residual > 0.0 ? low : high) = s;
    bool const regular = falling * root.gradient < 0.0;
    double next = regular ? s - residual / root.gradient : 0.5 * (low + high);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    double const step = std::abs(next - s);
    if (step < resolution || high - low < resolution) return true;
    // Quadratic convergence: after a step below 1e-9 the error is far below the resolution.
    if (step < 1e-9 && regular) {
      root.s = next;  // the gap is stationary in s at the root
      return true;
    }
    s = next;
  }
  return false;
}

/// A minimum of the gap in a cell: polished, with what its next position is expected from.
bool ContactSearch::polish(RelativePose<double> const& pose, double low, double high, double guess, Cell& cell) const {
  ReducedSlope at_root;
  if (!polish(pose, low, high, guess, 1.0, cell.root, at_root)) return false;
  cell.root_slope = at_root.slope;
  cell.root_shift = at_root.shift_rate;
  cell.root_seen = now_;
  return true;
}

/// Where the minimum of a cell should be now, to first order in lateral and vertical shift and roll.
double ContactSearch::expected_root(Cell const& cell, double low, double high) const {
  double const roll = now_.roll - cell.root_seen.roll;
  double const slope = cell.root_slope;
  double const shift = now_.y - cell.root_seen.y + pair_->wheel_radius * roll -
                       slope * (now_.z - cell.root_seen.z + pair_->tape_circle_y * roll);
  double const rise = cell.root_shift * shift - (1.0 + slope * slope) * roll;
  return std::clamp(cell.root.s - rise / cell.root.gradient, low, high);
}

/// The highest point of the gap between neighbouring minima: what tells two patches from one.
void ContactSearch::find_barriers(RelativePose<double> const& pose) {
  for (int i = 0; i + 1 < count_; ++i) {
    auto const k = static_cast<std::size_t>(i);
    double const low = minima_[k].s;
    double const high = minima_[k + 1].s;
    double guess = barriers_[k].s;
    if (!(guess > low && guess < high)) guess = 0.5 * (low + high);
    ReducedSlope at_top;
    if (!polish(pose, low, high, guess, -1.0, barriers_[k], at_top)) barriers_[k] = {guess, 1.0, 1.0};
  }
}

void ContactSearch::keep(GapMinimum const& root, double reach) {
  if (!(root.gap < reach) || count_ == max_minima) return;
  int i = count_;
  while (i > 0 && minima_[static_cast<std::size_t>(i - 1)].s > root.s) {
    minima_[static_cast<std::size_t>(i)] = minima_[static_cast<std::size_t>(i - 1)];
    --i;
  }
  minima_[static_cast<std::size_t>(i)] = root;
  ++count_;
}

void ContactSearch::roots_between(RelativePose<double> const& pose, Cell& cell, double s0, double f0, double s1,
                                  double f1, double reach) {
  if (!(f0 > 0.0 && f1 <= 0.0)) return;
  double const guess = s0 + (s1 - s0) * f0 / (f0 - f1);
  if (polish(pose, s0, s1, guess, cell)) keep(cell.root, reach);
}

/// Moves the end of a cell whose normal misses the generatrix to where the first one meets it.
void ContactSearch::trim(RelativePose<double> const& pose, double& first, Node& a, double& last, Node& b) const {
  double& bad = a.valid ? last : first;
  Node& end = a.valid ? b : a;
  double const good = a.valid ? first : last;
  double valid = good;
  double invalid = bad;
  end = a.valid ? a : b;
  while (std::abs(invalid - valid) > 1e-6 * size_) {
    double const middle = 0.5 * (valid + invalid);
    auto const f = reduce_with_slope(*pair_, pose, middle);
    if (!f.found) {
      invalid = middle;
      continue;
    }
    valid = middle;
    end = {f.residual, f.gradient, f.gap, f.y, true, call_};
  }
  bad = valid;
}

/// Cuts a cell where the cubic through the values and slopes of F at both ends turns, and evaluates F there.
ContactSearch::Stretches ContactSearch::monotone_stretches(RelativePose<double> const& pose, double first, double h,
                                                           Node const& a, Node const& b) const {
  // F = f0 + m0 t + c2 t^2 + c3 t^3, t in 0..1.
  double const m0 = h * a.gradient;
  double const m1 = h * b.gradient;
  double const jump = b.residual - a.residual;
  double const c2 = 3.0 * jump - 2.0 * m0 - m1;
  double const c3 = m0 + m1 - 2.0 * jump;
  Stretches out{{0.0, 1.0, 1.0, 1.0}, {a.residual, b.residual, b.residual, b.residual}, 1};
  double const discriminant = c2 * c2 - 3.0 * c3 * m0;
  if (discriminant > 0.0) {
    double const q = -(c2 + std::copysign(std::sqrt(discriminant), c2));
    double t1 = c3 != 0.0 ? q / (3.0 * c3) : -1.0;
    double t2 = q != 0.0 ? m0 / q : -1.0;
    if (t1 > t2) std::swap(t1, t2);
    auto const inside = [](double t) { return t > 0.0 && t < 1.0; };
    if (inside(t1)) out.cut[static_cast<std::size_t>(out.count++)] = t1;
    if (inside(t2) && t2 > t1) out.cut[static_cast<std::size_t>(out.count++)] = t2;
  }
  for (std::size_t i = 1; i < static_cast<std::size_t>(out.count); ++i)
    out.value[i] = reduce_with_slope(*pair_, pose, first + h * out.cut[i]).residual;
  out.cut[static_cast<std::size_t>(out.count)] = 1.0;
  out.value[static_cast<std::size_t>(out.count)] = b.residual;
  return out;
}

/// How far a cell is from needing a look, from its ends alone; trims it to the part whose normals meet the generatrix.
///
/// @return whether its roots must be found; if not, the cell is left as unknown, with the motion until which that stands
bool ContactSearch::within_reach(RelativePose<double> const& pose, Cell& cell, Span& span, double reach,
                                 double ahead) const {
  auto& [first, last, a, b, partial] = span;
  cell.state = CellState::unknown;
  // Wheel points beside the generatrix are at least that far from it, wherever their normals go.
  auto const beside = [this](Node const& n) { return std::max(pair_->rail->start - n.y, n.y - pair_->rail->end()); };
  bool const same_side = (a.y < pair_->rail->start) == (b.y < pair_->rail->start);
  if (double const distance = std::min(beside(a), beside(b)); same_side && distance > std::max(reach, 0.2e-3 * size_)) {
    cell.asleep_until = motion_ + 0.5 * distance;
    return false;
  }
  double const partial_until = motion_ + 0.1e-3 * size_;
  partial = !a.valid || !b.valid;
  if (partial) {
    // High above the rail it does not matter where the normals stop meeting it.
    Node const& n = a.valid ? a : b;
    double const highest_fall = cell_ * (std::abs(n.residual) + cell_ * std::abs(n.gradient));
    if (!n.valid || n.gap - highest_fall > reach + 0.1e-3 * size_) {
      cell.asleep_until = partial_until;
      return false;
    }
    trim(pose, first, a, last, b);
  }
  double const h = last - first;
  double const f_max = std::max(std::abs(a.residual), std::abs(b.residual));
  // |d gap / d s| <= |F| across the cell, with room for what the cubic does between its ends.
  double const slack = h * (f_max + 0.25 * h * std::max(std::abs(a.gradient), std::abs(b.gradient)));
  double const lowest_gap = std::min(a.gap, b.gap) - slack;
  cell.asleep_until = motion_ + 0.5 * std::max(0.0, lowest_gap);
  if (partial) cell.asleep_until = std::min(cell.asleep_until, partial_until);
  return !(lowest_gap > reach + ahead);
}

/// Finds the roots of a cell between its monotone stretches, and how far F may move before their number changes.
void ContactSearch::find_roots(RelativePose<double> const& pose, Cell& cell, Span const& span, double reach) {
  double const first = span.first;
  double const h = span.last - first;
  auto const [cut, value, cuts] = monotone_stretches(pose, first, h, span.a, span.b);
  int changes = 0;
  double lowest_positive = 1e9;
  double highest_negative = -1e9;
  auto const count_in = [&](double f) {
    if (f > 0.0)
      lowest_positive = std::min(lowest_positive, f);
    else
      highest_negative = std::max(highest_negative, f);
  };
  count_in(value[0]);
  for (std::size_t i = 0; i < static_cast<std::size_t>(cuts); ++i) {
    changes += (value[i] > 0.0) != (value[i + 1] > 0.0);
    count_in(value[i + 1]);
    roots_between(pose, cell, first + h * cut[i], value[i], first + h * cut[i + 1], value[i + 1], reach);
  }
  cell.room_up = -highest_negative;
  cell.room_down = lowest_positive;
  bool const minimum = value[0] > 0.0 && span.b.residual <= 0.0;
  cell.state = span.partial  ? CellState::unknown
               : changes > 1 ? CellState::many
               : minimum     ? CellState::one_minimum
                             : CellState::empty;
}

/// Looks at one cell afresh: its roots, and the motion up to which what was found stands.
///
/// @param ahead  roots of cells that may be this much above `reach` are looked at too, for the next calls [m]
void ContactSearch::analyse(RelativePose<double> const& pose, int index, double reach, double ahead) {
  auto const i = static_cast<std::size_t>(index);
  Cell& cell = cells_[i];
  Span span{left(index), left(index + 1), node(pose, index), node(pose, index + 1)};
  if (!within_reach(pose, cell, span, reach, ahead)) return;
  find_roots(pose, cell, span, reach);
  cell.first_slope = pair_->wheel->at(left(index)).slope;
  cell.last_slope = pair_->wheel->at(left(index + 1)).slope;
  bound_rail(node_rail_y_[i], node_rail_y_[i + 1], cell.lowest_second, cell.highest_second);
  cell.seen = now_;
}

/// Whether the roots in a cell are still those it was left with: F has not moved by more than the room it had. An empty
/// cell is put to sleep for as long as it must stay empty.
bool ContactSearch::still_holds(Cell& cell) const {
  if (cell.state != CellState::empty && cell.state != CellState::one_minimum) return false;
  // On a flank F runs over its whole range within a cell: looked at each time it may be indented.
  if (std::max(std::abs(cell.first_slope), std::abs(cell.last_slope)) > 0.7) return false;
  double const x = std::abs(now_.x - cell.seen.x);
  double const yaw = std::abs(now_.yaw - cell.seen.yaw);
  double const roll = now_.roll - cell.seen.roll;
  // The generatrix slides along underneath by the shift along it; steep parts of the wheel do so when it moves up too.
  double const sideways = now_.y - cell.seen.y + pair_->wheel_radius * roll;
  double const upwards = now_.z - cell.seen.z + pair_->tape_circle_y * roll;
  double const at_first = sideways - cell.first_slope * upwards;
  double const at_last = sideways - cell.last_slope * upwards;
  double const largest = std::max(std::abs(at_first), std::abs(at_last));
  double const unsure = 0.25 * largest + 0.05 * size_ * (std::abs(roll) + yaw) + 0.1 * x;
  if (!(largest + unsure < 0.8 * cell_))
    return false;  // the second derivative was bounded one millimetre around the cell
  double const shift_low = std::min(at_first, at_last) - unsure;
  double const shift_high = std::max(at_first, at_last) + unsure;
  double const rise = std::max(std::max(cell.lowest_second * shift_low, cell.highest_second * shift_high),
                               std::max(cell.lowest_second * shift_high, cell.highest_second * shift_low));
  double const fall = std::min(std::min(cell.lowest_second * shift_low, cell.highest_second * shift_high),
                               std::min(cell.lowest_second * shift_high, cell.highest_second * shift_low));
  // Yaw and longitudinal offset turn the slope only through the small longitudinal component of the normal.
  double const steepest = std::max(cell.first_slope * cell.first_slope, cell.last_slope * cell.last_slope);
  double const gentlest = std::min(cell.first_slope * cell.first_slope, cell.last_slope * cell.last_slope);
  double const turn =
      (1.0 + steepest) * (0.25 * std::abs(roll) + 0.1 * yaw + 0.2 / size_ * x) + (steepest - gentlest) * std::abs(roll);
  double const turned = -(1.0 + steepest) * roll;
  double const room = std::min(cell.room_up - (std::max(0.0, 1.25 * rise) + turned + turn),
                               cell.room_down - (-std::min(0.0, 1.25 * fall) - turned + turn));
  if (!(room > 0.0)) return false;
  if (cell.state == CellState::empty) {
    // No step of the wheel changes F faster than this: the cell sleeps until the room could be used up.
    double const shift_per_motion = 1.25 * (1.0 + std::sqrt(steepest));
    double const second = std::max(-cell.lowest_second, cell.highest_second);
    double const rate = 1.25 * second * shift_per_motion + 1.5 * (1.0 + steepest);
    double const shift_left = (0.8 * cell_ - largest - unsure) / shift_per_motion;
    cell.asleep_until = motion_ + 0.9 * std::min(room / rate, shift_left);
  }
  return true;
}

void ContactSearch::move_to(RelativePose<double> const& pose) {
  ++call_;
  count_ = 0;
  motion_ += motion_between(pose, last_pose_, size_);
  last_pose_ = pose;
  now_ = {pose.o.x, pose.o.y, pose.o.z, pose.R.ey.z, pose.R.ex.y};
}

int ContactSearch::find_all(RelativePose<double> const& pose, double reach) {
  move_to(pose);
  for (int i = 0; i < static_cast<int>(cells_.size()); ++i) analyse(pose, i, reach, 0.0);
  if (reach == 0.0) find_barriers(pose);
  return count_;
}

int ContactSearch::find_indented(RelativePose<double> const& pose) {
  move_to(pose);
  for (int i = 0; i < static_cast<int>(cells_.size()); ++i) {
    Cell& cell = cells_[static_cast<std::size_t>(i)];
    if (motion_ < cell.asleep_until) continue;
    if (still_holds(cell)) {
      if (cell.state == CellState::empty) continue;
      double const low = left(i);
      double const high = left(i + 1);
      if (polish(pose, low, high, expected_root(cell, low, high), cell)) {
        double const gap = cell.root.gap;
        if (gap > 0.0) cell.asleep_until = motion_ + 0.5 * gap;  // the lowest gap of the whole cell
        keep(cell.root, 0.0);
        continue;
      }
    }
    analyse(pose, i, 0.0, 0.3e-3 * size_);
  }
  find_barriers(pose);
  return count_;
}

}  // namespace rollerrig
