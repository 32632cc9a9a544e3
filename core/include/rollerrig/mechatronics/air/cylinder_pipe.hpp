// mechatronics/air/cylinder_pipe.hpp - the pipes from a relay valve to the dump valves of its axles.
//
//   length, diameter -> [tube] -> C = 0.029 d^2/sqrt(L/d^1.25 + 510), b = 474 C/d^2 in m, s, Pa       (A25)
//
// Source  P. Beater, Pneumatic Drives, Springer (2007), after J. Eckersten, from memory; a test compares it with Fanno's flow.
#pragma once
#include <cmath>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/orifice.hpp"

namespace rollerrig {

/// Of one cylinder; all cylinders behind a relay valve have their own, of the same size.
struct CylinderPipe {
  double length{}, diameter{}, relay_conductance{};

  static constexpr auto fields() {
    using P = CylinderPipe;
    return members(
        Member{"length", &P::length, "m", "length of the pipe from the relay valve to a dump valve, L", positive},
        Member{"diameter", &P::diameter, "m", "inner diameter of that pipe, d", positive},
        Member{"relay_conductance", &P::relay_conductance, "m^3/(s Pa)",
               "sonic conductance of a relay valve that is wide open, C", not_negative});
  }

  double volume() const { return 0.25 * 3.14159265358979323846 * diameter * diameter * length; }
  Orifice tube() const {
    double const square = diameter * diameter;
    double const conductance = 0.029 * square / std::sqrt(length / std::pow(diameter, 1.25) + 510.0);
    return {conductance, 474.0 * conductance / square};
  }
};

}  // namespace rollerrig
