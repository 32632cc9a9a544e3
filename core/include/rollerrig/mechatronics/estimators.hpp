// mechatronics/estimators.hpp - the estimators of contact force and axle torque that a case can name.
//
// To add one: a header in estimator/, its line in AnyEstimator, its parameters in python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <variant>

#include "rollerrig/mechatronics/estimator/exact.hpp"
#include "rollerrig/mechatronics/estimator/filtered_derivative.hpp"
#include "rollerrig/mechatronics/estimator/kalman.hpp"
#include "rollerrig/mechatronics/estimator/observer.hpp"

namespace rollerrig {

using AnyEstimator = std::variant<DisturbanceObserver, FilteredDerivative, KalmanFilter, ExactForces>;

/// Bandwidth and delay that an estimate really has.
struct EstimatorResponse {
  double bandwidth{};  ///< where the estimate is down to 1/sqrt(2) [rad/s]; half the sampling rate where it never is
  double delay{};      ///< of slow changes, ideal sensors [s]
};

enum class Estimated : int { force, torque };

/// Measured with a sine of force or torque, on a roller and a wheel that are as assumed, with exact speeds.
EstimatorResponse measure_response(AnyEstimator const& estimator, AssumedParameters const& assumed, Estimated what,
                                   double period);

}  // namespace rollerrig
