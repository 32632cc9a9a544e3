// realtime/watchdog.hpp - what acts on the rig when its controller is silent.
//
//   a fresh command or none, each period -> [watchdog] -> what acts: the command, or a ramp from it to the safe state
//
// The safe state stays until a command asks for the rig again (RR_REARM): a controller that comes back does not know what was
// done meanwhile, and has to be told.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace rollerrig::realtime {

/// One number of a command.
struct Input {
  double start{};          ///< acts before the first command
  double safe{};           ///< of the safe state
  double least{}, most{};  ///< allowed
  bool whole{};            ///< only whole numbers are: there is no ramp between them

  bool allows(double value) const {
    return std::isfinite(value) && value >= least && value <= most && (!whole || value == std::round(value));
  }
};

class Watchdog {
 public:
  enum State { waiting, running, ramping, safe };

  /// @param patience    periods without a command after which it acts
  /// @param ramp        periods from there to the safe state
  Watchdog(std::vector<Input> inputs, int patience, int ramp)
      : inputs_{std::move(inputs)}, acting_(inputs_.size()), from_(inputs_.size()), patience_{patience}, ramp_{ramp} {
    for (std::size_t i = 0; i < inputs_.size(); ++i) acting_[i] = inputs_[i].start;
  }

  /// One period; what acts during it.
  ///
  /// @param fresh   the newest command of this period, empty: there was none
  /// @param rearms  it asks for the rig after a safe state
  std::span<double const> step(std::span<double const> fresh, bool rearms) {
    silent_ = fresh.empty() ? silent_ + 1 : 0;
    if (!fresh.empty() && (state_ <= running || rearms)) {
      state_ = running;
      std::copy(fresh.begin(), fresh.end(), acting_.begin());
    } else if (state_ == running && silent_ >= patience_) {
      state_ = ramping, done_ = 0, ++trips_;
      from_ = acting_;
    }
    if (state_ == ramping) ramp();
    return acting_;
  }

  /// Without a controller from the start: what stands there acts.
  void run_without() { state_ = running, silent_ = 0, patience_ = INT32_MAX; }

  State state() const { return state_; }
  std::int64_t silent() const { return silent_; }  ///< periods since the last command
  std::int64_t trips() const { return trips_; }
  std::vector<Input> const& inputs() const { return inputs_; }

 private:
  void ramp() {
    double const part = ramp_ > 0 ? std::min(1.0, static_cast<double>(++done_) / ramp_) : 1.0;
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      Input const& input = inputs_[i];
      acting_[i] = input.whole || part >= 1.0 ? input.safe : from_[i] + part * (input.safe - from_[i]);
    }
    if (part >= 1.0) state_ = safe;
  }

  std::vector<Input> inputs_;
  std::vector<double> acting_, from_;
  std::int32_t patience_, ramp_;
  std::int64_t silent_{0}, done_{0}, trips_{0};
  State state_{waiting};
};

}  // namespace rollerrig::realtime
