// contact/material.hpp - elastic constants shared by wheel and roller.
#pragma once

namespace rollerrig {

struct Material {
  double shear_modulus{82.03125e9};  ///< G [Pa]
  double poisson_ratio{0.28};        ///< nu [-]

  /// Q = (1 - nu)/G [1/Pa], eq. (13): twice the plane-strain compliance (1 - nu^2)/E of one body.
  double compliance() const { return (1.0 - poisson_ratio) / shear_modulus; }
};

}  // namespace rollerrig
