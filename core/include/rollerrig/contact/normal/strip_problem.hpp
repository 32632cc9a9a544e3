// contact/normal/strip_problem.hpp - two elastic half-spaces pressed together along strips: pressure without assuming an ellipse.
//
//   interpenetration of the undeformed surfaces, strip by strip -> [strip problem] -> line load and half-length per strip
//
// On every strip the pressure is semi-elliptic along x (half-length a, line load w), across the strips it is free. Where a
// strip carries load its middle deflects by the interpenetration d, and the surfaces conform along x, as in Hertz:
//
//     (Q/pi) sum_i w_i K_ji(a_i) = d_j,   w_j >= 0;   q_j = 2 Q w_j / (pi a_j^2),   sum_i q_i S_ji(a_i) = A_j    (S3), (S4)
//
// K_ji, S_ji: Psi and Chi/4 of contact/normal/strip_tables.hpp over the width of strip i seen from the middle of strip j.
// For given lengths a both are linear: a pass solves both and takes the lengths from the loads. A fixed number of passes from a
// fixed start, Hertz' ellipse, without a branch on a value, so that the result is a plain function of its input and regions
// are solved side by side, one per lane. Exact where the contact is Hertz'. (S5), (S14)
// Source: our own formulation; Kalker (1990) for the half-space; compared with CONTACT in docs/validation.md.
#pragma once
#include "rollerrig/contact/normal/oblique_ellipse.hpp"

namespace rollerrig {

/// Strips over one region per lane, beside each other.
template <class T, std::size_t n = strip_count>
struct Strips {
  using N = NumberOf<T>;
  // Given:
  N compliance{1.0};                ///< Q/pi [1/Pa]
  StripRow<T, n> position;          ///< of the middles, along the wheel's arc [m]
  StripRow<T, n> width;             ///< [m]
  StripRow<T, n> interpenetration;  ///< d [m]; negative: the surfaces are apart
  StripRow<T, n> curvature;         ///< A, half the sum of both curvatures along x [1/m]
  ObliqueEllipse<T> ellipse;        ///< of the paraboloid that stands for the region
  T middle, depth, across;          ///< of that paraboloid [m], [1/m]
  // Found:
  StripRow<T, n> load;         ///< w [N/m], not negative
  StripRow<T, n> half_length;  ///< a [m]
  StripRow<T, n> on;           ///< how far a strip takes part, 0 to 1: over 1/2 where it would carry load by itself
  StripRow<T, n> longest2;     ///< square of the half-length over which the undeformed surfaces interpenetrate [m^2]
  T shortest2{0.0};            ///< square of the least half-length [m^2]
  T change;                    ///< of the force in the last pass, over the force [-]
};

namespace strip_detail {

// Of the half-length over that of Hertz. Over the strip's width it would be too short for many strips: one without load deflects
// itself so much more than its neighbours do that every second strip was left without.
inline constexpr double smallest_length = 0.05;
inline constexpr double fading = 0.03;     // of the mean load: that of a strip which just touches
inline constexpr double freely = 0.7;      // square of a half-length over the longest, up to which it is as (S4) says
inline constexpr double most_found = 4.0;  // the same, that (S4) may say
inline constexpr double start_length = 0.02;  // square of the start's least half-length over the largest
inline constexpr double least_change = 0.1, most_change = 10.0;  // of a conformity in one pass

template <class T>
T smooth_step(T const& t) {
  T const clipped = select(t < 0.0, T(0.0), select(t > 1.0, T(1.0), t));
  return clipped * clipped * (3.0 - 2.0 * clipped);
}

template <class N, std::size_t n>
using Matrix = std::array<StripRow<N, n>, n>;

/// Factors in place, without pivoting (influence falls with distance); diagonal inverted. Two columns at a time: the matrix does
/// not fit in registers, and so it passes through them half as often.
template <class N, std::size_t n>
void factorise(Matrix<N, n>& m) {
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
template <class N, std::size_t n>
void solve_factored(Matrix<N, n> const& m, StripRow<N, n>& b) {
  for (std::size_t p = 0; p < n; ++p)
    for (std::size_t r = p + 1; r < n; ++r) b[r] -= m[r][p] * b[p];
  for (std::size_t p = n; p-- > 0;) {
    b[p] = b[p] * m[p][p];
    for (std::size_t r = 0; r < p; ++r) b[r] -= m[r][p] * b[p];
  }
}

/// Influence of strip i on the middle of strip j: of deflection and curvature, [j][i].
template <class T, std::size_t n>
struct Influences {
  Matrix<T, n> deflection, curvature;
};

/// Over another strip the mean of psi is psi in its middle and a little more: three terms of the series for a function that falls
/// as -(4/pi) ln k near the strip and as 1/k far from it.
template <class T, std::size_t n>
void read_influences(StripKernel const& kernel, Strips<T, n> const& s, Influences<T, n>& out) {
  using F = StripKernel::Function;
  T const for_deflection = s.ellipse.deflection, for_curvature = 0.25 * s.ellipse.curvature;
  StripRow<T, n> inverse, width, wide_deflection, wide_curvature;
  for (std::size_t i = 0; i < n; ++i) {
    inverse[i] = reciprocal(s.half_length[i]);
    width[i] = s.width[i] * inverse[i];
    T const own = 0.5 * width[i];
    out.deflection[i][i] = 2.0 * for_deflection * kernel.read(F::own_deflection, own);
    out.curvature[i][i] = 2.0 * for_curvature * kernel.read(F::own_curvature, own);
    wide_deflection[i] = for_deflection * width[i], wide_curvature[i] = for_curvature * width[i];
  }
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) {
      if (i == j) continue;
      T const k = (i < j ? s.position[j] - s.position[i] : s.position[i] - s.position[j]) * inverse[i];
      // One division for three: by k, by 1 + (2/pi) k and by 1 + k^2.
      T const far = 1.0 + (2.0 / pi) * k, near = 1.0 + k * k;
      T const by_all = reciprocal(T(k * far * near));
      T const part = width[i] * (by_all * far * near);  // of the strip over its distance
      T const part2 = part * part;
      T const log_mean = part2 * (1.0 / 24.0 + part2 * (1.0 / 320.0 + part2 * (1.0 / 2688.0)));
      T const psi = kernel.read(F::deflection, k) + (4.0 / pi) * log_mean * (by_all * k * near);
      out.deflection[j][i] = wide_deflection[i] * psi;
      out.curvature[j][i] = wide_curvature[i] * psi * (by_all * k * far);  // (S2)
    }
}

/// x of M x = b, with derivatives: M dx = db - dM x, one after the other by the same factors. Spoils M.
template <class T, std::size_t n>
StripRow<T, n> solution(Matrix<T, n>& m, StripRow<T, n> const& b) {
  using N = NumberOf<T>;
  if constexpr (std::same_as<T, N>) {
    StripRow<T, n> x = b;
    factorise<N, n>(m);
    solve_factored<N, n>(m, x);
    return x;
  } else {
    Matrix<N, n> factors;
    StripRow<N, n> v;
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t i = 0; i < n; ++i) factors[j][i] = value_of(m[j][i]);
      v[j] = value_of(b[j]);
    }
    factorise<N, n>(factors);
    solve_factored<N, n>(factors, v);
    StripRow<T, n> x, residual;
    for (std::size_t j = 0; j < n; ++j) {
      x[j] = T(v[j]);
      T sum(0.0);
      for (std::size_t i = 0; i < n; ++i) sum += m[j][i] * v[i];
      residual[j] = b[j] - sum;
    }
    for (int seed = 0; seed < residual[0].d.size(); ++seed) {
      for (std::size_t j = 0; j < n; ++j) v[j] = residual[j].d[seed];
      solve_factored<N, n>(factors, v);
      for (std::size_t j = 0; j < n; ++j) x[j].d[seed] = v[j];
    }
    return x;
  }
}

/// Loads of (S3), not negative: w = s(e) where e = w + (d - K w)/K_jj is what a strip would carry with the others as they are, and
/// s(e) = (e + sqrt(e^2 + 4 f^2))/2, f a small load: e where strips carry load, almost nothing where they do not. Its slope is
/// below one, so that there is one solution. One step of Newton from the last loads.
template <class T, std::size_t n>
class LoadStep {
 public:
  LoadStep(Matrix<T, n> const& k, StripRow<T, n> const& d, StripRow<T, n> const& width) : k_(k), d_(d), width_(width) {
    for (std::size_t j = 0; j < n; ++j) inverse_[j] = reciprocal(k[j][j]);
  }

  /// All strips carry, pushed or pulled.
  StripRow<T, n> first(Matrix<T, n>& m) const {
    m = k_;
    return solution(m, d_);
  }

  /// @param on  result: how far strips take part, 0 to 1
  /// @param m   scratch
  StripRow<T, n> next(StripRow<T, n> const& w, StripRow<T, n>& on, Matrix<T, n>& m) const {
    using std::sqrt;
    T sum(0.0), length(0.0);
    for (std::size_t j = 0; j < n; ++j) {
      sum += select(w[j] > 0.0, w[j], T(0.0)) * width_[j];
      length += width_[j];
    }
    T const band2 = square(T(2.0 * fading * sum / length + 1e-30));
    StripRow<T, n> b;
    for (std::size_t j = 0; j < n; ++j) {
      T deflection(0.0);
      for (std::size_t i = 0; i < n; ++i) deflection += k_[j][i] * w[i];
      T const e = w[j] + (d_[j] - deflection) * inverse_[j];
      T const root = sqrt(e * e + band2);
      T const slope = on[j] = 0.5 * (1.0 + e / root);
      T const scale = slope * inverse_[j];
      for (std::size_t i = 0; i < n; ++i) m[j][i] = scale * k_[j][i];
      m[j][j] += 1.0 - slope;
      b[j] = scale * d_[j] + 0.5 * (e + root) - slope * e;
    }
    return solution(m, b);
  }

 private:
  Matrix<T, n> const& k_;
  StripRow<T, n> const &d_, &width_;
  StripRow<T, n> inverse_;
};

/// q of (S4) on the loaded strips: on_j (sum_i S_ji on_i v_i - A_j) + (1 - on_j) S_jj v_j = 0.
template <class T, std::size_t n>
StripRow<T, n> conformities(Matrix<T, n> const& s, StripRow<T, n> const& on, StripRow<T, n> const& curvature,
                            Matrix<T, n>& m) {
  StripRow<T, n> b;
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < n; ++i) m[j][i] = on[j] * on[i] * s[j][i];
    m[j][j] += (1.0 - on[j]) * s[j][j];
    b[j] = on[j] * curvature[j];
  }
  return solution(m, b);
}

/// a from w and q (S4), kept above zero and within the interpenetration: under pressure alone surfaces touch nowhere else.
template <class T, std::size_t n>
void lengths_from_load(Strips<T, n>& s, StripRow<T, n>& conformity) {
  using std::sqrt;
  for (std::size_t i = 0; i < n; ++i) {
    T const load = 2.0 * s.compliance * s.load[i], flattest = load * reciprocal(T(most_found * s.longest2[i]));
    conformity[i] = select(conformity[i] > flattest, conformity[i], flattest);
    T const found2 = load * reciprocal(conformity[i]), free2 = freely * s.longest2[i];
    T const beyond = select(found2 > free2, T(found2 - free2), T(0.0));
    s.half_length[i] = sqrt(found2 - beyond * beyond * reciprocal(T(s.longest2[i] - free2 + beyond)) + s.shortest2);
  }
}

/// The region's paraboloid pressed after Hertz: conformity, and half-lengths from the interpenetration over that at its edge.
template <class T, std::size_t n>
void start_from_hertz(Strips<T, n>& s, StripRow<T, n>& conformity) {
  using std::sqrt;
  auto const& e = s.ellipse;
  T const longest2 = e.half_length * e.half_length * s.depth;
  T const edge = s.depth * (1.0 - (s.across + e.taken) * e.half_width * e.half_width);
  T const per_depth = longest2 / (s.depth - edge);
  T const floor = start_length * longest2;
  s.shortest2 = smallest_length * smallest_length * longest2;
  for (std::size_t i = 0; i < n; ++i) {
    T const a2 = per_depth * (s.interpenetration[i] - edge);
    s.half_length[i] = sqrt(0.5 * (a2 + sqrt(a2 * a2 + 4.0 * floor * floor)));
    T const all2 = s.interpenetration[i] * reciprocal(s.curvature[i]);
    s.longest2[i] = select(all2 > floor, all2, floor);
    conformity[i] = e.pressure_gradient;
  }
}

}  // namespace strip_detail

/// Fills load, half_length, on and change.
///
/// @param passes  of loads and lengths
template <class T, std::size_t n>
void solve_strips(StripTables const& tables, Strips<T, n>& s, int passes) {
  using namespace strip_detail;
  using std::sqrt;
  StripRow<T, n> conformity, w;
  auto& on = s.on;
  start_from_hertz(s, conformity);
  Influences<T, n> influence;
  Matrix<T, n> m;
  T const inverse = 1.0 / T(s.compliance);
  T const damping = 0.4 * smooth_step(T((-0.5 - s.ellipse.place.x) * 0.4));
  T last(0.0), force(0.0);
  for (int pass = 0; pass < passes; ++pass) {
    read_influences(tables.kernel, s, influence);
    LoadStep<T, n> const step(influence.deflection, s.interpenetration, s.width);
    if (pass == 0) w = step.next(step.first(m), on, m);
    w = step.next(w, on, m);
    last = force;
    force = T(0.0);
    for (std::size_t j = 0; j < n; ++j) {
      s.load[j] = inverse * select(w[j] > 0.0, w[j], T(0.0));
      force += s.load[j] * s.width[j];
    }
    auto const q = conformities(influence.curvature, on, s.curvature, m);
    for (std::size_t j = 0; j < n; ++j) {
      // To the power of one, 0.8 for a patch that is long in x: for a line contact across it one is exact. A strip without load
      // keeps its q.
      T const ratio = q[j] * reciprocal(conformity[j]);
      T const above = select(ratio > least_change, ratio, T(least_change));
      T const within = select(above < most_change, above, T(most_change));
      T const power = within + damping * (sqrt(within) - within);
      conformity[j] = conformity[j] * (1.0 + on[j] * (power - 1.0));
    }
    lengths_from_load(s, conformity);
  }
  s.change = (force - last) / (force + 1e-30);
  T const exact = tables.at(StartFunction::force, s.ellipse.place);
  for (std::size_t j = 0; j < n; ++j) {
    s.load[j] = exact * s.load[j];
  }
}

}  // namespace rollerrig
