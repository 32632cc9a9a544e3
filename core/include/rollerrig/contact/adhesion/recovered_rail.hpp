// contact/adhesion/recovered_rail.hpp - what the leading wheels leave behind: energy dissipated on each piece of rail.
//
//   energy per area that a wheel dissipates -> [cells along the rail] -> what the following wheels find
//
// A ring of cells that reaches back from the leading wheel; rail that no wheel has touched yet is as contaminated as ever.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace rollerrig {

class RecoveredRail {
 public:
  static constexpr int cells = 1024;
  /// @param cell  length of a cell [m]; 51 m of rail are remembered with 50 mm
  void reset(double cell = 0.05) {
    cell_length_ = cell;
    energy_.fill(0.0);
    head_ = none;
  }

  /// Energy per area already dissipated at an arc length [J/m^2].
  double at(double arc_length) const {
    long const cell = cell_of(arc_length);
    if (head_ == none || cell > head_ || cell <= head_ - cells) return 0.0;
    return energy_[slot(cell)];
  }

  /// What a wheel finds: read in the cell ahead of it, in which nothing is its own yet.
  double before(double arc_length) const { return at(arc_length + cell_length_); }

  /// A wheel has run from one arc length to another (forward) and dissipated this energy per area.
  void dissipate(double from, double to, double energy_per_area) {
    long const first = cell_of(from);
    long const last = cell_of(to);
    for (long cell = head_ == none ? last : head_ + 1; cell <= last; ++cell) energy_[slot(cell)] = 0.0;
    head_ = head_ == none ? last : std::max(head_, last);
    // Each cell gets its part of the distance: a wheel that passes in many short steps dissipates the energy once.
    for (long cell = std::max(first, head_ - cells + 1); cell <= last; ++cell) {
      double const low = std::max(from, cell_length_ * static_cast<double>(cell));
      double const high = std::min(to, cell_length_ * static_cast<double>(cell + 1));
      energy_[slot(cell)] += energy_per_area * std::max(0.0, high - low) / cell_length_;
    }
  }

 private:
  static constexpr long none = -(1L << 60);
  long cell_of(double arc_length) const { return static_cast<long>(std::floor(arc_length / cell_length_)); }
  static std::size_t slot(long cell) { return static_cast<std::size_t>(((cell % cells) + cells) % cells); }

  std::array<double, cells> energy_{};
  double cell_length_{0.05};  ///< [m]
  long head_{none};
};

}  // namespace rollerrig
