// simulate/recorder.hpp - one row of plain numbers per output time: which quantities, in which order, under which names.
//
//   dynamics at (t, x, z) -> [recorder] -> rows -> results in Python
//
// The tables of names stand beside the code that fills them, in recorder.cpp, so they cannot drift apart.
#pragma once
#include <span>
#include <string_view>

#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

struct Field {
  std::string_view name, unit, meaning;
};

/// A row is [bodies x body_fields, wheels x wheel_fields, wheels x patches x patch_fields, elements x element_fields,
/// run_fields].
class Recorder {
 public:
  static constexpr int patches = 4;  ///< recorded per wheel; the rest is counted in `patch_count`

  static std::span<Field const> body_fields();
  static std::span<Field const> wheel_fields();
  static std::span<Field const> patch_fields();
  static std::span<Field const> element_fields();
  static std::span<Field const> run_fields();

  explicit Recorder(Model const& model);
  int width() const { return width_; }

  /// Evaluates the model at (t, x) under the inputs and fills `row` (width() numbers).
  void record(Dynamics& dynamics, double t, double const* x, double const* z, double* row,
              Inputs const& inputs = {}) const;

  /// Of each wheel what is to be filtered, in this order; a reading has them of one wheel after the other, then the distance.
  static std::span<std::string_view const> reading_fields();
  int reading_width() const { return wheels_ * static_cast<int>(reading_fields().size()) + 1; }
  /// The same numbers as in a row, alone.
  void record_reading(Dynamics& dynamics, double t, double const* x, double const* z, double* row,
                      Inputs const& inputs = {}) const;

 private:
  int bodies_, wheels_, elements_, width_;
};

}  // namespace rollerrig
