// mechatronics/anti_slip.hpp - takes torque off a driven axle that slips, and gives it back.
//
//   axle speeds (sampled), train speed it believes in -> slip and acceleration -> factor on the torque demand of each axle
#pragma once
#include <array>
#include <cmath>

namespace rig {

struct AntiSlip {
  double wheel_radius{0.46};           ///< that the device believes in [m]
  double reference_acceleration{1.5};  ///< the reference speed rises at most this fast: no train starts faster [m/s^2]
  double slip{0.04};                   ///< relative slip above which torque is taken off [-]
  double slip_speed{0.15};             ///< and the least such slip as a speed [m/s]
  double acceleration{3.0};            ///< an axle that gains speed faster loses torque as well [m/s^2]
  double filter_time{0.04};            ///< of the axles' acceleration [s]
  double reduction_rate{4.0};          ///< of the factor [1/s]
  double restoring_rate{0.35};         ///< [1/s]
  double least_factor{0.05};           ///< [-]
  double release_interval{3.0};        ///< while axles slip, one is released this often for the reference; 0: never [s]
  double shortest_release{0.4};        ///< the torque needs some time to go [s]
  double longest_release{1.2};         ///< [s]
  double release_deceleration{0.5};    ///< a released axle that slows less has run down to the train's speed [m/s^2]
  double least_acceleration{0.05};     ///< of the reference between releases [m/s^2]
  double regained_after{3.0};          ///< without slip for this long, the axles show the train's speed [s]
};

class AntiSlipState {
 public:
  static constexpr int most_axles = 8;

  void reset(double speed) {
    reference_ = seen_ = speed;
    slope_ = since_seen_ = released_for_ = 0.0;
    quiet_for_ = 1e9;  // nothing has slipped yet
    released_ = next_ = none;
    for (Axle& axle : axle_) axle = {speed, 0.0, 1.0, false, 0};
  }

  /// One sample: factors on the torque demand, 0..1.
  void step(AntiSlip const& p, double const* axle_speed, int axles, double period, double* factor) {
    double slowest = p.wheel_radius * axle_speed[0];
    for (int i = 1; i < axles; ++i) slowest = std::fmin(slowest, p.wheel_radius * axle_speed[i]);
    follow(p, slowest, axles, period);
    for (int i = 0; i < axles; ++i) {
      Axle& axle = axle_[static_cast<std::size_t>(i)];
      double const speed = p.wheel_radius * axle_speed[i];
      axle.acceleration += period / (p.filter_time + period) * ((speed - axle.speed) / period - axle.acceleration);
      axle.speed = speed;
      double const slips_above = std::fmax(p.slip * std::fabs(reference_), p.slip_speed);
      bool const slips = speed - reference_ > slips_above || axle.acceleration > p.acceleration;
      axle.interventions += slips && !axle.slips;
      axle.slips = slips;
      quiet_for_ = slips ? 0.0 : quiet_for_;
      axle.factor += (slips || i == released_ ? -p.reduction_rate : p.restoring_rate) * period;
      axle.factor = std::fmin(1.0, std::fmax(p.least_factor, axle.factor));
      factor[i] = axle.factor;
    }
  }

  double reference_speed() const { return reference_; }
  int interventions(int axle) const { return axle_[static_cast<std::size_t>(axle)].interventions; }

 private:
  struct Axle {
    double speed, acceleration, factor;
    bool slips;
    int interventions;
  };
  static constexpr int none = -1;

  /// The reference speed: the slowest axle, rising no faster than the train was last seen to. While axles slip, every so
  /// often one is released until it has run down to the train's speed: that puts speed and slope right.
  void follow(AntiSlip const& p, double slowest, int axles, double period) {
    reference_ = std::fmin(slowest, reference_ + slope_ * period);
    since_seen_ += period;
    quiet_for_ += period;
    if (quiet_for_ > p.regained_after) {
      slope_ = p.reference_acceleration;
      released_ = none;
      seen(reference_);
      return;
    }
    if (released_ == none) {
      if (p.release_interval > 0.0 && since_seen_ > p.release_interval) {
        released_ = next_ = (next_ + 1) % axles;
        released_for_ = 0.0;
      }
      return;
    }
    released_for_ += period;
    bool const falls = axle_[static_cast<std::size_t>(released_)].acceleration < -p.release_deceleration;
    if (released_for_ < p.longest_release && (released_for_ < p.shortest_release || falls)) return;
    slope_ = std::fmin(p.reference_acceleration, std::fmax(p.least_acceleration, (slowest - seen_) / since_seen_));
    reference_ = slowest;
    released_ = none;
    seen(slowest);
  }

  void seen(double speed) {
    seen_ = speed;
    since_seen_ = 0.0;
  }

  std::array<Axle, most_axles> axle_{};
  double reference_{0.0}, slope_{0.0};
  double seen_{0.0}, since_seen_{0.0};  ///< the train's speed when it was last known [m/s], and how long ago [s]
  double quiet_for_{0.0};               ///< since the last slip [s]
  int released_{none}, next_{none};
  double released_for_{0.0};  ///< [s]
};

}  // namespace rig
