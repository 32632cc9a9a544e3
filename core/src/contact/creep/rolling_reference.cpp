// Kalker's exact theory of rolling; see the header.
#include "rollerrig/contact/creep/rolling_reference.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "rollerrig/math/lu.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig {
namespace {

/// y ln(x + r) without cancellation, less terms that vanish in the differences below; 0 at y = 0.
double log_term(double x, double y) { return y == 0.0 ? 0.0 : y * std::asinh(x / std::abs(y)); }

using Column = Eigen::Map<Eigen::VectorXd const>;
constexpr int settle = 12;  // steps after which no element returns to stick

using Matrix = Eigen::Map<Eigen::MatrixXd const>;

}  // namespace

RectangleInfluence rectangle_influence(double x, double y, double dx, double dy, double nu) {
  // Cerruti: u = 1/(pi G) integral of {(1 - nu)/r + nu x x / r^3, nu x y / r^3, (1 - nu)/r + nu y y / r^3}, both bodies
  // together. Antiderivatives: 1/r^3 x x -> y ln(x + r), y y -> x ln(y + r), x y -> -r, and 1/r -> the sum of the first two.
  double sum_xx = 0.0;
  double sum_yy = 0.0;
  double sum_xy = 0.0;
  for (int i : {-1, 1})
    for (int j : {-1, 1}) {
      double const px = x + 0.5 * i * dx;
      double const py = y + 0.5 * j * dy;
      sum_xx += i * j * log_term(px, py);
      sum_yy += i * j * log_term(py, px);
      sum_xy -= i * j * std::hypot(px, py);
    }
  double const inverse = (1.0 - nu) * (sum_xx + sum_yy);
  return {(inverse + nu * sum_xx) / pi, nu * sum_xy / pi, (inverse + nu * sum_yy) / pi};
}

RollingGrid RollingGrid::for_ellipse(double a_over_b, double fineness) {
  // Long patches need more elements along, wide ones more rows.
  double const rows = 16.0 * fineness * std::pow(a_over_b, -0.18);
  double const elements = 24.0 * fineness * std::pow(a_over_b, 0.35);
  auto const at_least = [](double number, double least) {
    return static_cast<int>(std::lround(std::max(number, least)));
  };
  return {at_least(rows, 6.0), at_least(elements, 12.0)};
}

std::vector<PatchRow> RollingReference::ellipse_rows(double a_over_b, int rows) {
  double const a = std::sqrt(a_over_b);
  double const b = 1.0 / a;
  double const spacing = ellipse_spacing(a_over_b, rows);
  std::vector<PatchRow> list;
  for (int row = 0; row < rows; ++row) {
    double const across = -b + (row + 0.6) * spacing;
    double const half = a * std::sqrt(1.0 - square(across / b));
    list.push_back({across, 0.0, half, half * half});
  }
  return list;
}

RollingReference::RollingReference(std::vector<PatchRow> const& rows, double spacing, double nu, int elements)
    : elements_{elements} {
  std::vector<double> length;
  for (PatchRow const& row : rows) {
    across_.push_back(row.across);
    place_elements(row, spacing, length);
  }
  double total = 0.0;
  for (std::size_t i = 0; i < count(); ++i) total += bound[i] * area_[i];
  for (double& g : bound) g /= total;
  traction_x.assign(count(), 0.0);
  traction_y.assign(count(), 0.0);
  slipping_.assign(count(), 0);
  velocity_x_.assign(slip_x_.size(), 0.0);
  velocity_y_.assign(slip_x_.size(), 0.0);
  find_influences(length, spacing, nu);
}

void RollingReference::place_elements(PatchRow const& row, double spacing, std::vector<double>& length) {
  double const half = row.half_length;
  double const h = 2.0 * half / (elements_ + 0.1507);
  double const scale = row.load / (half * half);
  // Integrals over x of the bound, sqrt(half^2 - x^2), and of x times it.
  auto const primitive = [&](double s) {
    s = std::clamp(s / half, -1.0, 1.0);
    return 0.5 * half * half * (s * std::sqrt(1.0 - s * s) + std::asin(s));
  };
  auto const moment = [&](double s) { return -std::pow(std::max(half * half - s * s, 0.0), 1.5) / 3.0; };
  for (int i = 0; i <= elements_; ++i) {
    slip_x_.push_back(row.middle + half - (i + 0.32535) * h);
    slip_y_.push_back(row.across);
    if (i == elements_) break;
    double const at = half - (i + 0.82535) * h;
    x.push_back(row.middle + at);
    y.push_back(row.across);
    area_.push_back(h * spacing);
    length.push_back(h);
    double const front = i == 0 ? half : at + 0.5 * h;
    double const back = std::max(at - 0.5 * h, -half);
    double const integral = primitive(front) - primitive(back);
    arm_.push_back(row.middle + (moment(front) - moment(back)) / integral);
    bound.push_back(scale * integral / h);
  }
}

/// Slip at each point per unit of traction on each element: differences of displacements over an element's length.
void RollingReference::find_influences(std::vector<double> const& length, double dy, double nu) {
  std::size_t const n = count();
  b_xx_.resize(n * slip_x_.size());
  b_xy_.resize(n * slip_x_.size());
  b_yy_.resize(n * slip_x_.size());
  auto const per_row = static_cast<std::size_t>(elements_);
  for (std::size_t p = 0; p < slip_x_.size(); ++p) {
    double const h = length[p / (per_row + 1) * per_row];  // of this point's row
    for (std::size_t j = 0; j < n; ++j) {
      double const across = slip_y_[p] - y[j];
      auto const behind = rectangle_influence(slip_x_[p] - 0.5 * h - x[j], across, length[j], dy, nu);
      auto const ahead = rectangle_influence(slip_x_[p] + 0.5 * h - x[j], across, length[j], dy, nu);
      b_xx_[p * n + j] = (behind.xx - ahead.xx) / h;
      b_xy_[p * n + j] = (behind.xy - ahead.xy) / h;
      b_yy_[p * n + j] = (behind.yy - ahead.yy) / h;
    }
  }
}

/// @param factor  of the rows' creepages
void RollingReference::find_slip(double factor) {
  auto const points = static_cast<Eigen::Index>(slip_x_.size());
  auto const size = static_cast<Eigen::Index>(count());
  // Stored as [slip point][element], so the transpose is what Eigen sees.
  Matrix const xx(b_xx_.data(), size, points);
  Matrix const xy(b_xy_.data(), size, points);
  Matrix const yy(b_yy_.data(), size, points);
  Column const px(traction_x.data(), size);
  Column const py(traction_y.data(), size);
  Eigen::Map<Eigen::VectorXd> vx(velocity_x_.data(), points);
  Eigen::Map<Eigen::VectorXd> vy(velocity_y_.data(), points);
  vx = xx.transpose() * px + xy.transpose() * py;
  vy = xy.transpose() * px + yy.transpose() * py;
  auto const per_row = static_cast<std::size_t>(elements_ + 1);
  for (std::size_t p = 0; p < slip_x_.size(); ++p) {
    ReducedCreepage const& e = creepage_[p / per_row];
    velocity_x_[p] += factor * e.longitudinal;
    velocity_y_[p] += factor * (e.lateral + e.spin * slip_x_[p]);
  }
}

/// Newton's linear system for the present division into stick and slip, and the directions of the tractions.
struct RollingReference::NewtonSystem {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  std::vector<double> cosine, sine;
};

/// A sticking element: no slip at the point ahead of its centre.
void RollingReference::fill_sticking(std::size_t i, NewtonSystem& system) const {
  std::size_t const n = count();
  std::size_t const p = i + i / static_cast<std::size_t>(elements_);
  Eigen::Index const row = first_[i];
  double const* xx = &b_xx_[p * n];
  double const* xy = &b_xy_[p * n];
  double const* yy = &b_yy_[p * n];
  auto& m = system.matrix;
  system.right(row) = -velocity_x_[p];
  system.right(row + 1) = -velocity_y_[p];
  for (std::size_t j = 0; j < n; ++j) {
    Eigen::Index const k = first_[j];
    if (slipping_[j]) {
      m(row, k) = bound[j] * (xy[j] * system.cosine[j] - xx[j] * system.sine[j]);
      m(row + 1, k) = bound[j] * (yy[j] * system.cosine[j] - xy[j] * system.sine[j]);
    } else {
      m(row, k) = xx[j];
      m(row, k + 1) = m(row + 1, k) = xy[j];
      m(row + 1, k + 1) = yy[j];
    }
  }
}

/// A slipping element: no slip across its traction, of the mean of the points ahead of its centre and behind it.
void RollingReference::fill_slipping(std::size_t i, NewtonSystem& system) const {
  std::size_t const n = count();
  std::size_t const p = i + i / static_cast<std::size_t>(elements_);
  Eigen::Index const row = first_[i];
  double const* xx = &b_xx_[p * n];
  double const* xy = &b_xy_[p * n];
  double const* yy = &b_yy_[p * n];
  double const sx = 0.5 * (velocity_x_[p] + velocity_x_[p + 1]);
  double const sy = 0.5 * (velocity_y_[p] + velocity_y_[p + 1]);
  double const c = system.cosine[i];
  double const s = system.sine[i];
  auto& m = system.matrix;
  system.right(row) = sx * s - sy * c;
  for (std::size_t j = 0; j < n; ++j) {
    double const mxx = 0.5 * (xx[j] + xx[j + n]);
    double const mxy = 0.5 * (xy[j] + xy[j + n]);
    double const myy = 0.5 * (yy[j] + yy[j + n]);
    double const along_x = mxy * c - mxx * s;  // slip across the traction, per traction along x
    double const along_y = myy * c - mxy * s;
    Eigen::Index const k = first_[j];
    if (slipping_[j]) {
      m(row, k) = bound[j] * (along_y * system.cosine[j] - along_x * system.sine[j]);
    } else {
      m(row, k) = along_x;
      m(row, k + 1) = along_y;
    }
  }
  m(row, row) -= sx * c + sy * s;
}

/// One step of Newton's method for the present division into stick and slip. A sticking element has two unknowns, its
/// traction, and no slip; a slipping one has the direction of its traction, and no slip across that direction.
double RollingReference::newton_step() {
  std::size_t const n = count();
  first_.resize(n + 1);
  first_[0] = 0;
  for (std::size_t j = 0; j < n; ++j) first_[j + 1] = first_[j] + (slipping_[j] ? 1 : 2);
  NewtonSystem system{Eigen::MatrixXd(first_[n], first_[n]), Eigen::VectorXd(first_[n]), std::vector<double>(n),
                      std::vector<double>(n)};
  for (std::size_t j = 0; j < n; ++j) {
    system.cosine[j] = traction_x[j] / bound[j];
    system.sine[j] = traction_y[j] / bound[j];
  }
  for (std::size_t i = 0; i < n; ++i) slipping_[i] ? fill_slipping(i, system) : fill_sticking(i, system);
  Eigen::VectorXd const step = system.matrix.partialPivLu().solve(system.right);
  double change = 0.0;
  for (std::size_t j = 0; j < n; ++j) {
    Eigen::Index const k = first_[j];
    if (slipping_[j]) {
      double const turn = std::clamp(step(k), -1.0, 1.0);
      double const angle = std::atan2(traction_y[j], traction_x[j]) + turn;
      traction_x[j] = bound[j] * std::cos(angle);
      traction_y[j] = bound[j] * std::sin(angle);
      change = std::max(change, std::abs(turn));
    } else {
      traction_x[j] += step(k);
      traction_y[j] += step(k + 1);
      change = std::max(change, std::hypot(step(k), step(k + 1)) / bound[j]);
    }
  }
  return change;
}

/// Moves elements between stick and slip. Returns how many. An element on the border may change for ever; so the later steps
/// only take elements out of stick.
int RollingReference::revise(bool may_stick) {
  int moved = 0;
  auto const per_row = static_cast<std::size_t>(elements_);
  for (std::size_t j = 0; j < count(); ++j) {
    double const size = std::hypot(traction_x[j], traction_y[j]);
    if (!slipping_[j]) {
      if (size <= bound[j] * (1.0 + 1e-9)) continue;
      slipping_[j] = 1;
      traction_x[j] *= bound[j] / size;
      traction_y[j] *= bound[j] / size;
      ++moved;
      continue;
    }
    std::size_t const p = j + j / per_row;
    double const power =
        traction_x[j] * (velocity_x_[p] + velocity_x_[p + 1]) + traction_y[j] * (velocity_y_[p] + velocity_y_[p + 1]);
    if (power <= 0.0 || !may_stick) continue;
    slipping_[j] = 0;
    ++moved;
  }
  return moved;
}

/// Newton's method from the present tractions. True if it converged; counts its steps.
bool RollingReference::iterate(double factor, int& steps) {
  find_slip(factor);
  for (int step = 1; step <= max_steps; ++step) {
    ++steps;
    double const change = newton_step();
    find_slip(factor);
    int const moved = revise(step < settle);
    if (moved == 0 && change < tolerance) return true;
    if (moved) find_slip(factor);
  }
  return false;
}

void RollingReference::release() {
  std::ranges::fill(traction_x, 0.0);
  std::ranges::fill(traction_y, 0.0);
  std::ranges::fill(slipping_, 0);
}

RollingSolution RollingReference::solve(ReducedCreepage const& e) {
  std::vector<ReducedCreepage> rows;
  for (double place : across_) rows.push_back({e.longitudinal - e.spin * place, e.lateral, e.spin});
  return solve(rows);
}

RollingSolution RollingReference::solve(std::vector<ReducedCreepage> const& creepage) {
  creepage_ = creepage;
  RollingSolution s;
  s.converged = iterate(1.0, s.steps);
  if (!s.converged) {  // the last solution was too far away to start from: once more from full stick
    release();
    s.converged = iterate(1.0, s.steps);
  }
  if (!s.converged) {  // ... and along creepages that fall to this one, from nearly full sliding
    release();
    for (double factor : {16.0, 8.0, 4.0, 2.0, 1.4, 1.0}) s.converged = iterate(factor, s.steps);
  }
  if (!s.converged) {  // ... or that rise to it, from full stick
    release();
    for (double factor : {0.2, 0.4, 0.6, 0.8, 0.9, 1.0}) s.converged = iterate(factor, s.steps);
  }
  double stuck = 0.0;
  double all = 0.0;
  for (std::size_t j = 0; j < count(); ++j) {
    s.longitudinal += area_[j] * traction_x[j];
    s.lateral += area_[j] * traction_y[j];
    s.spin_moment += area_[j] * (arm_[j] * traction_y[j] - y[j] * traction_x[j]);
    stuck += slipping_[j] ? 0.0 : area_[j];
    all += area_[j];
  }
  s.adhesion = stuck / all;
  return s;
}

std::vector<RollingReference::RowForce> RollingReference::forces_of_rows() const {
  std::vector<RowForce> rows(across_.size());
  for (std::size_t j = 0; j < count(); ++j) {
    RowForce& row = rows[j / static_cast<std::size_t>(elements_)];
    row.longitudinal += area_[j] * traction_x[j];
    row.lateral += area_[j] * traction_y[j];
    row.moment += area_[j] * arm_[j] * traction_y[j];
  }
  return rows;
}

}  // namespace rollerrig
