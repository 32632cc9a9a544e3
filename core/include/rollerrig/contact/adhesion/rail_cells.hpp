// contact/adhesion/rail_cells.hpp - a density along the rail that wheels leave behind: energy, or sand.
//
// A ring of cells that reaches back from the foremost place that something has been added at; ahead of it there is nothing yet.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace rollerrig {

class RailCells {
 public:
  static constexpr int cells = 1024;

  /// @param cell  length of a cell [m]; 51 m of rail are remembered with 50 mm
  void reset(double cell) {
    cell_length_ = cell;
    density_.fill(0.0);
    head_ = none;
  }

  double cell_length() const { return cell_length_; }

  double at(double arc_length) const {
    std::int64_t const cell = cell_of(arc_length);
    if (head_ == none || cell > head_ || cell <= head_ - cells) return 0.0;
    return density_[slot(cell)];
  }

  /// Adds a density from one arc length to another (forward).
  void add(double from, double to, double density) {
    std::int64_t const first = cell_of(from);
    std::int64_t const last = cell_of(to);
    for (std::int64_t cell = head_ == none ? last : std::max(head_ + 1, last - cells + 1); cell <= last; ++cell)
      density_[slot(cell)] = 0.0;
    head_ = head_ == none ? last : std::max(head_, last);
    // Each cell gets its part of the distance: what passes in many short steps adds its density once.
    each(first, last, from, to, [&](double& value, double part) { value += density * part; });
  }

  /// Leaves this part of the density from one arc length to another (forward).
  void keep(double from, double to, double kept) {
    if (head_ == none) return;
    each(cell_of(from), std::min(cell_of(to), head_), from, to,
         [&](double& value, double part) { value *= std::pow(kept, part); });
  }

  void state(auto& archive) {
    archive(density_);
    archive.within(head_, none, farthest);
    archive.need(head_ == none || head_ >= -farthest);
  }

 private:
  static constexpr std::int64_t none = -(std::int64_t{1} << 60), farthest = 1'000'000'000'000'000;

  template <class Change>
  void each(std::int64_t first, std::int64_t last, double from, double to, Change&& change) {
    for (std::int64_t cell = std::max(first, head_ - cells + 1); cell <= last; ++cell) {
      double const low = std::max(from, cell_length_ * static_cast<double>(cell));
      double const high = std::min(to, cell_length_ * static_cast<double>(cell + 1));
      change(density_[slot(cell)], std::max(0.0, high - low) / cell_length_);
    }
  }
  /// Within 1e15, where every whole number is exact: a train that has run away keeps the last cell.
  std::int64_t cell_of(double arc_length) const {
    double const cell = std::floor(arc_length / cell_length_);
    return static_cast<std::int64_t>(cell < 1e15 ? std::max(cell, -1e15) : 1e15);
  }
  static std::size_t slot(std::int64_t cell) { return static_cast<std::size_t>(((cell % cells) + cells) % cells); }

  std::array<double, cells> density_{};
  double cell_length_{0.05};  ///< [m]
  std::int64_t head_{none};
};

}  // namespace rollerrig
