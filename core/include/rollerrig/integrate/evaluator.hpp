// integrate/evaluator.hpp - the system as the methods see it: one vector y = (x, z), calls counted.
//
// In:  a DifferentialEquation.  Out: y' = (f, g) and its Jacobian, with the statistics kept.
#pragma once
#include <Eigen/Core>

#include "rollerrig/integrate/differential_equation.hpp"
#include "rollerrig/integrate/options.hpp"

namespace rollerrig::integrate {

using Vector = Eigen::VectorXd;

/// One attempted step.
struct Step {
  double t;    ///< [s] start
  double h;    ///< [s] length
  double end;  ///< [s] time given to the stages at the end: t + h, or just before a breakpoint, so
               ///< that an input which jumps there is still taken from the left
};

template <DifferentialEquation System>
class Evaluator {
 public:
  explicit Evaluator(System& system) : system_{&system}, sizes_{system.sizes()} {}

  Sizes sizes() const { return sizes_; }
  System& system() const { return *system_; }

  /// y_dot = (f, g) at (t, y); the z-part of y is not read.
  Status derivative(double t, Vector const& y, Vector& y_dot) {
    ++statistics.derivative_calls;
    return system_->derivative(t, y.data(), y_dot.data(), y_dot.data() + sizes_.states);
  }

  Status jacobian(double t, Vector const& y, JacobianData& j) {
    ++statistics.jacobian_calls;
    if constexpr (HasJacobian<System>) {
      return system_->jacobian(t, y.data(), j);
    } else {
      return Status::not_finite;  // unreachable: Integrator's constructor refuses such a method
    }
  }

  Statistics statistics;

 private:
  System* system_;
  Sizes sizes_;
};

}  // namespace rollerrig::integrate
