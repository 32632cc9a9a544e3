#include "rollerrig/contact/normal/strip_kernel.hpp"

#include "rollerrig/contact/normal/hertz.hpp"

namespace rollerrig {
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
