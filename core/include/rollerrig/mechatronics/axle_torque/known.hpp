// mechatronics/axle_torque/known.hpp - the axle's torque from cylinder pressure and motor current, corrected by the estimate.
//
//     K = C_motor + f C_brake(p, w),   C = K + G_c (C_e - G_e K)        (D18)
//
// The known torque K has no lag and may be wrong in size; the estimate C_e is right in the mean and late. G_e has the lag of the
// estimator, so that a change which both see is no error; G_c is slow.
//
// Source  complementary filter; docs/theory/rig_control.md.
#pragma once
#include <cmath>
#include <string_view>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/axle_torque/torque_sample.hpp"

namespace rollerrig {

struct KnownTorque {
  static constexpr char const* name = "known";
  double bandwidth{}, brake_friction{};

  static constexpr auto fields() {
    return members(Member{"bandwidth", &KnownTorque::bandwidth, "rad/s",
                          "bandwidth of the correction by the estimate, G_c", positive},
                   Member{"brake_friction", &KnownTorque::brake_friction, "1",
                          "friction of the pads as assumed, over the real one, f", not_negative});
  }

  struct State {
    double late{};        ///< G_e K [N m]
    double correction{};  ///< [N m]
    void state(auto& archive) { archive(late, correction); }
  };

  double step(State& s, TorqueSample const& now, double period) const {
    double const known = now.motor + brake_friction * now.brake;
    s.late += (now.bandwidth > 0.0 ? 1.0 - std::exp(-now.bandwidth * period) : 1.0) * (known - s.late);
    s.correction += (1.0 - std::exp(-bandwidth * period)) * (now.estimate - s.late - s.correction);
    return known + s.correction;
  }
};

}  // namespace rollerrig
