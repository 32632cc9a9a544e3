#include <algorithm>
#include <cmath>

#include "rig/geometry/search.hpp"

namespace rig {
namespace {

/// How far a point of the wheel can have moved between two poses [m] (lever arm of a rotation: 1 m).
double motion_between(RelativePose<double> const& a, RelativePose<double> const& b) {
  auto const largest = [](Vec3<double> const& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
  return largest(a.o - b.o) + largest(a.R.ey - b.R.ey) + largest(a.R.ex - b.R.ex);
}

}  // namespace

ContactSearch::ContactSearch(WheelRollerPair const& pair) : pair_(&pair), first_(pair.wheel->start) {
  auto const n = static_cast<std::size_t>(std::floor((pair.wheel->end() - first_) / cell_width + 1e-9));
  cells_.resize(n);
  nodes_.resize(n + 1);
  node_foot_.resize(n + 1, 0.0);
  UniformSpline const& rail = *pair.rail;
  auto const bins = static_cast<std::size_t>(std::ceil((rail.end() - rail.start) / 1e-3)) + 1;
  rail_second_.assign(bins, 0.0);
  for (std::size_t i = 0; i <= rail.pieces.size(); ++i) {
    double const y = rail.start + rail.step * static_cast<double>(i);
    auto const bin = std::min(bins - 1, static_cast<std::size_t>((y - rail.start) / 1e-3));
    rail_second_[bin] = std::max(rail_second_[bin], std::abs(rail.at(std::min(y, rail.end())).second));
  }
}

double ContactSearch::steepest_rail(double y0, double y1) const {
  double const margin = 1e-3;
  int const last = static_cast<int>(rail_second_.size()) - 1;
  int const i0 = std::clamp(static_cast<int>((std::min(y0, y1) - margin - pair_->rail->start) / 1e-3), 0, last);
  int const i1 = std::clamp(static_cast<int>((std::max(y0, y1) + margin - pair_->rail->start) / 1e-3), 0, last);
  double largest = 0.0;
  for (int i = i0; i <= i1; ++i) largest = std::max(largest, rail_second_[static_cast<std::size_t>(i)]);
  return largest;
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
  node_foot_[index] = f.foot_y;
  return n;
}

/// Newton on F inside a bracket, halving where Newton leaves it.
///
/// @param falling  +1: F(low) > 0 > F(high), a minimum of the gap; -1: F rises, a maximum
bool ContactSearch::polish(RelativePose<double> const& pose, double low, double high, double guess, double falling,
                           GapMinimum& root) const {
  double s = guess;
  double const resolution = 1e-14;  // of the abscissa [m]
  for (int iteration = 0; iteration < 60; ++iteration) {
    auto const f = reduce_with_slope(*pair_, pose, s);
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

/// The highest point of the gap between neighbouring minima: what tells two patches from one.
void ContactSearch::find_barriers(RelativePose<double> const& pose) {
  for (int i = 0; i + 1 < count_; ++i) {
    auto const k = static_cast<std::size_t>(i);
    double const low = minima_[k].s;
    double const high = minima_[k + 1].s;
    double guess = barriers_[k].s;
    if (!(guess > low && guess < high)) guess = 0.5 * (low + high);
    if (!polish(pose, low, high, guess, -1.0, barriers_[k])) barriers_[k] = {guess, 1.0, 1.0};
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
  GapMinimum root;
  double const guess = s0 + (s1 - s0) * f0 / (f0 - f1);
  if (!polish(pose, s0, s1, guess, 1.0, root)) return;
  cell.root = root.s;
  keep(root, reach);
}

/// Moves the end of a cell whose normal misses the generatrix to where the first one meets it.
void ContactSearch::trim(RelativePose<double> const& pose, double& first, Node& a, double& last, Node& b) const {
  double& bad = a.valid ? last : first;
  Node& end = a.valid ? b : a;
  double const good = a.valid ? first : last;
  double valid = good;
  double invalid = bad;
  end = a.valid ? a : b;
  while (std::abs(invalid - valid) > 1e-6) {
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

/// Looks at one cell afresh: its roots, and the motion up to which what was found stands.
void ContactSearch::analyse(RelativePose<double> const& pose, int index, double reach) {
  Cell& cell = cells_[static_cast<std::size_t>(index)];
  Node a = node(pose, index);
  Node b = node(pose, index + 1);
  // Wheel points beside the generatrix are at least that far from it, wherever their normals go.
  auto const beside = [this](Node const& n) { return std::max(pair_->rail->start - n.y, n.y - pair_->rail->end()); };
  bool const same_side = (a.y < pair_->rail->start) == (b.y < pair_->rail->start);
  if (double const distance = std::min(beside(a), beside(b)); same_side && distance > std::max(reach, 0.2e-3)) {
    cell.state = CellState::unknown;
    cell.gap_until = motion_ + 0.5 * distance;
    return;
  }
  double const partial_until = motion_ + 0.1e-3;
  bool const partial = !a.valid || !b.valid;  // the wheel's normals miss the generatrix somewhere here
  if (!a.valid && !b.valid) {
    cell.state = CellState::unknown;
    cell.gap_until = partial_until;
    return;
  }
  double first = left(index);
  double last = left(index + 1);
  if (partial) trim(pose, first, a, last, b);
  double const h = last - first;
  double const f_max = std::max(std::abs(a.residual), std::abs(b.residual));
  // |d gap / d s| <= |F| across the cell, with room for what the cubic does between its ends.
  double const slack = h * (f_max + 0.25 * h * std::max(std::abs(a.gradient), std::abs(b.gradient)));
  double const lowest_gap = std::min(a.gap, b.gap) - slack;
  cell.gap_until = motion_ + 0.5 * std::max(0.0, lowest_gap);
  if (partial) cell.gap_until = std::min(cell.gap_until, partial_until);
  if (lowest_gap > reach) {
    cell.state = CellState::unknown;
    return;
  }

  auto const [cut, value, cuts] = monotone_stretches(pose, first, h, a, b);
  int changes = 0;
  double smallest = std::abs(value[0]);
  for (std::size_t i = 0; i < static_cast<std::size_t>(cuts); ++i) {
    changes += (value[i] > 0.0) != (value[i + 1] > 0.0);
    smallest = std::min(smallest, std::abs(value[i + 1]));
    roots_between(pose, cell, first + h * cut[i], value[i], first + h * cut[i + 1], value[i + 1], reach);
  }

  double const safety = 1.25;
  double const slope =
      std::max(std::abs(pair_->wheel->at(left(index)).slope), std::abs(pair_->wheel->at(left(index + 1)).slope));
  cell.slope = slope;
  cell.turn_rate = safety * (1.0 + slope * slope);
  cell.shift_rate = safety * steepest_rail(node_foot_[static_cast<std::size_t>(index)],
                                           node_foot_[static_cast<std::size_t>(index) + 1]);
  cell.seen = now_;
  cell.margin = smallest;
  bool const minimum = value[0] > 0.0 && b.residual <= 0.0;
  cell.state = partial       ? CellState::unknown
               : changes > 1 ? CellState::many
               : minimum     ? CellState::one_minimum
                             : CellState::empty;
}

/// Whether the roots in a cell are still those it was left with: F has not moved by more than its margin.
bool ContactSearch::still_holds(Cell const& cell) const {
  if (cell.state != CellState::empty && cell.state != CellState::one_minimum) return false;
  double const x = std::abs(now_.x - cell.seen.x);
  double const yaw = std::abs(now_.yaw - cell.seen.yaw);
  double const roll = std::abs(now_.roll - cell.seen.roll);
  // Yaw and longitudinal offset turn the slope only through the small longitudinal component of the normal.
  double const turn = roll + 0.1 * yaw + 0.2 * x;
  double const shift = std::abs(now_.y - cell.seen.y) + (pair_->wheel_radius + 0.05) * roll + 0.05 * yaw + 0.1 * x +
                       cell.slope * std::abs(now_.z - cell.seen.z);
  double const reach = 0.8e-3;  // the generatrix' second derivative was bounded one millimetre around the cell
  return shift < reach && cell.turn_rate * turn + cell.shift_rate * shift < cell.margin;
}

void ContactSearch::move_to(RelativePose<double> const& pose) {
  ++call_;
  count_ = 0;
  motion_ += motion_between(pose, last_pose_);
  last_pose_ = pose;
  now_ = {pose.o.x, pose.o.y, pose.o.z, pose.R.ey.z, pose.R.ex.y};
}

int ContactSearch::find_all(RelativePose<double> const& pose, double reach) {
  move_to(pose);
  for (int i = 0; i < static_cast<int>(cells_.size()); ++i) analyse(pose, i, reach);
  if (reach == 0.0) find_barriers(pose);
  return count_;
}

int ContactSearch::find_indented(RelativePose<double> const& pose) {
  move_to(pose);
  for (int i = 0; i < static_cast<int>(cells_.size()); ++i) {
    Cell& cell = cells_[static_cast<std::size_t>(i)];
    if (motion_ < cell.gap_until) continue;
    if (still_holds(cell)) {
      if (cell.state == CellState::empty) continue;
      GapMinimum root;
      if (polish(pose, left(i), left(i + 1), cell.root, 1.0, root)) {
        cell.root = root.s;
        if (root.gap > 0.0) cell.gap_until = motion_ + 0.5 * root.gap;  // the lowest gap of the whole cell
        keep(root, 0.0);
        continue;
      }
    }
    analyse(pose, i, 0.0);
  }
  find_barriers(pose);
  return count_;
}

}  // namespace rig
