// contact/adhesion/cleaned_wheel.hpp - what a wheel's own tread keeps of its cleaning by sliding.
//
//   energy per area that the wheel dissipates on the rail -> [mean of the tread, fading as the wheel rolls] -> energy per area
//
// The energy that cleans a length ds of rail cleans as much of the tread: spread over the circumference, since a tread element
// comes round long before the film on it has changed. While the wheel rolls over contaminated rail it takes up a film again:
//
//     dE/ds_w = (e ds/ds_w) / (2 pi r) - E / L        (A16)
//
// with s_w the length rolled, e the energy per area of rail and L the memory. Of a locked wheel s_w does not grow: nothing fades.
// Source  ours; docs/theory/adhesion.md.
#pragma once
#include <cmath>

namespace rollerrig {

class CleanedWheel {
 public:
  double energy() const { return energy_; }  ///< per area of the tread, its mean [J/m^2]

  /// One step.
  ///
  /// @param dissipated     per area of the rail, by this wheel [J/m^2]
  /// @param passed         length of the rail that passed [m]
  /// @param rolled         length that the wheel rolled, its magnitude [m]
  /// @param circumference  of the wheel [m]
  /// @param memory         L: length rolled over which cleaning fades to 1/e [m]; 0: a wheel keeps nothing
  void run(double dissipated, double passed, double rolled, double circumference, double memory) {
    if (!(memory > 0.0)) return;
    double const gain = dissipated * passed / circumference, fade = rolled / memory;
    double const kept = fade > 1e-9 ? -std::expm1(-fade) / fade : 1.0;  // of what comes in evenly over the step
    energy_ = energy_ * std::exp(-fade) + gain * kept;
  }

  void state(auto& archive) { archive(energy_); }

 private:
  double energy_{0.0};
};

}  // namespace rollerrig
