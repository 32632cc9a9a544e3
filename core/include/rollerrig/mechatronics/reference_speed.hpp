// mechatronics/reference_speed.hpp - the train's speed as slide protection and wheel-slip control believe in it.
//
//   axle nearest to the train (fastest in braking, slowest in traction) -> [reference] -> speed; which axle is released
//
// While some axle grips, the nearest one is the train. While none does the reference goes on as the train was last seen to, and
// every so often one axle in turn is released from its torque until it turns with the train: that puts speed and slope right.
// Braking is traction with all speeds negative. Source: docs/theory/adhesion.md, (A7).
#pragma once
#include <cmath>

namespace rollerrig {

struct ReferenceSpeedRules {
  double steepest{1.6};          ///< no train changes its speed faster [m/s^2]
  double gentlest{0.2};          ///< one that is braked or pulled changes it at least so [m/s^2]
  double release_interval{3.0};  ///< 0: never [s]
  double shortest_release{0.3};  ///< [s]
  double longest_release{1.2};   ///< [s]
};

class ReferenceSpeed {
 public:
  static constexpr int none = -1;

  explicit ReferenceSpeed(bool braking) : sign_{braking ? -1.0 : 1.0} {}

  void reset(double speed) {
    value_ = speed;
    slope_ = released_for_ = 0.0;
    seen(speed);
    released_ = next_ = none;
  }

  /// One sample on.
  ///
  /// @param nearest  speed of the axle nearest to the train [m/s]
  void advance(double nearest, double period) {
    value_ = sign_ * std::fmin(sign_ * nearest, sign_ * value_ + slope_ * period);
    since_seen_ += period;
  }

  /// The value is the train's speed.
  void is_known(ReferenceSpeedRules const& rules) {
    released_ = none;
    slope_ = rules.steepest;
    seen(value_);
  }

  /// Nobody shows the train's speed: release axles.
  ///
  /// @param still_runs  still_runs(axle): whether it has not yet come to the train's speed
  template <class StillRuns>
  void search(ReferenceSpeedRules const& rules, double nearest, int axles, double period, StillRuns&& still_runs) {
    if (released_ == none) {
      if (rules.release_interval > 0.0 && since_seen_ > rules.release_interval) {
        released_ = next_ = (next_ + 1) % axles;
        released_for_ = 0.0;
      }
      return;
    }
    released_for_ += period;
    bool const early = released_for_ < rules.shortest_release || still_runs(released_);
    if (released_for_ < rules.longest_release && early) return;
    double const slope = sign_ * (nearest - seen_) / since_seen_;
    slope_ = std::fmin(rules.steepest, std::fmax(rules.gentlest, slope));
    value_ = nearest;
    released_ = none;
    seen(nearest);
  }

  double value() const { return value_; }
  bool releases(int axle) const { return axle == released_; }

 private:
  void seen(double speed) {
    seen_ = speed;
    since_seen_ = 0.0;
  }

  double sign_;
  double value_{0.0}, slope_{0.0};
  double seen_{0.0}, since_seen_{0.0};  ///< the train's speed when it was last known [m/s], and how long ago [s]
  int released_{none}, next_{none};
  double released_for_{0.0};  ///< [s]
};

}  // namespace rollerrig
