// mechatronics/track_brake/magnetic.hpp - magnets that are lowered to the rail and rub on it.
//
//     F(v) = N mu(|v|) v/sqrt(v^2 + v_r^2)        (A20)
//
// The attraction N stands between magnet and rail: it loads no wheel and unloads none. mu falls with speed as the law says that
// the case names; what lies on the rail, and what rubbing magnets clean of it, is not part of it.
#pragma once
#include <tuple>

#include "rollerrig/contact/adhesion/friction_laws.hpp"

namespace rollerrig {

struct MagneticTrackBrake {
  static constexpr char const* name = "magnetic";

  double attraction{};
  FrictionLaw friction{};  ///< mu of pole shoes on the rail, over speed
  double regularisation_speed{};

  static constexpr auto fields() {
    using P = MagneticTrackBrake;
    return members(
        Member{"attraction", &P::attraction, "N", "attraction of all magnets of a bogie together, N", not_negative},
        Member{"friction", &P::friction},
        Member{"regularisation_speed", &P::regularisation_speed, "m/s",
               "speed below which friction turns into viscous drag, v_r", positive});
  }

  /// Against running [N], at a speed over the rail [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    using std::sqrt;
    T const fast = select(speed < 0.0, -speed, speed);
    return attraction * friction_at(friction, fast) * speed /
           sqrt(speed * speed + regularisation_speed * regularisation_speed);
  }
};

}  // namespace rollerrig
