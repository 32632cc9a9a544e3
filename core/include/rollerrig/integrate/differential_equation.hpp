// differential_equation.hpp - what an integrator asks of a system, and nothing more.
//
//   system -> [x' = f(t, x),  z' = g(t, x)] -> integrate
//
// x are the states, z the quadratures: they accumulate (work, heat, wheel angles) and act back on
// nothing, so they cost no row in a linear solve and take no part in the step size control.
#pragma once
#include <Eigen/Core>
#include <concepts>

#include "rollerrig/integrate/stiff_modes.hpp"
#include "rollerrig/status.hpp"

namespace rollerrig {

struct Sizes {
  int states = 0;       ///< n, length of x
  int quadratures = 0;  ///< m, length of z
};

/// Derivatives of f and g at one (t, x), owned by the integrator and filled by the system.
struct JacobianData {
  Eigen::MatrixXd a;    ///< (n, n) df/dx
  Eigen::MatrixXd g;    ///< (m, n) dg/dx
  Eigen::VectorXd f_t;  ///< (n)    df/dt, from the right where an input has a kink
  Eigen::VectorXd g_t;  ///< (m)    dg/dt, from the right

  JacobianData() = default;
  explicit JacobianData(Sizes sizes)
      : a(Eigen::MatrixXd::Zero(sizes.states, sizes.states)),
        g(Eigen::MatrixXd::Zero(sizes.quadratures, sizes.states)),
        f_t(Eigen::VectorXd::Zero(sizes.states)),
        g_t(Eigen::VectorXd::Zero(sizes.quadratures)) {}

  void state(auto& archive) { archive(a, g, f_t, g_t); }
};

/// The least an integrator can work with.  z_dot may be a null pointer: then only f is wanted.
template <class S>
concept DifferentialEquation = requires(S& system, double t, double const* x, double* x_dot, double* z_dot) {
  { system.sizes() } -> std::convertible_to<Sizes>;
  { system.derivative(t, x, x_dot, z_dot) } -> std::same_as<Status>;
};

/// Needed by the implicit methods.  Every entry of J must be written: J keeps its last values.
template <class S>
concept HasJacobian = requires(S& system, double t, double const* x, JacobianData& j) {
  { system.jacobian(t, x, j) } -> std::same_as<Status>;
};

/// Optional: called at the start and after each accepted step, to check validity and to refresh caches.
/// A Status that is not ok ends the integration there; the step itself is kept.
template <class S>
concept HasAccept = requires(S& system, double t, double const* x) {
  { system.accept(t, x) } -> std::same_as<Status>;
};

/// Optional: x'[i] = x[velocity_column(i)] for i < kinematic_states(), with
/// velocity_column(i) >= kinematic_states().  Implicit methods then factor only the remaining block.
template <class S>
concept HasKinematicStates = requires(S const& system, int i) {
  { system.kinematic_states() } -> std::convertible_to<int>;
  { system.velocity_column(i) } -> std::convertible_to<int>;
};

/// Optional: combinations of states that decay fast: inner nodes of dampers, or slip against creep forces that grow with it. An
/// exponential method integrates their decay exactly.
///
/// stiff_modes() returns an empty set with room for all there can be. renew_stiff_modes(now, next) looks at
/// what derivative() evaluated last, and fills `next` and returns true where that asks for others than `now`.
template <class S>
concept HasStiffModes = requires(S& system, StiffModes const& now, StiffModes& next) {
  { system.stiff_modes() } -> std::same_as<StiffModes>;
  { system.renew_stiff_modes(now, next) } -> std::same_as<bool>;
};

}  // namespace rollerrig
