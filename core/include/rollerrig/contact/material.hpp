// contact/material.hpp - elastic constants shared by wheel and roller.
#pragma once
#include "rollerrig/fields.hpp"

namespace rollerrig {

struct Material {
  double shear_modulus{82.03125e9}, poisson_ratio{0.28};
  static constexpr auto fields() {
    return members(Member{"shear_modulus", &Material::shear_modulus, "Pa", "shear modulus, G", positive},
                   Member{"poisson_ratio", &Material::poisson_ratio, "1", "Poisson's ratio, nu", poissons_ratio});
  }

  /// Q = (1 - nu)/G [1/Pa], eq. (13): twice the plane-strain compliance (1 - nu^2)/E of one body.
  double compliance() const { return (1.0 - poisson_ratio) / shear_modulus; }
};

}  // namespace rollerrig
