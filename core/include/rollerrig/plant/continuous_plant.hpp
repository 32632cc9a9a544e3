// plant/continuous_plant.hpp - a plant whose states another program integrates: for model exchange.
//
//   Plant that has begun, t, states -> [continuous plant] -> their rates, event indicators, outputs, directional derivatives
//
// States are those of the equations of motion, then what is integrated beside them: angles turned, works and losses. Instants of
// sampling are time events, as kinks and jumps of tables are. Inputs and parameters are set at the plant.
#pragma once
#include <span>
#include <vector>

#include "rollerrig/plant/plant.hpp"
#include "rollerrig/simulate/linear_model.hpp"

namespace rollerrig {

/// What model exchange adds to the variables of a plant: states, their rates, event indicators; all local.
struct ContinuousVariables {
  std::vector<Variable> states, rates, indicators;
};

/// `most` of a state is its nominal value: a change that counts.
ContinuousVariables list_continuous_variables(AssembledModel const& assembled);

class ContinuousPlant {
 public:
  /// Of a plant that has begun, at its start, and lives longer.
  explicit ContinuousPlant(Plant& plant);
  ~ContinuousPlant() { plant_.show(time_, {}); }
  ContinuousPlant(ContinuousPlant const&) = delete;
  ContinuousPlant& operator=(ContinuousPlant const&) = delete;

  std::size_t count() const { return state_.size(); }
  std::size_t indicator_count() const { return model().contacts.size(); }
  std::span<double const> nominals() const { return nominal_; }
  double time() const { return time_; }  ///< [s]
  std::span<double const> states() const { return state_; }

  /// From here on everything is asked of this instant and these states: of the plant's outputs, too.
  void set_time(double t);
  void set_states(std::span<double const> states);
  /// An input of the plant has changed.
  void forget();

  /// @param out  count() numbers
  Status rates(double* out);
  /// Of each wheel its normal force above that of a wheel that lifts off [N]: negative where it has.
  Status indicators(double* out);
  /// The other program has ended a step here: how long wheels have been off, whether the model still holds.
  Status accept();
  /// The next instant of sampling, kink or jump of a table [s]; infinite: none. Until pass_event() the model is that before it.
  double next_event() const;
  /// Sensors, controllers and actuators at this instant; what is not ok ends the run: the train has stopped, for one.
  Status pass_event();

  /// One thing that changes, or that answers: a state, an input of the plant by its index; a rate, an output by its index.
  struct Known {
    enum { state, input } kind;
    std::size_t index;
    double seed;
  };
  struct Unknown {
    enum { rate, output, indicator } kind;
    std::size_t index;
  };
  /// What the seeds change in the unknowns, to first order. By states and torques exactly, in the rates of all states and in the
  /// outputs of bodies and wheels, but for the power of torques; otherwise by a central difference.
  Status directional(std::span<Known const> known, std::span<Unknown const> unknown, double* out);

  std::string_view failed_wheel() const;

  /// Where it stands, beside what the plant saves itself; back there: false, and nothing is changed, of another model.
  std::vector<double> save() const;
  bool restore(std::span<double const> numbers);

 private:
  Model const& model() const { return *plant_.assembled().model; }
  Dynamics& dynamics() { return plant_.driver().observed(); }
  double evaluated_time() const;
  bool torque(Known const& known, std::size_t& column) const;
  bool exact(Unknown const& unknown, std::size_t& row, bool& output) const;
  Status read(std::span<Unknown const> unknown, double* out);
  Status difference(std::span<Known const> known, std::span<Unknown const> unknown, double* out);

  Plant& plant_;
  double time_, passed_;  ///< [s]; of the last event that was passed
  std::vector<double> state_, nominal_;
  LinearModel linear_;
  Eigen::MatrixXd work_;  ///< rates of the quadratures by the states
  bool linear_fresh_{false};
};

}  // namespace rollerrig
