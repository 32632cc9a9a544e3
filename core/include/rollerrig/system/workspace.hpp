// system/workspace.hpp - everything that changes while one model is evaluated: one set for each run.
//
//   Model (constant, shared) + t, x, inputs -> [workspace] -> derivatives, outputs
#pragma once
#include <vector>

#include "rollerrig/contact/patch.hpp"
#include "rollerrig/multibody/moving_frame.hpp"
#include "rollerrig/system/contact_placement.hpp"
#include "rollerrig/system/model.hpp"

namespace rollerrig {

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
  std::vector<WheelStrips<T>> strips;              ///< per contact, of its patches; none if no creep law follows them
  std::vector<NormalContact<T, Patch<T>>> wheels;  ///< those of one group that are evaluated ...
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
    for (auto const& contact : model.contacts)
      if (follows_strips(contact.laws.creep)) strips.resize(model.contacts.size());
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

}  // namespace rollerrig
