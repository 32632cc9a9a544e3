// D of the creep table: tensor product of cubic B-splines, contracted one axis after the other.
//
// The four splines along spin and the components of D, one of padding, lie side by side in memory: sixteen numbers, of which
// the three outer axes make weighted sums, in registers.
#include "rollerrig/contact/creep/creep_table.hpp"

#include <algorithm>

namespace rollerrig {
namespace {

constexpr std::size_t components = 4;  // three and one of padding
constexpr std::size_t row_length = 4 * components;

constexpr std::size_t axes = 4;  // ln(a/b), longitudinal, lateral, spin
using PerAxis = std::array<double, axes>;

/// The coefficients of one place on the outer axes: [spin][component].
struct Row {
  static constexpr std::size_t width = native_lanes < 8 ? native_lanes : 8;
  using Part = Lanes<static_cast<int>(width)>;
  std::array<Part, row_length / width> part;

  Row() { part.fill(Part(0.0)); }
  void add(double w, float const* x) {
    for (std::size_t i = 0; i < part.size(); ++i) part[i] += w * loaded<Part>(x + width * i);
  }
  void add(double w, Row const& x) {
    for (std::size_t i = 0; i < part.size(); ++i) part[i] += w * x.part[i];
  }
  /// Contracted over spin.
  CreepTableValue<double> along_spin(std::array<PerAxis, 4> const& weight) const {
    std::array<double, row_length> x;
    for (std::size_t i = 0; i < part.size(); ++i) store(part[i], &x[width * i]);
    auto const sum = [&](std::size_t c) {
      return (weight[0][3] * x[c] + weight[1][3] * x[components + c]) +
             (weight[2][3] * x[2 * components + c] + weight[3][3] * x[3 * components + c]);
    };
    return {sum(0), sum(1), sum(2)};
  }
};

/// The four splines of each axis that are not zero at u, and their slopes; knots at whole numbers from 0 to `end`. The axes
/// are one vector.
struct Weights {
  std::array<int, axes> cell;
  std::array<PerAxis, 4> value, slope;  ///< [spline][axis]

  Weights(PerAxis const& u, PerAxis const& end) {
    constexpr double sixth = 1.0 / 6.0;
    for (std::size_t k = 0; k < axes; ++k) {
      double const inside = u[k] > 0.0 ? std::min(u[k], end[k]) : 0.0;  // not a number: 0
      cell[k] = static_cast<int>(std::min(inside, end[k] - 1.0));
      double const t = inside - cell[k];
      double const s = 1.0 - t;
      value[0][k] = s * s * s * sixth;
      value[1][k] = (0.5 * t - 1.0) * t * t + 2.0 / 3.0;
      value[2][k] = (0.5 * s - 1.0) * s * s + 2.0 / 3.0;
      value[3][k] = t * t * t * sixth;
      slope[0][k] = -0.5 * s * s;
      slope[1][k] = (1.5 * t - 2.0) * t;
      slope[2][k] = (2.0 - 1.5 * s) * s;
      slope[3][k] = 0.5 * t * t;
    }
  }
};

/// A place in the half of the table that its mirror symmetries leave: e_x -> -e_x turns the longitudinal force round,
/// (e_y, e_sp) -> -(e_y, e_sp) the lateral one and the moment.
struct Stencil {
  double along, across;  ///< signs
  Weights weight;
  std::array<std::size_t, 3> stride;  ///< of the outer axes
  float const* first;

  Stencil(CreepTable const& table, CreepTablePlace<double> const& place)
      : along{place.q[0] < 0.0 ? -1.0 : 1.0},
        across{place.q[2] < 0.0 ? -1.0 : 1.0},
        weight{steps(table, place), ends(table)} {
    auto const n = table.shape();
    stride = {components * n[3] * n[2] * n[1], components * n[3] * n[2], components * n[3]};
    auto const cell = [&](std::size_t k) { return at(weight.cell[k]); };
    first = table.coefficients.data() + cell(0) * stride[0] + cell(1) * stride[1] + cell(2) * stride[2] +
            cell(3) * components;
  }
  /// The place in steps of the table.
  PerAxis steps(CreepTable const& table, CreepTablePlace<double> const& place) const {
    auto const& [longitudinal, lateral, spin] = table.cells;
    return {(place.log_aspect + table.log_aspect_end) * table.per_aspect(), along * place.q[0] * longitudinal,
            (across * place.q[1] + 1.0) * lateral, across * place.q[2] * spin};
  }
  static PerAxis ends(CreepTable const& table) {
    auto const steps = [](int n) { return static_cast<double>(n); };
    return {steps(table.aspects), steps(table.cells[0]), steps(2 * table.cells[1]), steps(table.cells[2])};
  }
  double a(std::size_t i) const { return weight.value[i][0]; }
  double x(std::size_t j) const { return weight.value[j][1]; }
  double y(std::size_t k) const { return weight.value[k][2]; }
  float const* row(std::size_t i, std::size_t j, std::size_t k) const {
    return first + i * stride[0] + j * stride[1] + k * stride[2];
  }
  /// From the half to the whole table, times a factor.
  CreepTableValue<double> unfolded(CreepTableValue<double> const& v, double factor) const {
    return {factor * along * v.along, factor * across * v.across, factor * across * v.moment};
  }
};

}  // namespace

CreepTableValue<double> read_creep_table(CreepTable const& table, CreepTablePlace<double> const& place) {
  Stencil const s(table, place);
  Row sum;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      Row over_y;
      for (std::size_t k = 0; k < 4; ++k) over_y.add(s.y(k), s.row(i, j, k));
      sum.add(s.a(i) * s.x(j), over_y);
    }
  return s.unfolded(sum.along_spin(s.weight.value), 1.0);
}

CreepTableSlopes read_creep_table_slopes(CreepTable const& table, CreepTablePlace<double> const& place) {
  Stencil const s(table, place);
  Row sum, by_a, by_x, by_y;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      Row over_y, slope_y;
      for (std::size_t k = 0; k < 4; ++k) {
        over_y.add(s.y(k), s.row(i, j, k));
        slope_y.add(s.weight.slope[k][2], s.row(i, j, k));
      }
      sum.add(s.a(i) * s.x(j), over_y);
      by_a.add(s.weight.slope[i][0] * s.x(j), over_y);
      by_x.add(s.a(i) * s.weight.slope[j][1], over_y);
      by_y.add(s.a(i) * s.x(j), slope_y);
    }
  bool const inside = place.log_aspect > -table.log_aspect_end && place.log_aspect < table.log_aspect_end;
  return {s.unfolded(sum.along_spin(s.weight.value), 1.0),
          {s.unfolded(by_a.along_spin(s.weight.value), inside ? table.per_aspect() : 0.0),
           s.unfolded(by_x.along_spin(s.weight.value), s.along * table.cells[0]),
           s.unfolded(by_y.along_spin(s.weight.value), s.across * table.cells[1]),
           s.unfolded(sum.along_spin(s.weight.slope), s.across * table.cells[2])}};
}

}  // namespace rollerrig
