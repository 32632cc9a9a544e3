// simulate/run_table.hpp - what a run leaves in tables of the caller: a row at each output time, or a reading at each and a row at
// every few.
//
//   Driver -> [advance] -> times, rows; times, readings
#pragma once
#include <cstddef>
#include <cstdint>

#include "rollerrig/status.hpp"

namespace rollerrig {

class Driver;

/// Room for rows of `width` numbers, each at its time; what does not fit is counted.
struct TimedRows {
  double* times{nullptr};  ///< [s]
  double* values{nullptr};
  std::size_t width{0}, room{0}, filled{0}, left_out{0};

  /// Where the next row is to be written; null: there is no room.
  double* add(double t) {
    if (filled >= room) {
      ++left_out;
      return nullptr;
    }
    times[filled] = t;
    return values + width * filled++;
  }
};

/// What is read of the plant between the rows: Driver::reading_width() numbers at each output time, a row at every `every`-th.
struct Readings {
  int every{1};
  TimedRows table{};
  std::int64_t shown{0};
};

/// Driver::advance(), with its outputs in tables.
///
/// @param readings  that a run keeps from its start on; null: a row at each output time
Status advance(Driver& driver, double t_stop, TimedRows& rows, Readings* readings = nullptr);

}  // namespace rollerrig
