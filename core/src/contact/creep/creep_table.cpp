// D of the creep table: tensor product of cubic B-splines, contracted one axis after the other.
#include "rollerrig/contact/creep/creep_table.hpp"

#include <algorithm>

namespace rollerrig {
namespace {

constexpr std::size_t lanes = 4;  // three components and one of padding: one vector register

struct Lane {
  double v[lanes]{};
  void add(double w, Lane const& x) {
    for (std::size_t c = 0; c < lanes; ++c) v[c] += w * x.v[c];
  }
  void add(double w, float const* x) {
    for (std::size_t c = 0; c < lanes; ++c) v[c] += w * static_cast<double>(x[c]);
  }
};

/// The four splines that are not zero at u, and their slopes; knots at whole numbers from 0 to `end`.
struct Weights {
  std::size_t first;
  std::array<double, 4> value, slope;
};

Weights weights(double u, int end) {
  double const inside = u > 0.0 ? std::min(u, static_cast<double>(end)) : 0.0;  // not a number: 0
  int const cell = std::min(static_cast<int>(inside), end - 1);
  double const t = inside - cell;
  double const s = 1.0 - t;
  return {static_cast<std::size_t>(cell),
          {s * s * s / 6.0, (3.0 * t - 6.0) * t * t / 6.0 + 2.0 / 3.0, (3.0 * s - 6.0) * s * s / 6.0 + 2.0 / 3.0,
           t * t * t / 6.0},
          {-0.5 * s * s, (1.5 * t - 2.0) * t, (2.0 - 1.5 * s) * s, 0.5 * t * t}};
}

}  // namespace

void read_creep_table(CreepTable const& table, double log_aspect, std::array<double, 3> const& q, bool slopes,
                      CreepTablePoint& out) {
  // Mirror images: e_x -> -e_x turns the longitudinal force round; (e_y, e_sp) -> -(e_y, e_sp) the lateral one and the moment.
  double const along = q[0] < 0.0 ? -1.0 : 1.0;
  double const across = q[2] < 0.0 ? -1.0 : 1.0;
  double const per_aspect = 0.5 * table.aspects / table.log_aspect_end;
  bool const aspect_inside = log_aspect > -table.log_aspect_end && log_aspect < table.log_aspect_end;
  Weights const a = weights((log_aspect + table.log_aspect_end) * per_aspect, table.aspects);
  Weights const x = weights(along * q[0] * table.cells[0], table.cells[0]);
  Weights const y = weights((across * q[1] + 1.0) * table.cells[1], 2 * table.cells[1]);
  Weights const z = weights(across * q[2] * table.cells[2], table.cells[2]);
  auto const n = table.shape();
  auto const block = [&](std::size_t i, std::size_t j, std::size_t k) {
    return &table.coefficients[lanes * ((((a.first + i) * n[1] + x.first + j) * n[2] + y.first + k) * n[3] + z.first)];
  };

  Lane sum{}, by_a{}, by_x{}, by_y{}, by_z{};
  for (std::size_t i = 0; i < 4; ++i) {
    Lane at_a{}, at_a_x{}, at_a_y{}, at_a_z{};
    for (std::size_t j = 0; j < 4; ++j) {
      Lane at_x{}, at_x_y{}, at_x_z{};
      for (std::size_t k = 0; k < 4; ++k) {
        float const* c = block(i, j, k);
        Lane at_y{};
        for (std::size_t m = 0; m < 4; ++m) at_y.add(z.value[m], c + lanes * m);
        at_x.add(y.value[k], at_y);
        if (!slopes) continue;
        at_x_y.add(y.slope[k], at_y);
        Lane at_y_z{};
        for (std::size_t m = 0; m < 4; ++m) at_y_z.add(z.slope[m], c + lanes * m);
        at_x_z.add(y.value[k], at_y_z);
      }
      at_a.add(x.value[j], at_x);
      if (!slopes) continue;
      at_a_x.add(x.slope[j], at_x);
      at_a_y.add(x.value[j], at_x_y);
      at_a_z.add(x.value[j], at_x_z);
    }
    sum.add(a.value[i], at_a);
    if (!slopes) continue;
    by_a.add(a.slope[i], at_a);
    by_x.add(a.value[i], at_a_x);
    by_y.add(a.value[i], at_a_y);
    by_z.add(a.value[i], at_a_z);
  }

  std::array<double, 3> const sign{along, across, across};
  for (std::size_t c = 0; c < 3; ++c) {
    out.value[c] = sign[c] * sum.v[c];
    if (!slopes) continue;
    out.slope[0][c] = aspect_inside ? sign[c] * per_aspect * by_a.v[c] : 0.0;
    out.slope[1][c] = sign[c] * along * table.cells[0] * by_x.v[c];
    out.slope[2][c] = sign[c] * across * table.cells[1] * by_y.v[c];
    out.slope[3][c] = sign[c] * across * table.cells[2] * by_z.v[c];
  }
}

}  // namespace rollerrig
