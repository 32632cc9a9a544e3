// plant/variable.hpp - what a tool sees of a plant: numbers with names, units and limits; and how it drives one.
//
//   AssembledModel -> [variables] -> index, name, unit of every input and output
#pragma once
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rollerrig/plant/model_file.hpp"
#include "rollerrig/status.hpp"

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

/// With the words and limits of a command or a measurement.
template <class Field>
Variable variable_of(Field const& field, std::string name, Causality causality, double start) {
  auto const limit = [](double number) {
    return std::abs(number) < unlimited ? number : std::copysign(std::numeric_limits<double>::infinity(), number);
  };
  return {std::move(name), std::string(field.unit), std::string(field.meaning), causality,  Variability::discrete,
          start,           limit(field.lowest),     limit(field.highest),       field.whole};
}

class ContinuousPlant;

/// What a tool drives: a whole rig, plant.hpp, which says what each function does; or one controller alone, controller_plant.hpp.
class AnyPlant {
 public:
  virtual ~AnyPlant() = default;
  virtual std::span<Variable const> variables() const = 0;
  virtual Status start(double final_time) = 0;
  virtual Status advance(double t) = 0;
  virtual bool set_input(int index, double value) = 0;
  virtual bool set_parameter(int index, double value) = 0;
  virtual double get(int index) = 0;
  virtual std::vector<std::byte> save() = 0;
  virtual bool restore(std::span<std::byte const> bytes) = 0;
  virtual double time() const = 0;
  virtual std::string_view failed_wheel() const = 0;
  /// Another plant of the same model, as it was before its first run.
  virtual std::unique_ptr<AnyPlant> anew() const = 0;
  /// Whether another program can integrate it: a controller alone has no such states.
  virtual bool exchangeable() const { return false; }
  /// For that other program; null where it cannot, or no run has begun. Gone with the next start(), advance() or restore().
  virtual ContinuousPlant* continuous() { return nullptr; }
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
