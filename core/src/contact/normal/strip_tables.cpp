#include "rollerrig/contact/normal/strip_tables.hpp"

#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/contact/normal/strip_patch.hpp"

namespace rollerrig {
namespace {

/// What Hertz' theory says of a parabola with A = 1 over what the strips make of it.
struct Ratios {
  double force, a, b, peak, width;
};

Ratios exact_over_strips(StripTables const& tables, double x) {
  HertzTable const& hertz = hertz_table();
  double const depth = 1e-4, across = std::exp(-x), sum = 1.0 + across;
  Strips<double> s;
  StripPlaces<double> places;
  lay_over_paraboloid(tables, 1.0, 0.0, across, depth, s, places);
  StripRow<double> all;
  all.fill(1.0);
  solve_strips(tables, s, strip_passes);
  auto const part = part_of(tables, s, places, all);
  double const root = std::sqrt(depth / sum);
  double const a = hertz.semi_axis.at(x).value * root, b = hertz.semi_axis.at(-x).value * root;
  double const force = hertz.stiffness.at(x).value / std::sqrt(sum) * depth * std::sqrt(depth) / pi;  // Q = pi here
  return {force / part.normal, a / part.a, b / part.b, 1.5 * force / (pi * a * b) / part.peak_pressure,
          2.0 * b / part.width};
}

}  // namespace

/// Cubic pieces through f, slopes from differences.
template <class F>
void StripTables::tabulate(StartFunction function, F const& f) {
  double const end = std::log(HertzTable::limit), step = 2.0 * end / pieces;
  std::vector<double> value;
  for (int i = 0; i <= pieces; ++i) value.push_back(f(std::clamp(-end + step * i, -end, end)));
  auto const slope = [&](std::size_t i) {
    std::size_t const low = i == 0 ? 0 : i - 1, high = std::min(i + 1, value.size() - 1);
    return (value[high] - value[low]) / (step * static_cast<double>(high - low));
  };
  for (std::size_t i = 0; i < pieces; ++i)
    pieces_[i][static_cast<std::size_t>(function)] = hermite(step, value[i], value[i + 1], slope(i), slope(i + 1));
}

StripTables::StripTables() {
  HertzTable const& hertz = hertz_table();
  auto const square_axis = [&](double x) { return square(hertz.semi_axis.at(x).value); };
  tabulate(StartFunction::length, square_axis);
  tabulate(StartFunction::breadth, [&](double x) { return square_axis(-x); });
  constexpr StartFunction corrections[] = {StartFunction::force, StartFunction::half_length, StartFunction::half_width,
                                           StartFunction::peak_pressure, StartFunction::width};
  constexpr double Ratios::* ratios[] = {&Ratios::force, &Ratios::a, &Ratios::b, &Ratios::peak, &Ratios::width};
  for (auto f : corrections) tabulate(f, [](double) { return 1.0; });
  // Each knot once, with corrections of one still in place.
  double const end = std::log(HertzTable::limit), step = 2.0 * end / pieces;
  std::vector<Ratios> at_knot;
  for (int i = 0; i <= pieces; ++i) at_knot.push_back(exact_over_strips(*this, std::clamp(-end + step * i, -end, end)));
  for (std::size_t k = 0; k < std::size(corrections); ++k)
    tabulate(corrections[k],
             [&](double x) { return at_knot[static_cast<std::size_t>(std::lround((x + end) / step))].*ratios[k]; });
}

StripTables const& strip_tables() {
  static StripTables const tables;
  return tables;
}

namespace {

double deflection_slope(double k) {
  double const root = std::sqrt(1.0 + k * k);
  if (k > 100.0) return (1.0 + 0.375 / (root * root)) / root;  // K - E would cancel
  auto const [e, elliptic_k] = elliptic_integrals(k / root);
  return 4.0 / pi * root * (elliptic_k - e);  // (S1)
}

double curvature_value(double k) {
  double const g = k / std::sqrt(1.0 + k * k);
  return 4.0 / pi * g * elliptic_integrals(g).k;  // (S2)
}

/// Integral of f by Gauss and Legendre, five points.
template <class F>
double integral(F const& f, double a, double b) {
  double const x[] = {0.0, 0.5384693101056831, 0.9061798459386640};
  double const w[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  double const middle = 0.5 * (a + b);
  double const half = 0.5 * (b - a);
  double sum = w[0] * f(middle);
  for (int i = 1; i < 3; ++i) sum += w[i] * (f(middle - half * x[i]) + f(middle + half * x[i]));
  return half * sum;
}

}  // namespace

StripKernel::StripKernel() {
  double k0 = std::ldexp(1.0, lowest_octave);
  double deflection = 4.0 / pi * k0 * std::log(4.0 / k0);  // Psi near zero
  double curvature = curvature_value(k0);
  auto& [own_deflection, own_curvature, mutual] = cells_;
  // Below the table nothing is looked up.
  for (auto* cells : {&own_deflection, &own_curvature, &mutual}) cells->push_back({});
  auto const slope = [](double k) {
    double const step = 1e-4 * k;
    return (deflection_slope(k + step) - deflection_slope(k - step)) / (2.0 * step);
  };
  for (int octave = lowest_octave; octave < lowest_octave + octaves; ++octave)
    for (int part = 0; part < 8; ++part) {
      double const step = std::ldexp(0.125, octave);
      double const k1 = k0 + step;
      double const next_deflection = deflection + integral(deflection_slope, k0, k1);
      double const next_curvature = curvature_value(k1);
      double const m0 = deflection_slope(k0), m1 = deflection_slope(k1);
      own_deflection.push_back(hermite(step, deflection, next_deflection, m0, m1));
      own_curvature.push_back(hermite(step, curvature, next_curvature, m0 / (1.0 + k0 * k0), m1 / (1.0 + k1 * k1)));
      mutual.push_back(hermite(step, m0, m1, slope(k0), slope(k1)));
      k0 = k1, deflection = next_deflection, curvature = next_curvature;
    }
}

}  // namespace rollerrig
