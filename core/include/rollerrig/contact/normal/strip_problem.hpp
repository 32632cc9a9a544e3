// contact/normal/strip_problem.hpp - two elastic half-spaces pressed together along strips: pressure without assuming an ellipse.
//
//   interpenetration of the undeformed surfaces, strip by strip -> [strip problem] -> line load and half-length per strip
//
// On every strip the pressure is semi-elliptic along x (half-length a, line load w), across the strips it is free. Where a
// strip carries load its middle deflects by the interpenetration d, and the surfaces conform along x, as in Hertz:
//
//     (Q/pi) sum_i w_i K_ji(a_i) = d_j,   w_j >= 0;   q_j = 2 Q w_j / (pi a_j^2),   sum_i q_i S_ji(a_i) = A_j    (S3), (S4)
//
// K_ji, S_ji: Psi and Chi/4 of contact/normal/strip_kernel.hpp over the width of strip i seen from the middle of strip j.
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
  T shortest2{0.0};            ///< square of the least half-length [m^2]
  T change;                    ///< of the force in the last pass, over the force [-]
};

namespace strip_detail {

// Of the half-length over that of Hertz. Over the strip's width it would be too short for many strips: one without load deflects
// itself so much more than its neighbours do that every second strip was left without.
inline constexpr double smallest_length = 0.05;
inline constexpr double fading = 0.03;        // of the mean load: that of a strip which just touches
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
///
/// @param rate  result, if asked for: derivatives over the logarithm of a_i
template <class T, std::size_t n>
void read_influences(StripKernel const& kernel, Strips<T, n> const& s, Influences<T, n>& out,
                     Influences<T, n>* rate = nullptr) {
  using F = StripKernel::Function;
  T const for_deflection = s.ellipse.deflection, for_curvature = 0.25 * s.ellipse.curvature;
  for (std::size_t i = 0; i < n; ++i) {
    T const inverse = reciprocal(s.half_length[i]);
    T const width = s.width[i] * inverse;
    T const own = 0.5 * width;
    auto const own_deflection = kernel.read(F::own_deflection, own), own_curvature = kernel.read(F::own_curvature, own);
    out.deflection[i][i] = 2.0 * for_deflection * own_deflection.value;
    out.curvature[i][i] = 2.0 * for_curvature * own_curvature.value;
    if (rate) {
      rate->deflection[i][i] = -(for_deflection * width * own_deflection.slope);
      rate->curvature[i][i] = -(for_curvature * width * own_curvature.slope);
    }
    T const wide_deflection = for_deflection * width, wide_curvature = for_curvature * width;
    for (std::size_t j = 0; j < n; ++j) {
      if (i == j) continue;
      T const k = (i < j ? s.position[j] - s.position[i] : s.position[i] - s.position[j]) * inverse;
      // One division for three: by k, by 1 + (2/pi) k and by 1 + k^2.
      T const far = 1.0 + (2.0 / pi) * k, near = 1.0 + k * k;
      T const by_all = reciprocal(T(k * far * near));
      T const part = width * (by_all * far * near);  // of the strip over its distance
      T const part2 = part * part;
      T const log_mean = part2 * (1.0 / 24.0 + part2 * (1.0 / 320.0 + part2 * (1.0 / 2688.0)));
      T const by_far = by_all * k * near, by_near = by_all * k * far;
      T const more = (4.0 / pi) * log_mean * by_far;
      auto const middle = kernel.read(F::deflection, k);
      T const psi = middle.value + more, curved = wide_curvature * by_near;
      out.deflection[j][i] = wide_deflection * psi;
      out.curvature[j][i] = curved * psi;  // (S2)
      if (rate) {
        T const change = more * (1.0 - by_far) - k * middle.slope - psi;
        rate->deflection[j][i] = wide_deflection * change;
        rate->curvature[j][i] = curved * (change + 2.0 * psi * (1.0 - by_near));
      }
    }
  }
}

/// Influences after half-lengths have changed a little.
template <class T, std::size_t n>
void follow(Influences<T, n> const& base, Influences<T, n> const& rate, StripRow<T, n> const& before,
            StripRow<T, n> const& now, Influences<T, n>& out) {
  for (std::size_t i = 0; i < n; ++i) {
    // Of the logarithm, to the third order; where nothing has settled yet, influences stay positive.
    T const full = 2.0 * (now[i] - before[i]) * reciprocal(T(now[i] + before[i]));
    T const short_of = select(full < 0.5, full, T(0.5));
    T const change = select(short_of > -0.5, short_of, T(-0.5));
    for (std::size_t j = 0; j < n; ++j) {
      out.deflection[j][i] = base.deflection[j][i] + rate.deflection[j][i] * change;
      out.curvature[j][i] = base.curvature[j][i] + rate.curvature[j][i] * change;
    }
  }
}

/// (M + D) x = b with D diagonal, and with derivatives: (M + D) dx = db - (dM + dD) x, one after the other by the same factors.
template <class T, std::size_t n>
StripRow<T, n> solved(Matrix<T, n> const& matrix, StripRow<T, n> const& diagonal, StripRow<T, n> const& b) {
  using N = NumberOf<T>;
  Matrix<N, n> factors;
  StripRow<N, n> v;
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < n; ++i) factors[j][i] = value_of(matrix[j][i]);
    factors[j][j] += value_of(diagonal[j]);
    v[j] = value_of(b[j]);
  }
  factorise<N, n>(factors);
  solve_factored<N, n>(factors, v);
  StripRow<T, n> x;
  for (std::size_t j = 0; j < n; ++j) x[j] = T(v[j]);
  if constexpr (!std::same_as<T, N>) {
    StripRow<T, n> residual;
    for (std::size_t j = 0; j < n; ++j) {
      T sum = diagonal[j] * v[j];
      for (std::size_t i = 0; i < n; ++i) sum += matrix[j][i] * v[i];
      residual[j] = b[j] - sum;
    }
    for (int seed = 0; seed < residual[0].d.size(); ++seed) {
      for (std::size_t j = 0; j < n; ++j) v[j] = residual[j].d[seed];
      solve_factored<N, n>(factors, v);
      for (std::size_t j = 0; j < n; ++j) x[j].d[seed] = v[j];
    }
  }
  return x;
}

/// Loads of (S3), not negative: w = s(e) where e = w + (d - K w)/K_jj is what a strip would carry with the others as they are, and
/// s(e) = (e + sqrt(e^2 + 4 f^2))/2, f a small load: e where strips carry load, almost nothing where they do not. Its slope is
/// below one, so that there is one solution. One step of Newton from the last loads.
///
/// @param on  result: the slope: how far strips take part, 0 to 1
template <class T, std::size_t n>
StripRow<T, n> next_loads(Matrix<T, n> const& k, Strips<T, n> const& s, StripRow<T, n> const& w, StripRow<T, n>& on) {
  using std::sqrt;
  T sum(0.0), length(0.0);
  for (std::size_t j = 0; j < n; ++j) {
    sum += select(w[j] > 0.0, w[j], T(0.0)) * s.width[j];
    length += s.width[j];
  }
  T const band2 = square(T(2.0 * fading * sum / length + 1e-30));
  StripRow<T, n> b, diagonal;
  for (std::size_t j = 0; j < n; ++j) {
    T deflection(0.0);
    for (std::size_t i = 0; i < n; ++i) deflection += k[j][i] * w[i];
    T const e = w[j] + (s.interpenetration[j] - deflection) * reciprocal(k[j][j]);
    T const root = sqrt(e * e + band2);
    // e + root, without cancellation.
    T const sum_up = select(e > 0.0, T(e + root), T(band2 / (root + select(e > 0.0, e, T(-e)))));
    on[j] = 0.5 * sum_up / root;
    // Divided by the slope over K_jj: w = s + s' (w - w_last) - ...
    T const scale = k[j][j] / on[j];
    diagonal[j] = scale - k[j][j];
    b[j] = s.interpenetration[j] + scale * (0.5 * sum_up - on[j] * e);
  }
  return solved(k, diagonal, b);
}

/// q of (S4) on the loaded strips: on_j (sum_i S_ji on_i v_i - A_j) + (1 - on_j) S_jj v_j = 0.
template <class T, std::size_t n>
StripRow<T, n> conformities(Matrix<T, n> const& s, StripRow<T, n> const& on, StripRow<T, n> const& curvature) {
  StripRow<T, n> diagonal, inverse;
  for (std::size_t j = 0; j < n; ++j) {
    inverse[j] = reciprocal(on[j]);
    diagonal[j] = (1.0 - on[j]) * inverse[j] * inverse[j] * s[j][j];
  }
  StripRow<T, n> q = solved(s, diagonal, curvature);
  for (std::size_t j = 0; j < n; ++j) q[j] = q[j] * inverse[j];
  return q;
}

/// a from w and q (S4), kept above zero.
template <class T, std::size_t n>
void lengths_from_load(Strips<T, n>& s, StripRow<T, n> const& conformity) {
  using std::sqrt;
  for (std::size_t i = 0; i < n; ++i)
    s.half_length[i] = sqrt(2.0 * s.compliance * s.load[i] * reciprocal(conformity[i]) + s.shortest2);
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
    conformity[i] = e.pressure_gradient;
  }
}

}  // namespace strip_detail

/// Fills load, half_length, on and change.
///
/// @param passes  of loads and lengths, three or more
template <class T, std::size_t n>
void solve_strips(StripTables const& tables, Strips<T, n>& s, int passes) {
  using namespace strip_detail;
  using std::sqrt;
  StripRow<T, n> conformity, w, before;
  auto& on = s.on;
  start_from_hertz(s, conformity);
  for (std::size_t j = 0; j < n; ++j) w[j] = 0.5 * conformity[j] * s.half_length[j] * s.half_length[j];
  Influences<T, n> base, rate, influence;
  T const inverse = 1.0 / T(s.compliance);
  T const damping = 0.4 * smooth_step(T((-0.5 - s.ellipse.place.x) * 0.4));
  T last(0.0), force(0.0);
  for (int pass = 0; pass < passes; ++pass) {
    int const left = passes - pass;  // with this one
    if (left > 3) {
      read_influences(tables.kernel, s, influence);
    } else if (left == 3) {
      before = s.half_length;
      read_influences(tables.kernel, s, base, &rate);
    } else {  // half-lengths hardly change any more
      follow(base, rate, before, s.half_length, influence);
    }
    auto const& now = left == 3 ? base : influence;
    w = next_loads(now.deflection, s, w, on);
    last = force;
    force = T(0.0);
    for (std::size_t j = 0; j < n; ++j) {
      s.load[j] = inverse * select(w[j] > 0.0, w[j], T(0.0));
      force += s.load[j] * s.width[j];
    }
    auto const q = conformities(now.curvature, on, s.curvature);
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
