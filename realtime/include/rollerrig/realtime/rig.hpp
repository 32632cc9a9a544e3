// realtime/rig.hpp - the plant of an assembled model, as the server's loop takes it: chosen inputs and outputs, period by period.
//
//   Plant -> [rig] -> read, step
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "rollerrig/plant/plant.hpp"
#include "rollerrig/realtime/histogram.hpp"

namespace rollerrig::realtime {

class Rig {
 public:
  /// Throws std::invalid_argument for a model that cannot be run, or an index that is none of its own.
  ///
  /// @param period  a multiple of the model's sampling step, if it has one [s]
  Rig(AssembledModel assembled, std::vector<int> inputs, std::vector<int> outputs, double period)
      : plant_{std::move(assembled)}, inputs_{std::move(inputs)}, outputs_{std::move(outputs)}, period_{period} {
    auto const all = plant_.variables();
    auto const is = [&](int index, Causality causality) {
      return index >= 0 && index < static_cast<int>(all.size()) &&
             all[static_cast<std::size_t>(index)].causality == causality;
    };
    for (int const index : inputs_)
      if (!is(index, Causality::input)) throw std::invalid_argument("inputs: an index is not that of an input");
    for (int const index : outputs_)
      if (!is(index, Causality::output)) throw std::invalid_argument("outputs: an index is not that of an output");
  }

  Status start() {
    periods_ = 0;
    return plant_.start(plant_.assembled().options.final_time);
  }

  std::size_t inputs() const { return inputs_.size(); }
  std::size_t outputs() const { return outputs_.size(); }
  void read(std::span<double> out) {
    for (std::size_t i = 0; i < outputs_.size(); ++i) out[i] = plant_.get(outputs_[i]);
  }
  bool step(std::span<double const> command) {
    for (std::size_t i = 0; i < inputs_.size(); ++i) plant_.set_input(inputs_[i], command[i]);
    return plant_.advance(period_ * static_cast<double>(++periods_)) == Status::ok;
  }

  /// The time of the model's run is over.
  bool ended() const { return plant_.time() + 0.5 * period_ > plant_.assembled().options.final_time; }

  std::span<int const> input_indices() const { return inputs_; }
  Plant& plant() { return plant_; }
  Plant const& plant() const { return plant_; }

 private:
  Plant plant_;
  std::vector<int> inputs_, outputs_;
  double period_;
  std::int64_t periods_{0};
};

/// Steps a rig, its commands at their start values, and reads its outputs: what each period cost [ns of this thread's
/// processor]. A run that comes to its end is begun anew.
///
/// The same periods are run `repeats` times, and the least of each counts: what a machine does beside them falls on another
/// period each time, what the period itself needs does not.
///
/// @param time  of the processor: processor_time()
template <class ProcessorTime>
void measure_periods(Rig& rig, std::size_t periods, int repeats, ProcessorTime time, Histogram& cost) {
  std::vector<double> command, out(rig.outputs());
  for (int const index : rig.input_indices())
    command.push_back(rig.plant().variables()[static_cast<std::size_t>(index)].start);
  std::vector<std::int64_t> least(periods, std::numeric_limits<std::int64_t>::max());
  for (int i = 0; i < repeats; ++i) {
    bool goes_on = false;
    for (std::int64_t& own : least) {
      if (!goes_on && rig.start() != Status::ok) return;
      std::int64_t const begun = time();
      goes_on = rig.step(command);
      rig.read(out);
      own = std::min(own, time() - begun);
      goes_on = goes_on && !rig.ended();
    }
  }
  for (std::int64_t const own : least) cost.add(own);
}

}  // namespace rollerrig::realtime
