// What the rig's controller does against the lags of its estimator and its drives: (D17) to (D21).
#include <doctest/doctest.h>

#include <cmath>

#include "rollerrig/mechatronics/motor.hpp"
#include "rollerrig/mechatronics/rig_laws.hpp"
#include "rollerrig/scalar.hpp"

using namespace rollerrig;

namespace {

constexpr double period = 1e-3, late = 2.0 * pi * 20.0, slow = 2.0 * pi;

/// The estimate of a torque: behind a low-pass of first order.
struct Estimate {
  double value{0.0};
  double of(double torque) { return value += (1.0 - std::exp(-late * period)) * (torque - value); }
};

double changing(double t) { return -9000.0 * std::fmin(1.0, t / 0.2) * (1.0 + 0.3 * std::sin(40.0 * t)); }

}  // namespace

TEST_CASE("a known torque is taken without lag, and what it and the estimate see alike is no error") {
  KnownTorque const law{slow, 1.0};
  KnownTorque::State state;
  Estimate estimate;
  double worst = 0.0, lag = 0.0;
  for (int k = 0; k < 3000; ++k) {
    double const motor = 500.0, torque = changing(k * period) + motor;
    double const seen = estimate.of(torque);
    worst = std::fmax(worst, std::fabs(law.step(state, {seen, late, motor, torque - motor}, period) - torque));
    lag = std::fmax(lag, std::fabs(seen - torque));
  }
  CHECK(lag > 500.0);   // the estimate alone
  CHECK(worst < 1e-8);  // round-off: the correction's low-pass is the estimate's
}

TEST_CASE("pads that rub otherwise than assumed: the estimate sets the known torque right, with its bandwidth") {
  KnownTorque const law{slow, 1.25};
  KnownTorque::State state;
  Estimate estimate;
  double const torque = -8000.0;
  auto const error_after = [&](double seconds) {
    double found = 0.0;
    for (int k = 0; k * period < seconds; ++k)
      found = law.step(state, {estimate.of(torque), late, 0.0, torque}, period);
    return found - torque;
  };
  CHECK(error_after(period) == doctest::Approx(0.25 * torque).epsilon(0.01));
  double const after = error_after(0.3 - period);
  // of first order behind the estimate's lag, 8 ms
  CHECK(after == doctest::Approx(0.25 * torque * std::exp(-slow * 0.3)).epsilon(0.06));
  CHECK(std::fabs(error_after(3.0)) < 1e-3);
}

TEST_CASE("an extrapolated estimate of a ramp is the ramp, and of a constant the constant") {
  ExtrapolatedTorque const law{.ahead = period / (std::exp(late * period) - 1.0) + period,
                               .bandwidth = 2.0 * pi * 40.0};
  ExtrapolatedTorque::State state;
  Estimate estimate;
  double found = 0.0, t = 0.0;
  for (; t < 1.0; t += period) found = law.step(state, {estimate.of(2e4 * t), late, 0.0, 0.0}, period);
  // the low-pass is 1/(exp(w h) - 1) samples late, `ahead` one more: the ramp of the next sample
  CHECK(found == doctest::Approx(2e4 * t).epsilon(1e-6));
  for (int k = 0; k < 1000; ++k) found = law.step(state, {estimate.of(700.0), late, 0.0, 0.0}, period);
  CHECK(found == doctest::Approx(700.0).epsilon(1e-9));
}

TEST_CASE("a drive that is asked with a lead follows a changing torque with a fraction of its lag") {
  Motor const motor{.bandwidth = 2.0 * pi * 50.0};
  double const decay = std::exp(-motor.bandwidth * period);
  // How late the torque is, from its largest error behind a sine; the command is made for the mean over the sample.
  auto const late_by = [&](auto const& law) {
    typename std::decay_t<decltype(law)>::State state;
    double const size = 4000.0, frequency = 10.0;
    double torque = 0.0, worst = 0.0;
    for (int k = 0; k < 3000; ++k) {
      double const t = k * period, wanted = size * std::sin(frequency * (t + 0.5 * period));
      double const command = law.step(state, {wanted, wanted, torque}, period);
      torque = command + (torque - command) * decay;
      if (k > 100) worst = std::fmax(worst, std::fabs(torque - size * std::sin(frequency * (t + period))));
    }
    return worst / (size * frequency);
  };
  double const half = 0.5 * period, lag = torque_lag(motor, period, 0.0, 0.0);
  CHECK(lag == doctest::Approx(1.0 / motor.bandwidth + half).epsilon(1e-12));
  CHECK(late_by(DirectCommand{}) == doctest::Approx(lag - half).epsilon(0.01));
  CHECK(late_by(LeadCommand{lag - half}) < 0.03 * lag);
  CHECK(late_by(TorqueLoop{2.0}) == doctest::Approx(torque_lag(motor, period, 0.0, 2.0) - half).epsilon(0.02));
}

TEST_CASE("lag of a drive: delay, half a sample, and the slope of its phase at rest") {
  Motor const second{.bandwidth = 300.0, .damping_ratio = 0.7};
  CHECK(torque_lag(second, period, 2e-3, 0.0) == doctest::Approx(2e-3 + 0.5e-3 + 2.0 * 0.7 / 300.0).epsilon(1e-12));
  CHECK(torque_lag(second, period, 0.0, 3.0) == doctest::Approx(0.125e-3 + 2.0 * 0.7 / 1200.0).epsilon(1e-12));
}
