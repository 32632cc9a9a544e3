// system/inputs.hpp - what actuators and controllers do to the plant between two of their instants.
//
//   bench (motors, brakes, controllers) -> [inputs: straight lines over one step] -> dynamics
//
// Everything here is given to the plant: it acts back on nothing by itself. Without a bench all of it is empty.
#pragma once
#include <vector>

#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// A number on a straight line over time.
struct HeldInput {
  bool operator==(HeldInput const&) const = default;

  double time{0.0};   ///< [s]
  double value{0.0};  ///< there
  double slope{0.0};  ///< per second

  void state(auto& archive) { archive(time, value, slope); }

  template <Scalar T>
  T at(T const& t) const {
    return value + slope * (t - time);
  }
};

struct Inputs {
  bool operator==(Inputs const&) const = default;

  std::vector<HeldInput> axle_torque;     ///< per axle torque of the model, beside its table [N m]
  std::vector<HeldInput> roller_torque;   ///< per roller torque of the model [N m]
  std::vector<HeldInput> cylinder;        ///< per axle brake of the model, over the ambient [Pa]
  std::vector<double> dissipated_energy;  ///< per contact: density on the rail under it [J/m^2]
  std::vector<double> sand;               ///< per contact: mass per length of the rail under it [kg/m]; empty: none
  std::vector<double> friction;           ///< per contact: over what its law says [-]; empty: 1
  HeldInput track_brake{};                ///< excitation of the model's track brakes, 0 to 1
  bool frame_moves{false};                ///< the vehicle's frames move as the next three say, not as the table
  HeldInput speed{};                      ///< [m/s]
  double distance{0.0};                   ///< s at speed.time [m]

  /// For plant/state_archive.hpp, of a model with so many torques, brakes and contacts. A list is as long as at the start of a
  /// run, or whole.
  void state(auto& archive, std::size_t axles, std::size_t rollers, std::size_t brakes, std::size_t contacts) {
    auto const list = [&](auto& values, std::size_t whole) {
      std::size_t const before = values.size();
      archive.list(values, whole);
      archive.need(values.size() == before || values.size() == whole);
    };
    list(axle_torque, axles), list(roller_torque, rollers), list(cylinder, brakes);
    list(dissipated_energy, contacts), list(sand, contacts), list(friction, contacts);
    archive(track_brake, frame_moves, speed, distance);
  }
};

}  // namespace rollerrig
