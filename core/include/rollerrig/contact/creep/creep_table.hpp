// contact/creep/creep_table.hpp - the exact theory as a smooth function: forces and moment of a patch read from a table.
//
//     F / (mu N) = L(v) rho_0 / (rho_0 + rho) + |q| D(ln(a/b), q),       q = v / (rho_0 + rho),   rho = |v|
//
// v are the creepages in units in which each of them demands about mu N; L is Kalker's linear theory, so small creepages give
// exactly (20), D being zero in the middle of the ball by its mirror symmetries. q fills the unit ball, its surface is full sliding. D is a tensor product of cubic B-splines, twice
// continuously differentiable, fitted to solutions of contact/creep/rolling_reference.hpp for nu = 0.28. For other nu the creepages
// are scaled by the ratio of Kalker's coefficients, which keeps the linear limit exact.
// Outside 1/10 <= a/b <= 10 the end values of D hold; runs count it with Kalker's table (clamped_aspect). Every creepage is
// inside. How accurate, and how the table is made: docs/theory/creep_laws.md, (C13)-(C15).
//
// Source  our own.
#pragma once
#include <array>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <vector>

#include "rollerrig/contact/creep/creep_query.hpp"
#include "rollerrig/fields.hpp"
#include "rollerrig/math/lane.hpp"

namespace rollerrig {

/// Coefficients of D at uniform knots: from -1 to count + 1 along each axis but the lateral one, which is symmetric.
struct CreepTable {
  double log_aspect_end{2.302585092994046};  ///< knots of ln(a/b) run from minus this to this
  double rho_0{1.5};
  int aspects{16};                      ///< intervals
  std::array<int, 3> cells{8, 12, 12};  ///< per unit of q: longitudinal >= 0, lateral, spin >= 0
  std::vector<float> coefficients;      ///< [aspect][longitudinal][lateral][spin][force along, across, moment, 0]

  double per_aspect() const { return 0.5 * aspects / log_aspect_end; }  ///< intervals per unit of ln(a/b)
  std::array<std::size_t, 4> shape() const {
    auto const n = [](int i) { return at(i); };
    return {n(aspects + 3), n(cells[0] + 3), n(2 * cells[1] + 3), n(cells[2] + 3)};
  }
  std::size_t size() const {
    auto const s = shape();
    return 4 * s[0] * s[1] * s[2] * s[3];
  }

  void check() const {
    if (coefficients.size() != size())
      throw std::invalid_argument("the creep table has not as many coefficients as its shape asks for");
  }
};

template <class T>
struct CreepTablePlace {
  T log_aspect;
  std::array<T, 3> q;
};

/// D there.
template <class T>
struct CreepTableValue {
  T along, across, moment;
};

/// Compiled once: core/src/contact/creep/creep_table.cpp.
CreepTableValue<double> read_creep_table(CreepTable const& table, CreepTablePlace<double> const& place);

/// D and its slopes along ln(a/b) and q.
struct CreepTableSlopes {
  CreepTableValue<double> value;
  std::array<CreepTableValue<double>, 4> slope;
};
CreepTableSlopes read_creep_table_slopes(CreepTable const& table, CreepTablePlace<double> const& place);

/// The same for any scalar: with derivatives by the chain rule, or lane by lane.
template <Scalar T>
CreepTableValue<T> creep_table_at(CreepTable const& table, CreepTablePlace<T> const& place) {
  if constexpr (std::same_as<T, double>) {
    return read_creep_table(table, place);
  } else if constexpr (lanes_of<T> > 1) {
    return each_lane<CreepTableValue>([&](auto const& one) { return read_creep_table(table, one); }, place);
  } else {
    auto const& [log_aspect, q] = place;
    auto const read =
        read_creep_table_slopes(table, {value_of(log_aspect), {value_of(q[0]), value_of(q[1]), value_of(q[2])}});
    auto const with_slopes = [&](auto component) {
      T out(read.value.*component);
      out += (read.slope[0].*component) * (log_aspect - value_of(log_aspect));
      for (std::size_t k = 0; k < 3; ++k) out += (read.slope[k + 1].*component) * (q[k] - value_of(q[k]));
      return out;
    };
    using V = CreepTableValue<double>;
    return {with_slopes(&V::along), with_slopes(&V::across), with_slopes(&V::moment)};
  }
}

/// (C13), (C14)
template <Scalar T>
CreepForce<T> table_force(CreepTable const& table, CreepQuery<T> const& query) {
  using std::sqrt;
  auto const& e = query.creepage;
  auto const& f = query.stiffness;
  T const& adhesion = query.adhesion;
  auto const unit = demand_per_creepage(query);
  std::array<T, 3> const v{unit[0] * e.longitudinal, unit[1] * e.lateral, unit[2] * query.direction * e.spin};
  T const rho = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + square(regularisation::demand));
  T const shrink = 1.0 / (table.rho_0 + rho);
  auto const d = creep_table_at<T>(table, {query.log_aspect, {v[0] * shrink, v[1] * shrink, v[2] * shrink}});
  auto const linear = linear_creep_force(e, f);
  T const fade = table.rho_0 * shrink;
  T const gain = adhesion * rho * shrink;
  T const tx = fade * linear.longitudinal + gain * d.along;
  T const ty = fade * linear.lateral + gain * d.across;
  T const moment = fade * linear.spin_moment + query.direction * gain * sqrt(query.a * query.b) * d.moment;
  T const demanded = regularisation::length(linear.longitudinal, linear.lateral, regularisation::force);
  return never_drives(query, CreepForce<T>{tx, ty, moment, saturation(tx, ty, demanded)});
}

struct TableLaw {
  static constexpr char const* name = "table";
  static constexpr bool in_lanes = true;
  std::shared_ptr<CreepTable const> table{};
  static constexpr auto fields() { return members(Member{"table", &TableLaw::table}); }

  template <Scalar T>
  CreepForce<T> operator()(CreepQuery<T> const& query) const {
    return table_force(*table, query);
  }
};

}  // namespace rollerrig
