// range.hpp - which numbers a field or an argument may hold, and the one check of them.
//
//   value, range -> [check_value] -> nothing, or std::invalid_argument "Body: mass must be positive, got -1 kg"
//
// Checked once where data come in (bindings, model builder), never in a loop: what passed here cannot make an index run away,
// a loop endless or a size overflow. What is physically sensible is the matter of the configuration, not of this file.
#pragma once
#include <array>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "rollerrig/math/curves.hpp"
#include "rollerrig/math/vector.hpp"

namespace rollerrig {

struct Range {
  double lowest;
  double highest;
  char const* text;       ///< ends the sentence "... must be"
  bool beyond{false};     ///< above the lowest, not at it
  bool endless{false};    ///< infinity is allowed
  bool magnitude{false};  ///< of the absolute value

  template <class Number>
  constexpr bool holds(Number value) const {
    double const given = static_cast<double>(value);  // exact for the integers in use
    double const v = magnitude && given < 0.0 ? -given : given;
    if (endless && v == std::numeric_limits<double>::infinity()) return true;
    return (beyond ? v > lowest : v >= lowest) && v <= highest;  // not a number: neither
  }
};

// Far beyond any machine and far from where squares and cubes overflow.
inline constexpr double largest_number = 1e60;
inline constexpr double smallest_number = 1e-60;

inline constexpr Range finite_number{0.0, largest_number, "finite", false, false, true};
inline constexpr Range positive{smallest_number, largest_number, "positive"};
inline constexpr Range not_negative{0.0, largest_number, "finite and not negative"};
inline constexpr Range positive_or_infinite{smallest_number, largest_number, "positive", false, true};
inline constexpr Range fraction{0.0, 1.0, "between 0 and 1"};
inline constexpr Range poissons_ratio{0.0, 0.5, "between 0 and 0.5"};
inline constexpr Range an_index{0.0, 2147483646.0, "an index from 0"};
inline constexpr Range index_or_none{-1.0, 2147483646.0, "an index from 0, or -1 for none"};
inline constexpr Range any_integer{0.0, 1.8446744073709552e19, "an integer", false, false, true};

/// Throws std::invalid_argument where the condition does not hold.
inline void need(bool condition, std::string const& message) {
  if (!condition) throw std::invalid_argument(message);
}

/// What a message calls a value.
struct Label {
  constexpr Label(char const* own, char const* in = "") : name{own}, unit{in} {}  // NOLINT: a name alone is one

  char const* name;
  std::string_view unit;
};

/// Throws std::invalid_argument "<owner>: <name> must be <range>, got <value> <unit>".
template <class Number>
[[noreturn]] void refuse_value(Number value, Range const& range, std::string_view owner, Label label) {
  std::ostringstream message;
  message.precision(6);
  message << owner << ": " << label.name << " must be " << range.text << ", got " << +value;
  if (!label.unit.empty() && label.unit != "1") message << ' ' << label.unit;
  throw std::invalid_argument(message.str());
}

/// Numbers in any of the containers that descriptions are made of; objects in them have been checked where they were made.
template <class Value>
void check_value(Value const& value, Range const& range, std::string_view owner, Label label) {
  if constexpr (std::same_as<Value, bool>) {
  } else if constexpr (std::is_arithmetic_v<Value>) {
    if (!range.holds(value)) refuse_value(value, range, owner, label);
  }
}
template <class Value>
void check_value(std::optional<Value> const& value, Range const& range, std::string_view owner, Label label) {
  if (value) check_value(*value, range, owner, label);
}
template <class Value>
void check_value(std::vector<Value> const& values, Range const& range, std::string_view owner, Label label) {
  for (auto const& value : values) check_value(value, range, owner, label);
}
template <class Value, std::size_t n>
void check_value(std::array<Value, n> const& values, Range const& range, std::string_view owner, Label label) {
  for (auto const& value : values) check_value(value, range, owner, label);
}
inline void check_value(Vec3<double> const& v, Range const& range, std::string_view owner, Label label) {
  for (double component : {v.x, v.y, v.z}) check_value(component, range, owner, label);
}
inline void check_increasing(std::vector<double> const& points, std::string_view owner, Label label) {
  check_value(points, finite_number, owner, label.name);
  for (std::size_t i = 1; i < points.size(); ++i)
    if (!(points[i - 1] < points[i]))
      throw std::invalid_argument(std::string(owner) + ": " + label.name + " must be given at increasing points");
}
/// Values in the range, at increasing finite points.
inline void check_value(PiecewiseLinear const& table, Range const& range, std::string_view owner, Label label) {
  check_increasing(table.x, owner, label);
  check_value(table.y, range, owner, label);
}
inline void check_value(PiecewiseCubic const& curve, Range const& range, std::string_view owner, Label label) {
  check_increasing(curve.start, owner, label);
  check_value(curve.coefficient, range, owner, label);
  need(curve.start.size() == curve.coefficient.size(), std::string(owner) + ": one row per break of " + label.name);
}
inline void check_value(UniformSpline const& curve, Range const& range, std::string_view owner, Label label) {
  std::string const what = std::string(owner) + ": " + label.name;
  check_value(curve.start, finite_number, what, "start");
  check_value(curve.step, Range{1e-9, 1e6, "between 1e-9 and 1e6"}, what, "step");
  need(!curve.pieces.empty(), what + ": pieces must not be empty");
  need(curve.start + curve.step > curve.start, what + ": step must move the start");
  check_value(curve.pieces, range, what, "pieces");
}
inline void check_value(TimeTable const& table, Range const& range, std::string_view owner, Label label) {
  check_value(table.points, range, owner, label);
}

}  // namespace rollerrig
