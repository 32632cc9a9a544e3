// Exact solution: a mass m meets an undamped Hertz spring N = k |p|^(3/2) at speed v0.
//
// Energy gives   m v0^2 / 2 = (2/5) k d_max^(5/2)
// quadrature     t_contact  = 2 (d_max / v0) * Integral_0^1 dx / sqrt(1 - x^(5/2))
//                           = (4/5) B(2/5, 1/2) d_max / v0
// Source: Johnson, Contact Mechanics (1985), ch. 11.
#pragma once
#include <cmath>

namespace rollerrig::exact {

struct HertzImpact {
  double m, k, v0;  // [kg], [N/m^1.5], [m/s]

  double max_depth() const { return std::pow(5 * m * v0 * v0 / (4 * k), 2.0 / 5); }
  double duration() const {
    double const beta = std::tgamma(0.4) * std::tgamma(0.5) / std::tgamma(0.9);
    return 0.8 * beta * max_depth() / v0;
  }
};

}  // namespace rollerrig::exact
