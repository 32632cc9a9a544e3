// Bandwidth and delay of an estimator: it is run on sines and measured.
#include <algorithm>
#include <cmath>
#include <complex>

#include "rollerrig/mechatronics/estimators.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig {
namespace {

/// An estimator on a roller and a wheel that are as it assumes.
template <class Law>
struct Trial {
  Law const& law;
  AssumedParameters const& assumed;
  typename Law::State const& from_rest;
  Estimated what;
  double period;
  int samples;

  /// Amplitude and phase of the estimate over those of a sine of force or torque with `cycles` in `samples` samples.
  std::complex<double> response(int cycles) const {
    double const w = 2.0 * pi * cycles / (samples * period);
    bool const of_force = what == Estimated::force;
    double const roller = of_force ? assumed.roller_radius / assumed.roller_inertia : 0.0;
    double const wheel = (of_force ? -assumed.wheel_radius : 1.0) / assumed.wheelset_inertia;
    auto state = from_rest;
    std::complex<double> sum{};
    for (int k = 1; k <= 2 * samples; ++k) {
      double const t = k * period, sine = std::sin(w * t);
      double const integral = (1.0 - std::cos(w * t)) / w;  // of the sine
      AxleSample const now{roller * integral, wheel * integral, 0.0, of_force ? sine : 0.0, of_force ? 0.0 : sine};
      auto const found = law.step(state, assumed, now, period);
      if (k > samples) sum += (of_force ? found.force : found.torque) * std::polar(1.0, -w * t);
    }
    return sum * std::complex<double>(0.0, 2.0 / samples);  // of sin(w t) itself: 1
  }
};

template <class Law>
EstimatorResponse measure(Law const& law, AssumedParameters const& assumed, Estimated what, double period) {
  // A window of whole cycles, long against the transient, fine in frequency.
  double window = 0.0;
  if constexpr (requires { law.bandwidth; }) window = 2000.0 / (law.bandwidth * period);
  int const samples = static_cast<int>(std::clamp(window, 2000.0, 400000.0));
  double const unit = 2.0 * pi / (samples * period);
  auto const from_rest = law.start(assumed, period, {});
  Trial<Law> const trial{law, assumed, from_rest, what, period, samples};
  auto const gain = [&](int cycles) { return std::abs(trial.response(cycles)); };
  EstimatorResponse out;
  out.delay = -std::arg(trial.response(1)) / unit;
  double const down = std::sqrt(0.5);
  int low = 1, high = samples / 2 - 1;
  if (gain(high) > down) return {unit * high, out.delay};
  while (high - low > 1) {
    int const middle = (low + high) / 2;
    (gain(middle) > down ? low : high) = middle;
  }
  double const at_low = gain(low), at_high = gain(high);
  out.bandwidth = unit * (low + (at_low - down) / (at_low - at_high));
  return out;
}

}  // namespace

EstimatorResponse measure_response(AnyEstimator const& estimator, AssumedParameters const& assumed, Estimated what,
                                   double period) {
  return std::visit([&](auto const& law) { return measure(law, assumed, what, period); }, estimator);
}

}  // namespace rollerrig
