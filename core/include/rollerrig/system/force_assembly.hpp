// system/force_assembly.hpp - all forces on all bodies in one state, then Newton and Euler.
//
//   motion of the bodies, track, inputs -> [suspension, contacts, actuators, couplings] -> wrenches -> accelerations
//
// Inputs are given to the plant by motors, brakes and controllers, as straight lines over one step; without these all of it is empty.
// What changes while a model is evaluated is a Workspace, one set for each run. The same code runs in double and in JacobianDual. A
// sweep of the Jacobian evaluates only what its seeds touch.
#pragma once
#include <vector>

#include "rollerrig/contact/patch.hpp"
#include "rollerrig/math/dual.hpp"
#include "rollerrig/multibody/moving_frame.hpp"
#include "rollerrig/system/contact_placement.hpp"
#include "rollerrig/system/model.hpp"

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

/// Motion and forces in one state, in the scalar of the evaluation.
template <Scalar T>
struct Workspace {
  std::vector<BodyMotion<T>> motion;
  std::vector<Wrench<T>> wrench;
  std::vector<std::array<T, 6>> acceleration;
  std::vector<T> constraint_moment;  ///< of the drives of speed-controlled bodies [N m]
  std::vector<T> node;
  std::vector<T> node_rate;
  BodyMotion<T> ground_motion;
  std::array<T, account_count> power;
  std::vector<AxleCreep<T>> axle_creep;  ///< per rolling constraint
  std::vector<Vec3<T>> gyroscopic;       ///< per body, body components [N m]
  std::vector<T> coupling_load;          ///< per coupling

  std::vector<ContactPlacement<T>> placed;         ///< per contact
  std::vector<WheelPatches<T>> patches;            ///< per contact
  std::vector<int> patch_count;                    ///< per contact
  bool patches_given{false};                       ///< they are not looked for
  std::vector<WheelStrips<T>> strips;              ///< per contact, of its patches; none if no creep law follows them
  std::vector<NormalContact<T, Patch<T>>> wheels;  ///< those that are evaluated ...
  std::vector<MovingPatch<T>> under_load;          ///< ... and all their patches

  Travel<T> travel;
  std::vector<RailOffset<T>> offset;  ///< per contact, of the irregularity
  bool curved{false};                 ///< some body is in a curve or on cant; else what follows is not used
  std::vector<TrackFrame<T>> frame;   ///< per body
  std::vector<BodyMotion<T>> common;  ///< per body: its motion seen from H, multibody/moving_frame.hpp
  std::vector<Wrench<T>> common_wrench;

  explicit Workspace(Model const& model)
      : motion(model.bodies.size()),
        wrench(model.bodies.size()),
        acceleration(model.bodies.size()),
        constraint_moment(model.bodies.size(), T(0.0)),
        node(at(model.map.nodes), T(0.0)),
        node_rate(at(model.map.nodes), T(0.0)),
        axle_creep(model.rolling_constraints.size()),
        gyroscopic(model.bodies.size()),
        coupling_load(model.couplings.size()),
        placed(model.contacts.size()),
        patches(model.contacts.size()),
        patch_count(model.contacts.size(), 0),
        offset(model.contacts.size()),
        frame(model.bodies.size()),
        common(model.bodies.size()),
        common_wrench(model.bodies.size()) {
    update_motion(Body{}, ground_motion);
    wheels.reserve(model.contacts.size());
    under_load.reserve(model.contacts.size() * GapScan::most_minima);
    if (follows_strips(model.laws.creep)) strips.resize(model.contacts.size());
  }
};

/// An evaluation in double, with what outputs, controllers and the Jacobian read from it.
struct Evaluation {
  Workspace<double> work;
  std::vector<HeadUnderWheel> head;                       ///< per contact; follows from the time
  std::vector<std::array<double, 6>> element_force;       ///< on body b along its direction [N, N m]
  std::vector<std::array<double, 6>> element_deflection;  ///< [m, rad]
  std::vector<double> brake_torque;                       ///< per brake [N m]
  std::vector<double> rolling_force;                      ///< per rolling constraint [N]
  double longitudinal_force{0.0};                         ///< of all contacts on the wheels [N]

  explicit Evaluation(Model const& model);

  int patch_count(int contact) const { return work.patch_count[at(contact)]; }
  Patch<double> const& patch(int contact, int k) const { return work.patches[at(contact)][at(k)]; }
};

/// Which parts of a model depend on a few states, or on time.
struct Selection {
  std::vector<char> element, contact;
  std::vector<char> body;  ///< its acceleration depends on them
};

/// Where the vehicle's reference point is along the line.
template <Scalar T>
Travel<T> travel_now(Model const& model, Inputs const& inputs, T const& t) {
  if (!inputs.frame_moves) return travel_at(model.speed, model.start, t);
  T const since = t - inputs.speed.time;
  T const speed = inputs.speed.at(t);
  return {inputs.distance + 0.5 * since * (inputs.speed.value + speed), speed, T(inputs.speed.slope)};
}

template <Scalar T>
class ForceAssembly {
 public:
  /// @param evaluation  the one in double; gets its results where T is double
  ForceAssembly(Model const& model, Inputs const& inputs, Evaluation& evaluation, Workspace<T>& work)
      : model_{model}, inputs_{inputs}, evaluation_{evaluation}, w_{work} {}

  /// Where the track has brought everything at this time; knows nothing of the state.
  void place_track(T const& t) const;
  /// The motion of a body as elements between two track frames see it.
  void see_from_common(std::size_t body) const {
    see_from_common_frame(model_.bodies[body], w_.frame[body], w_.travel.speed, w_.motion[body], w_.common[body]);
  }

  /// Everything from the motion to the accelerations; of a selection only what it names.
  void accelerate(T const& t, Selection const* selection = nullptr) const;

 private:
  Model const& model_;
  Inputs const& inputs_;
  Evaluation& evaluation_;
  Workspace<T>& w_;
};

}  // namespace rollerrig
