// mechatronics/delayed_commands.hpp - commands of one controller between their sample and their acting.
#pragma once
#include <cstdint>
#include <vector>

#include "rollerrig/mechatronics/measurements.hpp"

namespace rollerrig {

class DelayedCommands {
 public:
  /// @param initial  acts before the first command
  /// @param delay    steps from a sample to the command's acting
  DelayedCommands(double initial, int delay) : delay_{delay}, sent_(at(delay) + 2) { acting_.fill(initial); }

  void send(PerAxle<double> const& value, std::int64_t step) {
    sent_[(first_ + count_++) % sent_.size()] = {value, step + delay_};
  }

  /// Takes up what acts from this step on.
  void advance(std::int64_t step) {
    for (; count_ > 0 && sent_[first_].acts_at <= step; --count_) {
      acting_ = sent_[first_].value;
      first_ = (first_ + 1) % sent_.size();
    }
  }

  PerAxle<double> const& acting() const { return acting_; }
  /// What was sent last, acting or still to act.
  PerAxle<double> const& newest() const {
    return count_ > 0 ? sent_[(first_ + count_ - 1) % sent_.size()].value : acting_;
  }

  /// Everything that changes in a run, for plant/state_archive.hpp.
  void state(auto& archive) {
    archive(acting_, sent_);
    archive.within(first_, std::size_t{0}, sent_.size() - 1);
    archive.within(count_, std::size_t{0}, sent_.size());
  }
  /// Those that act and those that will.
  void each(auto const& look) const {
    look(acting_);
    for (Sent const& sent : sent_) look(sent.value);
  }

 private:
  struct Sent {
    PerAxle<double> value{};
    std::int64_t acts_at{0};
    void state(auto& archive) { archive(value, acts_at); }
  };

  int delay_;
  PerAxle<double> acting_{};
  std::vector<Sent> sent_;  ///< ring
  std::size_t first_{0}, count_{0};
};

}  // namespace rollerrig
