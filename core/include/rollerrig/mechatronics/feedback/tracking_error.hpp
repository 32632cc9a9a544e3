// mechatronics/feedback/tracking_error.hpp - what the feedback of a roller's drive acts on at one sample.
#pragma once
#include "rollerrig/mechatronics/estimator/axle_sample.hpp"

namespace rollerrig {

struct TrackingError {
  double feed_forward{};  ///< (D5) [N m]
  double error{};         ///< virtual minus measured wheel speed [rad/s]
  double period{};        ///< since the last sample [s]
};

}  // namespace rollerrig
