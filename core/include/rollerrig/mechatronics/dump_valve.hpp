// mechatronics/dump_valve.hpp - what slide protection switches at a brake cylinder: an inlet and an outlet valve.
//
//   command fill, hold, vent -> [two magnet valves: least pulse, then dead time] -> inlet open?  outlet open?
//
// Without current the inlet is open and the outlet closed: an axle brakes when its slide protection fails.
#pragma once

namespace rollerrig {

enum class DumpValve : int { fill, hold, vent };

/// Of a magnet valve, in steps.
struct SwitchingSteps {
  int opening{}, closing{};  ///< from a changed command to the valve's moving
  int least_pulse{};         ///< that a command stays at least; a shorter one is prolonged
};

/// A valve that moves some time after its command; a command shorter than that does not move it.
class MagnetValve {
 public:
  explicit MagnetValve(bool open) : open_{open}, commanded_{open} {}

  void step(bool command, SwitchingSteps const& steps) {
    if (command != commanded_ && age_ >= steps.least_pulse) {
      commanded_ = command;
      age_ = 0;
    }
    if (open_ != commanded_ && age_ >= (commanded_ ? steps.opening : steps.closing)) open_ = commanded_;
    if (age_ < settled) ++age_;
  }
  bool open() const { return open_; }
  void state(auto& archive) {
    archive(open_, commanded_);
    archive.within(age_, 0, settled);
  }

 private:
  static constexpr int settled = 1 << 30;
  bool open_, commanded_;
  int age_{settled};  ///< of the command [steps]
};

class DumpUnit {
 public:
  void step(DumpValve command, SwitchingSteps const& steps) {
    inlet_.step(command == DumpValve::fill, steps);
    outlet_.step(command == DumpValve::vent, steps);
  }
  bool inlet_open() const { return inlet_.open(); }
  bool outlet_open() const { return outlet_.open(); }
  void state(auto& archive) { archive(inlet_, outlet_); }

 private:
  MagnetValve inlet_{true}, outlet_{false};
};

}  // namespace rollerrig
