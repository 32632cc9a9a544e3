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
#include <cstdint>

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
    std::int64_t const cell = cell_of(arc_length);
    if (head_ == none || cell > head_ || cell <= head_ - cells) return 0.0;
    return energy_[slot(cell)];
  }

  /// What a wheel finds: read in the cell ahead of it, in which nothing is its own yet.
  double before(double arc_length) const { return at(arc_length + cell_length_); }

  /// A wheel has run from one arc length to another (forward) and dissipated this energy per area.
  void dissipate(double from, double to, double energy_per_area) {
    std::int64_t const first = cell_of(from);
    std::int64_t const last = cell_of(to);
    for (std::int64_t cell = head_ == none ? last : std::max(head_ + 1, last - cells + 1); cell <= last; ++cell)
      energy_[slot(cell)] = 0.0;
    head_ = head_ == none ? last : std::max(head_, last);
    // Each cell gets its part of the distance: a wheel that passes in many short steps dissipates the energy once.
    for (std::int64_t cell = std::max(first, head_ - cells + 1); cell <= last; ++cell) {
      double const low = std::max(from, cell_length_ * static_cast<double>(cell));
      double const high = std::min(to, cell_length_ * static_cast<double>(cell + 1));
      energy_[slot(cell)] += energy_per_area * std::max(0.0, high - low) / cell_length_;
    }
  }

 private:
  static constexpr std::int64_t none = -(std::int64_t{1} << 60);
  /// Within 1e15, where every whole number is exact: a train that has run away keeps the last cell.
  std::int64_t cell_of(double arc_length) const {
    double const cell = std::floor(arc_length / cell_length_);
    return static_cast<std::int64_t>(cell < 1e15 ? std::max(cell, -1e15) : 1e15);
  }
  static std::size_t slot(std::int64_t cell) { return static_cast<std::size_t>(((cell % cells) + cells) % cells); }

  std::array<double, cells> energy_{};
  double cell_length_{0.05};  ///< [m]
  std::int64_t head_{none};
};

}  // namespace rollerrig
