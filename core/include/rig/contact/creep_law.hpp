// contact/creep_law.hpp - from creepage and ellipse to the tangential force and spin moment on the wheel.
//
// Signs   forces act on the wheel, along i (rolling direction) and t = n x i; the moment about n, out of the roller.
//         Creepage: velocity of the wheel's point relative to the roller's, over the rolling speed.
// To add a law: write a struct with the call operator below, give it a name in CreepLawKind and a line in creep_force();
// how a configuration then asks for it is in docs/how_to/contact_law.md.
// Source  Malvezzi, Meli, Pugi (2010), eqs (20)-(24); Kalker (1967); Vermeulen and Johnson (1964) for (23).
#pragma once
#include "rig/contact/kalker.hpp"

namespace rig {

/// Eq. (21), with the corrections stated in docs/theory/contact_forces.md.
template <Scalar T>
struct Creepage {
  T longitudinal;  ///< epsilon_x [-]
  T lateral;       ///< epsilon_y [-]
  T spin;          ///< epsilon_sp [1/m]
};

/// f_ij of eq. (22).
template <Scalar T>
struct KalkerStiffness {
  T f11;  ///< [N]
  T f22;  ///< [N]
  T f23;  ///< [N m], signed with the direction of rolling
  T f33;  ///< [N m^2]
};

template <Scalar T>
struct CreepForce {
  T longitudinal;  ///< T_x [N]
  T lateral;       ///< T_y [N]
  T spin_moment;   ///< M_sp [N m]
  T saturation;    ///< epsilon of (23): 1 in full adhesion, towards 0 in gross sliding
};

/// Eq. (22).
///
/// @param direction  rolling direction: +1 forward, -1 backward, smooth in between; the spin force changes sign with it
template <Scalar T>
KalkerStiffness<T> kalker_stiffness(KalkerCoefficients<T> const& c, double shear_modulus, T const& a, T const& b,
                                    T const& direction) {
  using std::sqrt;
  T const ab = a * b;
  T const g_ab = shear_modulus * ab;
  return {g_ab * c.c11, g_ab * c.c22, g_ab * sqrt(ab) * c.c23 * direction, g_ab * ab * c.c33};
}

/// Eq. (20): no limit of adhesion.
struct KalkerLinear {
  template <Scalar T>
  CreepForce<T> operator()(Creepage<T> const& e, KalkerStiffness<T> const& f, T const& /*adhesion*/) const {
    return {-(f.f11 * e.longitudinal), -(f.f22 * e.lateral) - f.f23 * e.spin, f.f23 * e.lateral - f.f33 * e.spin,
            T(1.0)};
  }
};

/// Eqs (20), (23), (24): the paper's law. The spin moment stays unsaturated as published unless asked otherwise.
struct KalkerSaturated {
  bool saturate_spin_moment{false};

  /// @param adhesion  T_s = mu N [N]; must be positive
  template <Scalar T>
  CreepForce<T> operator()(Creepage<T> const& e, KalkerStiffness<T> const& f, T const& adhesion) const {
    using std::sqrt;
    auto const linear = KalkerLinear{}(e, f, adhesion);  // (20)
    T const tx = linear.longitudinal;
    T const ty = linear.lateral;
    T const tau = sqrt(tx * tx + ty * ty + 1e-20) / adhesion;  // the tiny term keeps the slope finite at zero creepage
    T const partial = 1.0 - tau / 3.0 + tau * tau / 27.0;
    T const epsilon = select(tau < 3.0, partial, 1.0 / tau);  // (23)
    T const moment = saturate_spin_moment ? epsilon * linear.spin_moment : linear.spin_moment;
    return {epsilon * tx, epsilon * ty, moment, epsilon};  // (24)
  }
};

enum class CreepLawKind : int { kalker_linear, kalker_saturated };

struct CreepLaw {
  CreepLawKind kind{CreepLawKind::kalker_saturated};
  bool saturate_spin_moment{false};
};

template <Scalar T>
CreepForce<T> creep_force(CreepLaw const& law, Creepage<T> const& e, KalkerStiffness<T> const& f, T const& adhesion) {
  switch (law.kind) {
    case CreepLawKind::kalker_linear: return KalkerLinear{}(e, f, adhesion);
    case CreepLawKind::kalker_saturated: break;
  }
  return KalkerSaturated{law.saturate_spin_moment}(e, f, adhesion);
}

}  // namespace rig
