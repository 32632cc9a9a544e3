// plant/plant.hpp - an assembled model as other tools take it: start, set inputs, advance, read outputs.
//
//   AssembledModel -> [plant: Driver] -> variables by index; Status, with time and wheel where the model's validity ends
//
// It is the run of `simulate`: the same driver, the same steps. After start() nothing throws and nothing is allocated.
// Where the model has sampled blocks, time advances in whole sampling steps; at the end of each the sensors have been read and
// the controllers asked. The present inputs hold from there on; they also answer for external controllers.
#pragma once
#include <limits>
#include <span>
#include <string_view>

#include "rollerrig/plant/parameters.hpp"
#include "rollerrig/simulate/driver.hpp"

namespace rollerrig {

class Plant : public AnyPlant {
 public:
  /// Throws std::invalid_argument for a model that cannot be run.
  explicit Plant(AssembledModel assembled);
  ~Plant() override;

  std::span<Variable const> variables() const override { return list_.variables; }
  /// Index of a variable; -1: there is none of that name.
  int find(std::string_view name) const;

  /// Begins a run, with all inputs at their start values; a run that has begun is begun anew.
  ///
  /// @param final_time  that the steps end at exactly [s]; that of the case: assembled().options.final_time; infinite: none
  /// Throws std::invalid_argument for an end that the steps would never reach.
  Status start(double final_time) override;
  /// To the last sampling step at or before t, or without sampled blocks to t. What is not ok is final.
  Status advance(double t) override;

  /// Fixed parameters before start() only: the run then starts from the equilibrium that the model has with them. Tunable ones
  /// also between steps. False, and nothing is changed: it is no parameter, its limits do not allow the number, or it is too late.
  bool set_parameter(int index, double value) override;
  /// False, and nothing is changed: it is no input, or its limits do not allow the number.
  bool set_input(int index, double value) override;
  /// Of an input or a parameter what was set; of an output its value at time(). NaN: there is no such variable, or no run.
  double get(int index) override;

  /// The complete state of a run that has begun, as bytes: integrator, sampled blocks, memory of wheels and rails, inputs. Going
  /// on from it gives the same numbers as never having stopped. Empty: no run has begun.
  std::vector<std::byte> save() override;
  /// Goes on from there; also in another plant of the same model, begun or not. False, and nothing is changed: bytes of another
  /// model, cut or changed, or numbers that no run has. Allocates.
  bool restore(std::span<std::byte const> bytes) override;
  std::unique_ptr<AnyPlant> anew() const override { return std::make_unique<Plant>(parameters_.given()); }
  bool exchangeable() const override { return true; }
  ContinuousPlant* continuous() override;

  /// Outputs are from here on those at t in these states and quadratures, which live longer; of none: those of the run again.
  void show(double t, std::span<double const> states);
  /// An input without its limits, by its index: for differences about what was set.
  void hold_input(std::size_t index, double value);
  /// When a change of the running speed is over [s]; infinite: none is going on. Then, what ends it; advance() does so itself.
  double ramp_end() const { return ramp_end_; }
  void end_ramp();
  Place const& place(std::size_t index) const { return list_.places[index]; }

  bool started() const { return driver_->started(); }
  double time() const override { return time_; }  ///< [s]
  Status status() const { return status_; }
  double sampling_step() const {
    return assembled_.setup ? assembled_.setup->step : 0.0;
  }  ///< [s]; 0: nothing is sampled
  /// The wheel that ended the run, wheelset_1_left; empty: none did.
  std::string_view failed_wheel() const override;
  std::string_view wheel_of(int contact) const;                   ///< empty: of none
  AssembledModel const& assembled() const { return assembled_; }  ///< with its parameters as at the last start()
  Driver& driver() { return *driver_; }

 private:
  static constexpr double never = std::numeric_limits<double>::infinity();

  void apply(Place const& place, double value);
  void ramp_speed(double speed);
  void read_measurements();
  std::uint64_t identity();

  void renew();
  void state(auto& archive) {
    driver_->state(archive);
    archive(value_, time_);
    archive.time(ramp_end_);
    archive.within(status_, Status::ok, Status::controller_failed);
  }
  void read(std::span<std::byte const> state);
  void take_parameters();

  AssembledModel assembled_;
  ModelParameters parameters_;
  VariableList list_;
  std::vector<std::string> wheels_;  ///< per contact
  std::unique_ptr<Driver> driver_;
  std::vector<double> value_;                      ///< per variable: of inputs
  std::vector<double> row_, measured_;             ///< outputs at time_
  bool row_fresh_{false}, measured_fresh_{false};  ///< they are
  std::span<double const> shown_;  ///< states and quadratures that outputs are of; empty: those of the run
  double time_{0.0};
  std::size_t at_speed_{0}, at_rise_time_{0};  ///< inputs, where the running speed is one
  double ramp_end_{never};                     ///< of a change of it [s]
  Status status_{Status::ok};
  std::uint64_t identity_{0};  ///< of the model as given; 0: not yet known
  bool changed_{false};        ///< a fixed parameter, since the driver was made
  std::unique_ptr<ContinuousPlant> continuous_;
};

}  // namespace rollerrig
