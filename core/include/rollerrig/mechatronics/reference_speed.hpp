// mechatronics/reference_speed.hpp - the train's speed as slide protection and wheel-slip control estimate it from the axles.
//
//   axle nearest to the train (fastest in braking, slowest in traction) -> [reference] -> speed; which axle is released
//
// While some axle grips, the nearest one runs at train speed. While none does, the reference follows the last known slope, and at
// intervals one axle in turn is released from its torque until it runs at train speed again: that corrects speed and slope.
// Braking is traction with all speeds negative. Source: docs/theory/adhesion.md, (A7).
#pragma once
#include <cmath>

#include "rollerrig/mechatronics/measurements.hpp"

namespace rollerrig {

struct ReferenceSpeedRules {
  double steepest{};          ///< largest rate of the train's speed [m/s^2]
  double gentlest{};          ///< least rate of a train that is braked or pulled [m/s^2]
  double release_interval{};  ///< 0: never [s]
  double shortest_release{};  ///< [s]
  double longest_release{};   ///< [s]
};

class ReferenceSpeed {
 public:
  static constexpr int none = -1;

  ReferenceSpeed(bool braking, double speed) : sign_{braking ? -1.0 : 1.0}, value_{speed}, known_{speed} {}

  /// One sample on.
  ///
  /// @param nearest  speed of the axle nearest to the train [m/s]
  void advance(double nearest, double period) {
    value_ = sign_ * std::fmin(sign_ * nearest, sign_ * value_ + slope_ * period);
    since_known_ += period;
  }

  /// Some axle grips: the value is the train's speed.
  void is_known(ReferenceSpeedRules const& rules) {
    released_ = none;
    slope_ = rules.steepest;
    know(value_);
  }

  /// No axle grips: release one after the other.
  ///
  /// @param still_runs  still_runs(axle): whether it has not yet come to the train's speed
  template <class StillRuns>
  void search(ReferenceSpeedRules const& rules, double nearest, int axles, double period, StillRuns&& still_runs) {
    if (released_ == none) {
      if (rules.release_interval > 0.0 && since_known_ > rules.release_interval) {
        released_ = next_ = (next_ + 1) % axles;
        released_for_ = 0.0;
      }
      return;
    }
    released_for_ += period;
    bool const early = released_for_ < rules.shortest_release || still_runs(released_);
    if (released_for_ < rules.longest_release && early) return;
    double const slope = sign_ * (nearest - known_) / since_known_;
    slope_ = std::fmin(rules.steepest, std::fmax(rules.gentlest, slope));
    value_ = nearest;
    released_ = none;
    know(nearest);
  }

  double value() const { return value_; }
  double sign() const { return sign_; }  ///< 1 of a train that is pulled, -1 of one that is braked
  bool releases(int axle) const { return axle == released_; }
  void state(auto& archive) {
    archive(sign_, value_, slope_, known_, since_known_, released_for_);
    for (int* axle : {&released_, &next_}) archive.within(*axle, none, most_axles - 1);
  }

 private:
  void know(double speed) {
    known_ = speed;
    since_known_ = 0.0;
  }

  double sign_;
  double value_, slope_{0.0};
  double known_, since_known_{0.0};  ///< the train's speed when it was last known [m/s], and how long ago [s]
  int released_{none}, next_{none};
  double released_for_{0.0};  ///< [s]
};

}  // namespace rollerrig
