// system/stiff_creep_modes.hpp - the velocities that creep forces brake fast, and the dampers' inner nodes, as stiff modes.
//
//   evaluation (patches, placement of the wheels) -> [M^-1 D] -> modes with their rates -> exponential method
//
// The creep forces of one wheelset brake the velocities v of it and of its rollers: v' = -M^-1 D v with D = sum of
// viscosity d d^T over its slips. The eigenvectors, orthogonal with respect to M, are the modes.
// Source: docs/theory/time_integration.md, (T7).
#pragma once
#include <array>

#include "rollerrig/integrate/differential_equation.hpp"
#include "rollerrig/system/force_assembly.hpp"

namespace rollerrig {

class StiffCreepModes {
 public:
  explicit StiffCreepModes(Model const& model);

  /// An empty set with room for all there can be.
  StiffModes room() const;

  /// Fills `next` and returns true where the last evaluation asks for other modes than `now`.
  bool renew(Model const& model, Evaluation const& evaluation, StiffModes const& now, StiffModes& next) const;

 private:
  static constexpr std::size_t most_slips = 8;   ///< of one wheelset: two for each of four patches
  static constexpr std::size_t most_bodies = 3;  ///< of a group
  static constexpr std::size_t most_velocities = 6 * most_bodies;

  /// A wheelset with the rollers under it, and its contacts: creep of other wheels does not touch them.
  struct Group {
    std::vector<int> body;
    std::vector<int> contact;
  };
  /// Velocities that the slips of one wheelset consist of.
  struct Slips {
    std::size_t count{0};
    std::array<std::array<double, most_velocities>, most_slips> d{};  ///< times the root of its viscosity
    std::array<std::array<double, most_velocities>, most_slips> u{};  ///< M^-1 d
    std::array<double, most_slips> trend{};                           ///< rate of what no state makes: of the rail
    std::array<double, most_slips> work{};                            ///< work of drives on an impulse of one
  };
  using Square = std::array<std::array<double, most_slips>, most_slips>;

  template <class Take>
  static std::size_t for_each_slip(Group const& group, Evaluation const& evaluation, Take const& take);
  bool look_up_viscosities(Model const& model, Evaluation const& evaluation, StiffModes const& now,
                           StiffModes& next) const;
  void add_slip(Model const& model, Evaluation const& evaluation, Group const& group, int contact, int k, bool lateral,
                double viscosity, Slips& slips) const;
  double add_velocities(Model const& model, Evaluation const& evaluation, int body, Wrench<double> const& wrench,
                        double* d, double* u) const;
  void add_modes(Model const& model, Group const& group, Slips const& slips, StiffModes& out) const;
  static void diagonalise(Square& g, Square& w, std::size_t n);

  std::vector<Group> groups_;
  std::size_t nodes_;                  ///< inner nodes of the elements
  std::vector<double> rotor_inertia_;  ///< that geared rotors add to the pitch inertia of each body [kg m^2]
};

}  // namespace rollerrig
