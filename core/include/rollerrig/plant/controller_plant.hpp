// plant/controller_plant.hpp - one controller alone as a tool drives it: what it measures are inputs, its commands outputs.
//
//   measurements of the axles -> [ControllerPlant], at its sample times -> commands
//
// A sample is taken at the beginning of a step that begins at a sample time, with the inputs as they are then; its command stands
// among the outputs from then on. What lies between a sample and the command's acting belongs to the case that uses it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "rollerrig/plant/variable.hpp"
#include "rollerrig/status.hpp"

namespace rollerrig {

class ControllerPlant : public AnyPlant {
 public:
  /// Throws std::invalid_argument for a part that is not whole.
  explicit ControllerPlant(ControllerPart part);

  /// Inputs, then outputs, then parameters.
  std::span<Variable const> variables() const override { return variables_; }

  /// Before the first sample; a parameter that is set afterwards acts from the next start on.
  Status start(double final_time) override;
  /// To a time [s], with a sample at every sample time from the last one on and before it; not further than 10^7 of them.
  Status advance(double time) override;
  /// False: refused, nothing changed.
  bool set_input(int index, double value) override { return set(index, value, Causality::input); }
  bool set_parameter(int index, double value) override { return set(index, value, Causality::parameter); }
  double get(int index) override { return value_[at(index)]; }

  double time() const override { return time_; }
  double period() const { return part_.step * part_.controller.sampling.every; }  ///< of its samples [s]
  std::string_view failed_wheel() const override { return {}; }                   ///< it has none

  /// Everything that changes in a run, for a plant of the same part.
  std::vector<std::byte> save() override;
  bool restore(std::span<std::byte const> bytes) override;
  std::unique_ptr<AnyPlant> anew() const override { return std::make_unique<ControllerPlant>(part_); }

  ControllerPart const& part() const { return part_; }

  /// One sample in small motions, by rows: states and commands after it over states before it and inputs.
  struct Jacobian {
    std::size_t rows{}, columns{};
    std::vector<double> matrix{};
  };
  /// By central differences about the present. States are the numbers that the inputs bring elsewhere than a few samples do without
  /// them, more than by rounding; each is varied as far as they bring it.
  ///
  /// @param moves  inputs that vary, by index, and how far: within what is linear
  Jacobian jacobian(std::span<std::pair<int, double> const> moves);

  /// What the rig's controller finds of an axle, or nothing of another controller.
  RigController::AxleState const* axle(std::size_t i) const {
    auto const* rig = std::get_if<RigController::State>(&state_);
    return rig != nullptr ? &rig->axle[i] : nullptr;
  }

 private:
  /// Where the number of an input belongs among the measurements.
  struct Input {
    PerAxle<double> Measurements::* per_axle{nullptr};
    double Measurements::* of_train{nullptr};  ///< where it is of no axle
    std::size_t axle{0};
    double base{0.0};  ///< what it is the change of
  };
  void add_axle_inputs();
  void add_train_inputs();
  void add_outputs();
  void add_parameters();
  bool set(int index, double value, Causality causality);
  void sample();
  Measurements measured() const;
  Measurements at_start() const;
  bool of_rollers() const;
  bool of_brakes() const;

  ControllerPart part_;
  std::vector<Variable> variables_;
  std::vector<Input> inputs_;                ///< of the first variables
  std::size_t commands_{0}, parameters_{0};  ///< where they begin
  std::vector<double> value_;                ///< of every variable
  StateOf<AnyController> state_{};
  std::int64_t samples_{0};  ///< taken
  double time_{0.0};
};

}  // namespace rollerrig
