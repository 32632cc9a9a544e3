// Tables built once at model set-up: Hertz functions from exact elliptic integrals, Kalker's coefficients, nodes of
// the strip theory.
#include <cmath>

#include "rollerrig/contact/creep/strip_theory.hpp"
#include "rollerrig/contact/normal/hertz.hpp"

namespace rollerrig {

EllipticIntegrals elliptic_integrals(double g) {
  // K = pi / (2 agm(1, g)); E = K (1 - sum 2^(n-1) c_n^2). Abramowitz and Stegun 17.6.
  double a = 1.0;
  double b = g;
  double sum = 0.5 * (1.0 - g * g);
  double power = 1.0;
  while (true) {
    double const c = 0.5 * (a - b);
    double const mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
    sum += power * c * c;
    power *= 2.0;
    if (std::abs(c) < 1e-9 * a) break;  // converges quadratically: the next c is below 1e-18
  }
  double const k = pi / (2.0 * a);
  return {k * (1.0 - sum), k};
}

namespace {

/// Smaller/larger of D1, D2 for an axis ratio g: (16) solved for D, with C and D of (19) written by E and K.
double curvature_ratio_of(double g) {
  auto const [e, k] = elliptic_integrals(g);
  double const g2 = g * g;
  // With m = 1 - g^2: larger/smaller = (E/g^2 - K)/(K - E).
  return (1.0 - g < 1e-8) ? 1.0 : (k - e) / (e / g2 - k);
}

}  // namespace

double axis_ratio(double curvature_ratio) {
  if (curvature_ratio >= 1.0) return 1.0;
  double low = std::log(1e-6);
  double high = 0.0;
  for (int i = 0; i < 200 && high - low > 1e-16; ++i) {
    double const mid = 0.5 * (low + high);
    (curvature_ratio_of(std::exp(mid)) < curvature_ratio ? low : high) = mid;
  }
  return std::exp(0.5 * (low + high));
}

namespace {

struct HertzFunctions {
  double semi_axis, stiffness, log_aspect;
};

/// The three tabulated functions at x = ln(D1/D2); a is the longer axis for x < 0.
HertzFunctions hertz_functions(double x) {
  double const g = axis_ratio(std::exp(-std::abs(x)));
  auto const [e, k] = elliptic_integrals(g);
  double const minor = std::sqrt(e / k);                                                        // (17)
  return {x < 0.0 ? minor / g : minor, 2.0 * pi / 3.0 * std::sqrt(e) / (g * k * std::sqrt(k)),  // (13)
          x < 0.0 ? -std::log(g) : std::log(g)};
}

/// Cubic Hermite pieces through f(start + i step), slopes by eighth-order differences.
template <class F>
UniformSpline tabulate(F const& f, double start, double step, int pieces) {
  UniformSpline table{start, step, {}};
  std::vector<double> v(at(pieces) + 9);
  for (int i = -4; i <= pieces + 4; ++i) v[at(i + 4)] = f(start + step * i);
  auto const slope = [&](int i) {
    double const* p = &v[at(i + 4)];
    return (4.0 / 5.0 * (p[1] - p[-1]) - 1.0 / 5.0 * (p[2] - p[-2]) + 4.0 / 105.0 * (p[3] - p[-3]) -
            1.0 / 280.0 * (p[4] - p[-4]));
  };
  for (int i = 0; i < pieces; ++i) {
    double const f0 = v[at(i + 4)];
    double const f1 = v[at(i + 5)];
    double const m0 = slope(i);
    double const m1 = slope(i + 1);
    double const jump = f1 - f0;
    table.pieces.push_back(
        {f0, m0 / step, (3.0 * jump - 2.0 * m0 - m1) / (step * step), (m0 + m1 - 2.0 * jump) / (step * step * step)});
  }
  return table;
}

}  // namespace

HertzTable::HertzTable() {
  double const step = 0.01;
  int const half = static_cast<int>(std::ceil(std::log(limit) / step)) + 1;
  auto const build = [&](double HertzFunctions::* field) {
    return tabulate([field](double x) { return hertz_functions(x).*field; }, -step * half, step, 2 * half);
  };
  semi_axis = build(&HertzFunctions::semi_axis);
  stiffness = build(&HertzFunctions::stiffness);
  log_aspect = build(&HertzFunctions::log_aspect);
}

HertzTable const& hertz_table() {
  static HertzTable const table;
  return table;
}

KalkerTable::KalkerTable(double nu) {
  std::array<std::array<double, knots>, 4> c{};
  for (std::size_t i = 0; i < knots; ++i) {
    auto const& row = kalker_rows[i];
    knot_[i] = std::log(row.a_over_b);
    // Lagrange's quadratic through nu = 0, 1/4, 1/2.
    double const w0 = 8.0 * (nu - 0.25) * (nu - 0.5);
    double const w1 = -16.0 * nu * (nu - 0.5);
    double const w2 = 8.0 * nu * (nu - 0.25);
    for (std::size_t k = 0; k < 4; ++k) c[k][i] = w0 * row.value[0][k] + w1 * row.value[1][k] + w2 * row.value[2][k];
  }
  // Natural cubic spline through the knots, one per coefficient (tridiagonal system for the second derivatives).
  for (std::size_t k = 0; k < 4; ++k) {
    std::array<double, knots> second{};
    std::array<double, knots> ratio{};
    for (std::size_t i = 1; i + 1 < knots; ++i) {
      double const h0 = knot_[i] - knot_[i - 1];
      double const h1 = knot_[i + 1] - knot_[i];
      double const right = 6.0 * ((c[k][i + 1] - c[k][i]) / h1 - (c[k][i] - c[k][i - 1]) / h0);
      double const pivot = 2.0 * (h0 + h1) - h0 * ratio[i - 1];
      ratio[i] = h1 / pivot;
      second[i] = (right - h0 * second[i - 1]) / pivot;
    }
    for (std::size_t i = knots - 2; i >= 1; --i) second[i] -= ratio[i] * second[i + 1];
    for (std::size_t i = 0; i + 1 < knots; ++i) {
      double const h = knot_[i + 1] - knot_[i];
      piece_[i][k] = {c[k][i], (c[k][i + 1] - c[k][i]) / h - h * (2.0 * second[i] + second[i + 1]) / 6.0,
                      0.5 * second[i], (second[i + 1] - second[i]) / (6.0 * h)};
    }
  }
}

}  // namespace rollerrig

namespace rollerrig::strip_theory {

/// Chebyshev's nodes of the second kind: the area is exact, the load to 1e-5.
EllipseNodes::EllipseNodes() {
  double sum = 0.0;
  for (std::size_t k = 0; k < node_count; ++k) {
    double const angle = (static_cast<double>(k) + 1.0) * pi / (node_count + 1.0);
    cosine[k] = std::cos(angle);
    sine[k] = std::sin(angle);
    area[k] = 2.0 / (node_count + 1.0) * sine[k] * sine[k];
    load[k] = area[k] * sine[k];
    sum += load[k];
  }
  for (double& of_node : load) of_node /= sum;
}

EllipseNodes const& ellipse_nodes() {
  static EllipseNodes const nodes;
  return nodes;
}

}  // namespace rollerrig::strip_theory
