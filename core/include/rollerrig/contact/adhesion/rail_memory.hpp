// contact/adhesion/rail_memory.hpp - what wheels leave behind: dissipated energy and sand along the rail, and on their own treads.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace rollerrig {

/// A density along the rail that wheels leave behind: energy per area [J/m^2], or mass of sand per length [kg/m].
///
/// A ring of cells that reaches back from the foremost place that something has been added at; ahead of it there is nothing yet.
class RailCells {
 public:
  static constexpr int cells = 1024;

  /// @param cell  length of a cell [m]; 51 m of rail are remembered with 50 mm
  void reset(double cell = 0.05) {
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
  /// What a wheel finds of energy: read in the cell ahead of it, in which nothing is its own yet.
  double before(double arc_length) const { return at(arc_length + cell_length_); }

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

/// Sand on the rail: laid in front of a wheel, found by it and by all that follow.
///
///   flow of sand, way of the train -> [cells along the rail] -> mass per length under each wheel -> friction.hpp, (A19)
///
/// Each wheel crushes and throws off a part of what it runs over. Sand is laid one cell ahead of the wheel and taken off one cell
/// behind it, so that a wheel finds the same everywhere in a cell.
class SandedRail : public RailCells {
 public:
  /// A wheel runs from one arc length to another, a mass of sand in front of it [kg].
  ///
  /// @param kept  of the sand under the wheel that stays on the rail [-]
  /// @returns mass per length under the wheel at the end [kg/m]
  double run(double from, double to, double mass, double kept) {
    double const cell = cell_length(), way = to - from;
    if (mass > 0.0) {
      bool const stands = way < shortest;  // then all of it falls on one cell
      add(from + cell, stands ? from + 2.0 * cell : to + cell, mass / (stands ? cell : way));
    }
    if (kept < 1.0) keep(from - cell, to - cell, kept);
    return at(to);
  }

 private:
  static constexpr double shortest = 1e-9;  ///< way of a step [m]
};

/// Energy per area of the rail that passes at train speed, even if wheels slide [J/m^2].
///
/// @param power  dissipated by one wheel [W]
/// @param width  of the rail over which it is spread [m]
inline double energy_per_area(double power, double train_speed, double width) {
  constexpr double least_speed = 0.1;  // below it the energy is counted as at it [m/s]
  return power / (std::max(train_speed, least_speed) * width);
}

/// What a wheel's own tread keeps of its cleaning by sliding.
///
///   energy per area that the wheel dissipates on the rail -> [mean of the tread, fading as the wheel rolls] -> energy per area
///
/// The energy that cleans a length ds of rail cleans as much of the tread: spread over the circumference, since a tread element
/// comes round long before the film on it has changed. While the wheel rolls over contaminated rail it takes up a film again:
///
///     dE/ds_w = (e ds/ds_w) / (2 pi r) - E / L        (A16)
///
/// with s_w the length rolled, e the energy per area of rail and L the memory. Of a locked wheel s_w does not grow: nothing fades.
/// Source  ours; docs/theory/adhesion.md.
struct CleanedWheel {
  double energy{0.0};  ///< per area of the tread, its mean [J/m^2]
  void state(auto& archive) { archive(energy); }

  /// @param dissipated     per area of the rail, by this wheel [J/m^2]
  /// @param passed         length of the rail that passed [m]
  /// @param rolled         length that the wheel rolled, its magnitude [m]
  /// @param circumference  of the wheel [m]
  /// @param memory         L: length rolled over which cleaning fades to 1/e [m]; 0: a wheel keeps nothing
  void run(double dissipated, double passed, double rolled, double circumference, double memory) {
    if (!(memory > 0.0)) return;
    double const gain = dissipated * passed / circumference, fade = rolled / memory;
    double const kept = fade > 1e-9 ? -std::expm1(-fade) / fade : 1.0;  // of what comes in evenly over the step
    energy = energy * std::exp(-fade) + gain * kept;
  }

  /// The wheel over a step, that begins at an arc length of a rail, or of several, of which it finds the mean.
  ///
  /// @param passed  length of the rail that passes, not the difference of places that may be far out [m]
  /// @returns energy per area under it: left by those ahead, kept by its tread, and half of its own, since the other half is
  ///          dissipated behind the patch's middle [J/m^2]
  double pass(std::span<RailCells> rails, double from, double passed, double dissipated, double rolled,
              double circumference, double memory) {
    double under = energy + 0.5 * dissipated;
    for (RailCells& rail : rails) {
      under += rail.before(from) / static_cast<double>(rails.size());
      rail.add(from, from + passed, dissipated);
    }
    run(dissipated, passed, rolled, circumference, memory);
    return under;
  }
};

}  // namespace rollerrig
