// realtime/statistics.hpp - what a server tells of itself while it runs and at its end.
//
//   loop -> [statistics] -> the watching thread, the command line
#pragma once
#include <atomic>

#include "rollerrig/realtime/histogram.hpp"

namespace rollerrig::realtime {

struct Statistics {
  Histogram step;             ///< from the sensors' sending to the end of the step: what a period has to hold
  Histogram wake;             ///< from the deadline to the waking
  Counter periods;            ///< that were computed
  Counter waited;             ///< before the first command
  Counter misses;             ///< periods whose step ended after the next deadline
  Counter skipped;            ///< deadlines given up because a step took several periods
  Counter trips;              ///< of the watchdog
  Counter first_trip;         ///< simulated time of it [ns]
  Counter silent;             ///< periods since the last command
  Counter longest_silent;     ///< of them, since the first command
  Counter time;               ///< simulated [ns]
  std::atomic<int> state{0};  ///< RR_WAITING to RR_ENDED
};

}  // namespace rollerrig::realtime
