// mechatronics/estimator_response.hpp - what an estimator's bandwidth and delay really are: it is run and measured.
//
//   sine of contact force or axle torque -> speeds of roller and wheel, sampled -> [estimator] -> amplitude and phase
#pragma once
#include "rollerrig/mechatronics/contact_force_estimator.hpp"

namespace rollerrig {

struct EstimatorResponse {
  double bandwidth{
      0.0};           ///< where the estimate is down to 1/sqrt(2) [rad/s]; of the samples' half rate where it never is
  double delay{0.0};  ///< of slow changes, ideal sensors [s]
};

enum class Estimated : int { force, torque };

/// Measured on a roller and a wheel that are what the estimator believes, with exact speeds.
EstimatorResponse measure_response(ContactForceEstimator const& p, Estimated what, double period);

}  // namespace rollerrig
