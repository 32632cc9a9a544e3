// contact/normal/strip_problem.hpp - two elastic half-spaces pressed together along strips: pressure without assuming an ellipse.
//
//   interpenetration of the undeformed surfaces, strip by strip -> [strip problem] -> line load and half-length per strip
//
// On every strip the pressure is semi-elliptic along x (half-length a, line load w), across the strips it is free. Where a
// strip carries load its middle deflects by the interpenetration d, and the surfaces conform along x, as in Hertz:
//
//     (Q/pi) sum_i w_i K_ji(a_i) = d_j,   w_j >= 0;   q_j = 2 Q w_j / (pi a_j^2),   sum_i q_i S_ji(a_i) = A_j    (S3)-(S5)
//
// K_ji, S_ji: Psi and Chi/4 of contact/normal/strip_kernel.hpp over the width of strip i seen from the middle of strip j.
// Exact where the contact is Hertz'. A fixed number of passes from a fixed start, without a branch on a value, so that the
// result is a plain function of its input and regions are solved side by side, one per lane. (S14), (S15)
// Source: our own formulation; Kalker (1990) for the half-space; compared with CONTACT in docs/validation.md.
#pragma once
#include "rollerrig/contact/normal/strip_tables.hpp"

namespace rollerrig {

/// The parabola that stands for a region: its depth [m], the interpenetration where its load ends [m], A + B [1/m].
template <class T>
struct RegionParabola {
  T depth, edge, sum_of_curvatures;
};

/// Strips over one region per lane, equally wide and touching each other.
template <class T>
struct Strips {
  using N = NumberOf<T>;
  // Given:
  N compliance{1.0};             ///< Q/pi [1/Pa]
  T width{0.0};                  ///< of a strip [m]
  StripRow<T> interpenetration;  ///< d [m]; negative: the surfaces are apart
  StripRow<T> curvature;         ///< A, half the sum of both curvatures along x [1/m]
  // Found:
  StripRow<T> load;         ///< w [N/m], not negative
  StripRow<T> half_length;  ///< a [m]
  StripRow<T>
      response;  ///< w for an interpenetration of one metre everywhere on the loaded strips [N/m^2], if asked for
  // From the first row of strips over the whole region:
  RegionParabola<T> parabola;
  StripTables::Place<T> place;  ///< its ln(A/B)
};

namespace strip_detail {

inline constexpr std::size_t n = strip_count;
inline constexpr double smallest_length = 0.02;  // of the half-length over the strip's width: keeps a away from zero
inline constexpr double fading = 0.03;           // of the mean load: below it a strip leaves the system, smoothly
inline constexpr double cut_depth = 0.85;  // of the depth where the parabola's load ends: shallower no strips are laid
inline constexpr double little_load = 0.005;  // of all, at either end of the first row of strips, that counts as none
inline constexpr double start_length = 0.02;  // square of the start's least half-length over the largest

inline std::size_t distance(std::size_t i, std::size_t j) { return i > j ? i - j : j - i; }

template <class T>
T smooth_step(T const& t) {
  T const clipped = select(t < 0.0, T(0.0), select(t > 1.0, T(1.0), t));
  return clipped * clipped * (3.0 - 2.0 * clipped);
}

template <class N>
using Matrix = std::array<StripRow<N>, n>;

/// Factors in place, without pivoting (influence falls with distance); diagonal inverted. Two columns at a time: the matrix does
/// not fit in registers, and so it passes through them half as often.
template <class N>
void factorise(Matrix<N>& m) {
  static_assert(n % 2 == 0);
  for (std::size_t p = 0; p < n; p += 2) {
    auto &one = m[p], &two = m[p + 1];
    one[p] = reciprocal(one[p]);
    two[p] = two[p] * one[p];
    for (std::size_t k = p + 1; k < n; ++k) two[k] -= two[p] * one[k];
    two[p + 1] = reciprocal(two[p + 1]);
    for (std::size_t r = p + 2; r < n; ++r) {
      auto& row = m[r];
      N const f = row[p] * one[p], g = (row[p + 1] - f * one[p + 1]) * two[p + 1];
      row[p] = f;
      row[p + 1] = g;
      for (std::size_t k = p + 2; k < n; ++k) row[k] = (row[k] - f * one[k]) - g * two[k];
    }
  }
}
template <class N>
void solve_factored(Matrix<N> const& m, StripRow<N>& b) {
  for (std::size_t p = 0; p < n; ++p)
    for (std::size_t r = p + 1; r < n; ++r) b[r] -= m[r][p] * b[p];
  for (std::size_t p = n; p-- > 0;) {
    b[p] = b[p] * m[p][p];
    for (std::size_t r = 0; r < p; ++r) b[r] -= m[r][p] * b[p];
  }
}

/// What a pass leaves to the next.
template <class T>
struct Pass {
  StripRow<T> on;          ///< how far a strip takes part, 0 to 1
  StripRow<T> conformity;  ///< q [1/m]
};

/// Influence of every strip on all: column[i][k] on those k widths beside strip i.
template <class T>
using Columns = std::array<StripRow<T>, n>;

template <class T>
void read_columns(StripColumns const& table, Strips<T> const& s, Columns<T>& column) {
  T const inverse = 1.0 / s.width;
  for (std::size_t i = 0; i < n; ++i) table.read(T(s.half_length[i] * inverse), column[i]);
}

/// (S3) with strips in tension left out: on_j (sum_i K_ji on_i v_i - d_j) + (1 - on_j) K_jj v_j = 0, w = on v.
template <class T>
class LoadSystem {
  using N = NumberOf<T>;

 public:
  LoadSystem(Columns<T> const& column, StripRow<T> const& on) : column_(column), on_(on) {
    for (std::size_t j = 0; j < n; ++j) {
      N const on_j = value_of(on[j]);
      for (std::size_t i = 0; i < n; ++i) factors_[j][i] = on_j * value_of(on[i]) * value_of(column[i][distance(i, j)]);
      factors_[j][j] += (1.0 - on_j) * value_of(column[j][0]);
    }
    factorise(factors_);
  }
  /// @return  w of interpenetration d
  StripRow<T> solve(StripRow<T> const& d) const {
    StripRow<N> v;
    for (std::size_t j = 0; j < n; ++j) v[j] = value_of(on_[j]) * value_of(d[j]);
    solve_factored(factors_, v);
    StripRow<T> w;
    for (std::size_t j = 0; j < n; ++j) w[j] = T(v[j]);
    if constexpr (!std::same_as<T, N>) {
      // M dv = db - dM v, derivative by derivative.
      StripRow<T> residual;
      for (std::size_t j = 0; j < n; ++j) {
        T sum(0.0);
        for (std::size_t i = 0; i < n; ++i) sum += (on_[i] * column_[i][distance(i, j)]) * v[i];
        residual[j] = on_[j] * (d[j] - sum) - ((1.0 - on_[j]) * column_[j][0]) * v[j];
      }
      for (int seed = 0; seed < residual[0].d.size(); ++seed) {
        for (std::size_t j = 0; j < n; ++j) v[j] = residual[j].d[seed];
        solve_factored(factors_, v);
        for (std::size_t j = 0; j < n; ++j) w[j].d[seed] = v[j];
      }
    }
    for (std::size_t j = 0; j < n; ++j) w[j] = on_[j] * w[j];
    return w;
  }

 private:
  Columns<T> const& column_;
  StripRow<T> const& on_;
  Matrix<N> factors_;
};

/// How far strips take part next time: in full where they carry load or would carry it, C1 over what they would carry.
template <class T>
void find_loaded(Strips<T> const& s, Columns<T> const& column, StripRow<T> const& w, StripRow<T>& on) {
  T sum(0.0);
  for (auto const& x : w) sum += select(x > 0.0, x, T(0.0));
  T const inverse = (n / fading) / (sum + 1e-30);
  for (std::size_t j = 0; j < n; ++j) {
    T deflection(0.0);
    for (std::size_t i = 0; i < n; ++i) deflection += column[i][distance(i, j)] * w[i];
    T const expected = w[j] + (s.interpenetration[j] - deflection) / column[j][0];
    on[j] = smooth_step(T(expected * inverse));
  }
}

/// a from w and q (S4), kept above zero.
template <class T>
void lengths_from_load(Strips<T>& s, Pass<T> const& pass) {
  using std::sqrt;
  T const floor = square(T(smallest_length * s.width));
  for (std::size_t i = 0; i < n; ++i)
    s.half_length[i] = sqrt(2.0 * s.compliance * s.load[i] / pass.conformity[i] + floor);
}

/// One update of the conformity along x: q A / (S q) to the power 3/4, which lies between what a line contact and a patch
/// long in x ask for; then a from w and q. (S4), (S5)
template <class T>
void update_lengths(StripTables const& tables, Strips<T>& s, Pass<T>& pass) {
  using std::sqrt;
  T const inverse = 1.0 / s.width;
  StripRow<T> sum;
  sum.fill(T(1e-12));
  StripRow<T> column;
  for (std::size_t i = 0; i < n; ++i) {
    tables.curvature.read(T(s.half_length[i] * inverse), column);
    T const q = 0.25 * pass.on[i] * pass.conformity[i];
    for (std::size_t j = 0; j < n; ++j) sum[j] += q * column[distance(i, j)];
  }
  for (std::size_t j = 0; j < n; ++j) {
    T const root = sqrt(s.curvature[j] / sum[j]);
    // A strip without load keeps its q.
    pass.conformity[j] = pass.conformity[j] * (1.0 + pass.on[j] * (root * sqrt(root) - 1.0));
  }
  lengths_from_load(s, pass);
}

/// A parabola pressed after Hertz: conformity q/A, half-lengths and loads.
template <class T>
void start_from_hertz(StripTables const& tables, Strips<T>& s, Pass<T>& pass) {
  using std::sqrt;
  auto const& d = s.interpenetration;
  auto const& [depth, edge, sum_of_curvatures] = s.parabola;
  T const conformity = tables.at(StartFunction::conformity, s.place);
  T const longest2 = tables.at(StartFunction::length, s.place) * depth / sum_of_curvatures;
  T const per_depth = longest2 / (depth - edge);
  T const floor = start_length * longest2;
  for (std::size_t i = 0; i < n; ++i) {
    T const a2 = per_depth * (d[i] - edge);
    T const kept = 0.5 * (a2 + sqrt(a2 * a2 + 4.0 * floor * floor));
    s.half_length[i] = sqrt(kept);
    pass.conformity[i] = conformity * s.curvature[i];
    s.load[i] = kept * pass.conformity[i] / (2.0 * s.compliance);
    pass.on[i] = T(1.0);
  }
}

}  // namespace strip_detail

/// Fills load, half_length and place.
///
/// @param with_response  response, too: what several regions of a wheel ask of each other
template <class T>
void solve_strips(StripTables const& tables, Strips<T>& s, bool with_response) {
  using namespace strip_detail;
  Pass<T> pass;
  start_from_hertz(tables, s, pass);
  update_lengths(tables, s, pass);
  T const inverse = 1.0 / T(s.compliance);
  Columns<T> column;
  auto const take = [&](StripRow<T> const& w) {
    for (std::size_t j = 0; j < n; ++j) s.load[j] = inverse * select(w[j] > 0.0, w[j], T(0.0));
  };
  constexpr int passes = 2;
  for (int k = 0; k < passes; ++k) {
    read_columns(tables.deflection, s, column);
    StripRow<T> w = LoadSystem<T>(column, pass.on).solve(s.interpenetration);
    find_loaded(s, column, w, pass.on);
    if (k + 1 == passes) {
      LoadSystem<T> const system(column, pass.on);
      w = system.solve(s.interpenetration);
      StripRow<T> one;
      one.fill(T(1.0));
      s.response = with_response ? system.solve(one) : one;
    }
    take(w);
    lengths_from_load(s, pass);
    if (k + 1 < passes) update_lengths(tables, s, pass);
  }
  T const exact = tables.at(StartFunction::force, s.place);
  for (std::size_t j = 0; j < n; ++j) {
    s.load[j] = exact * s.load[j];
    s.response[j] = exact * inverse * s.response[j];
  }
}

/// Where strips shall lie [number of strips].
template <class T>
struct LoadRange {
  T from, to;
};

/// From a first row of strips over the whole region: the parabola that stands for it, and where strips shall lie.
///
/// The parabola has the area of the interpenetration and a depth that its deep part decides, so that a shallow tail counts
/// little. Strips lie where the interpenetration exceeds 0.85 of that at the parabola's edge after Hertz; further outwards
/// only if the first row, pressed once with Hertz' lengths, carries load there. (S15)
///
/// @param stretch  width of the overlap over that of the row, 1 or more [-]
template <class T>
LoadRange<T> range_of_load(StripTables const& tables, T const& stretch, Strips<T>& s) {
  using namespace strip_detail;
  using std::log;
  T sum(1e-30), squares(1e-60), cubes(1e-90), curvature(0.0);
  StripRow<T> d;
  for (std::size_t i = 0; i < n; ++i) {
    d[i] = select(s.interpenetration[i] > 0.0, s.interpenetration[i], T(0.0));
    T const d2 = d[i] * d[i];
    sum += d[i];
    squares += d2;
    cubes += d2 * d[i];
    curvature += d[i] * s.curvature[i];
  }
  curvature = curvature / sum;
  T const depth = (7.0 / 6.0) * cubes / squares;
  T const half = 0.75 * stretch * s.width * sum / depth;
  T const across = depth / (half * half);
  s.place = tables.place(T(log(curvature / across)));
  s.parabola = {depth, tables.at(StartFunction::edge, s.place) * depth, curvature + across};

  Pass<T> pass;
  start_from_hertz(tables, s, pass);
  Columns<T> column;
  read_columns(tables.deflection, s, column);
  StripRow<T> w = LoadSystem<T>(column, pass.on).solve(s.interpenetration);
  T load(1e-60);
  for (auto& x : w) {
    x = select(x > 0.0, x, T(0.0));
    load += x;
  }
  T const level = cut_depth * s.parabola.edge, little = little_load * load;
  // How many strips lie before that depth and before a little of the load, counted from either end; with fractions.
  auto const before = [&](bool from_right) {
    T seen(0.0), unloaded(0.0), shallow(0.0), last(0.0), open(1.0);
    for (std::size_t k = 0; k < n; ++k) {
      std::size_t const i = from_right ? n - 1 - k : k;
      double const width = k == 0 ? 0.5 : 1.0;
      T const rise = d[i] - last;
      auto const below = d[i] < level;
      T const part = (level - last) * reciprocal(select(rise > 0.0, rise, T(1.0)));
      shallow += open * width * select(below, T(1.0), part);
      open = select(below, open, T(0.0));
      last = d[i];
      T const t = (little - seen) * reciprocal(T(w[i] + 1e-9 * load));
      unloaded += select(t < 0.0, T(0.0), select(t > 1.0, T(1.0), t));
      seen += w[i];
    }
    return select(unloaded < shallow, unloaded, shallow);
  };
  return {before(false), static_cast<double>(n) - before(true)};
}

}  // namespace rollerrig
