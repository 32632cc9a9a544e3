// simulate/run_table.hpp - what a run leaves in tables of the caller: a row at each output time, or a reading at each and a row at
// every few.
//
//   Driver -> [advance] -> times, rows; times, readings
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

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
/// Where several lie within one step of the integrator, the states are cubics, and only as many are evaluated as the forces bend:
/// parabolas through three of them are tried at two between, and halved until they hold. On rails that move along the line the
/// forces follow these too, and all are evaluated.
class Readings {
 public:
  Readings(int every, TimedRows const& table) : table_{table}, every_{every} {}

  std::size_t filled() const { return table_.filled; }
  /// One output of a run; whether a row is due.
  bool read(Driver& driver, double t, double const* x, double const* z);
  /// After it, those that follow within the integrator's last step.
  void read_ahead(Driver& driver);

 private:
  static constexpr std::size_t most = 64;    ///< that are read together
  static constexpr double allowed = 1e-4;    ///< deviation from a parabola, over the size of the reading [-]
  static constexpr double least_wear = 0.1;  ///< size of a wear number that counts [N]

  struct Parabola {
    std::size_t from, middle, to;
  };

  void evaluate(Driver& driver, std::size_t k);
  void refine(Driver& driver, std::size_t from, std::size_t to);
  double on(Parabola const& parabola, std::size_t k, std::size_t column) const;
  void fill(Parabola const& parabola);
  bool is_near(Parabola const& parabola, std::size_t k) const;
  double* row(std::size_t k) { return table_.values + table_.width * (first_ + k); }
  double const* row(std::size_t k) const { return table_.values + table_.width * (first_ + k); }

  TimedRows table_;
  int every_;
  std::int64_t shown_{0};
  double last_{std::numeric_limits<double>::quiet_NaN()},
      interval_{0.0};     ///< time of the last one, since the one before [s]
  bool alone_{false};     ///< the last one was not there already
  std::size_t ahead_{0};  ///< how many are
  std::size_t first_{0};  ///< of those that were read together
  std::array<bool, most + 1> known_{};
  std::vector<double> x_, z_;
};

/// Driver::advance(), with its outputs in tables.
///
/// @param readings  that a run keeps from its start on; null: a row at each output time
Status advance(Driver& driver, double t_stop, TimedRows& rows, Readings* readings = nullptr);

}  // namespace rollerrig
