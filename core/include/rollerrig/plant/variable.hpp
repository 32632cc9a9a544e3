// plant/variable.hpp - what a tool sees of a plant: numbers with names, units and limits.
//
//   AssembledModel -> [variables] -> index, name, unit of every input and output
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "rollerrig/plant/model_file.hpp"

namespace rollerrig {

enum class Causality : int { input, output, parameter, local };

/// When a variable may change: never after the start; between steps; at instants of sampling; at any time.
enum class Variability : int { fixed, tunable, discrete, continuous };

struct Variable {
  std::string name;  ///< structured: wheelset_1_left.vertical_force
  std::string unit;  ///< SI, as in the glossary: N m, m/s^2
  std::string description;
  Causality causality{};
  Variability variability{};
  double start{};          ///< of inputs and parameters
  double least{}, most{};  ///< allowed; infinite: any finite number
  bool whole{false};       ///< only whole numbers are

  bool allows(double value) const;  ///< finite, in the limits, and whole where that is asked for
};

/// Where the number behind a variable stands.
struct Place {
  enum Kind : int {
    brake_demand,   ///< per axle
    motor_torque,   ///< per axle
    command,        ///< `item` of the commands, per axle
    speed_control,  ///< per axle: whether the roller's drive goes to a speed
    roller_speed,   ///< per axle: that speed
    friction,       ///< per contact
    rail_friction,
    train_force,
    parameter,
    axle_torque,  ///< of the model: where nothing is sampled
    roller_torque,
    running_speed,  ///< of speed-controlled rollers, or of the track
    rise_time,      ///< in which it is reached
    recorded,       ///< column of the recorder's row
    side_ratio,     ///< column of Y; Q stands in column `item`
    measured,       ///< column of what an external controller sees
  } kind{};
  std::size_t index{};
  std::size_t item{};
};

struct VariableList {
  std::vector<Variable> variables;
  std::vector<Place> places;  ///< as many
  std::size_t measured{0};    ///< columns of measurements

  void add(Variable variable, Place place);
};

/// wheelset_1_left
std::string wheel_name(AssembledModel const& assembled, WheelContact const& contact);

/// Inputs, then outputs. Throws std::invalid_argument where names are missing.
VariableList list_variables(AssembledModel const& assembled);

/// Throws std::invalid_argument where a name stands for two things.
void check_unique(VariableList const& list);

}  // namespace rollerrig
