// realtime/rig.hpp - the plant of an assembled model, as the server's loop takes it: chosen inputs and outputs, period by period.
//
//   Plant -> [rig] -> read, step
#pragma once
#include <cstdint>
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

  Plant& plant() { return plant_; }
  Plant const& plant() const { return plant_; }

 private:
  Plant plant_;
  std::vector<int> inputs_, outputs_;
  double period_;
  std::int64_t periods_{0};
};

/// Steps a rig that has started, as its inputs stand, and reads its outputs; what each period cost [ns of this thread's
/// processor]. Ends with the run.
///
/// @param time  of the processor: processor_time()
template <class ProcessorTime>
void measure_periods(Rig& rig, std::int64_t periods, ProcessorTime time, Histogram& cost) {
  std::vector<double> command(rig.inputs()), out(rig.outputs());
  std::size_t i = 0;
  for (Variable const& variable : rig.plant().variables())
    if (variable.causality == Causality::input && i < command.size()) command[i++] = variable.start;
  for (std::int64_t k = 0; k < periods; ++k) {
    std::int64_t const begun = time();
    bool const goes_on = rig.step(command);
    rig.read(out);
    cost.add(time() - begun);
    if (!goes_on) return;
  }
}

}  // namespace rollerrig::realtime
