// Machines in the dynamics: motors, brakes and drives, running resistance, geared rotors and rolling constraints.
//
//   wrenches of suspension and contacts -> [machines: torques, resistance, couplings] -> Newton and Euler (dynamics.cpp)
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

/// What holds a motor against the moment it exerts: its carrier, or for an axle-hung one a vertical force at its link there and
/// the opposite one on the axle. (A9)
template <Scalar T>
void Dynamics::hold(Workspace<T>& w, std::size_t axle_torque, Vec3<T> const& moment) {
  AxleTorque const& torque = model_->axle_torques[axle_torque];
  auto const& motion = w.curved ? w.common : w.motion;
  auto& wrench = w.curved ? w.common_wrench : w.wrench;
  auto const& axle = motion[at(torque.wheelset)];
  auto const& carrier = motion[at(torque.reaction)];
  auto& on_carrier = wrench[at(torque.reaction)];
  if (torque.link == 0.0) {
    on_carrier.moment -= moment;
    w.power[work_of_torque] -= dot(moment, carrier.omega);
    return;
  }
  Vec3<T> const arm = T(torque.link_on_reaction) * carrier.R.ex;
  Vec3<T> const force = (dot(moment, axle.R.ey) / torque.link) * carrier.R.ez;
  on_carrier.force += force;
  on_carrier.moment += cross(arm, force);
  wrench[at(torque.wheelset)].force -= force;
  w.power[work_of_torque] += dot(force, carrier.v + cross(carrier.omega, arm) - axle.v);
}

/// Motors and brakes on axles, drives of rollers.
template <Scalar T>
void Dynamics::apply_torques(Workspace<T>& w, T const& t) {
  Model const& model = *model_;
  auto const& motion = w.curved ? w.common : w.motion;
  auto& wrench = w.curved ? w.common_wrench : w.wrench;
  for (std::size_t i = 0; i < model.axle_torques.size(); ++i) {
    auto const& torque = model.axle_torques[i];
    auto const& wheelset = motion[at(torque.wheelset)];
    T c = torque.torque.at(t);
    if (!inputs.axle_torque.empty()) c = c + inputs.axle_torque[i].at(t);
    Vec3<T> const moment = c * wheelset.R.ey;
    wrench[at(torque.wheelset)].moment += moment;
    w.power[work_of_torque] += dot(moment, wheelset.omega);
    if (torque.reaction == ground) continue;
    hold(w, i, moment);
  }
  for (std::size_t i = 0; i < model.roller_torques.size(); ++i) {
    auto const& torque = model.roller_torques[i];
    auto const& roller = w.motion[at(torque.roller)];
    T c = torque.torque.at(t);
    if (!inputs.roller_torque.empty()) c = c + inputs.roller_torque[i].at(t);
    Vec3<T> const moment = -(c * roller.R.ey);
    w.wrench[at(torque.roller)].moment += moment;
    w.power[work_of_drive] += dot(moment, roller.omega);
  }
  for (std::size_t i = 0; i < model.brakes.size() && !inputs.cylinder.empty(); ++i) {
    AxleBrake const& brake = model.brakes[i];
    auto const& wheelset = motion[at(brake.wheelset)];
    T turning = dot(wheelset.R.ey, wheelset.omega);
    if (brake.reaction != ground) turning = turning - dot(wheelset.R.ey, motion[at(brake.reaction)].omega);
    T const c = brake.brake.torque(inputs.cylinder[i].at(t), turning);
    Vec3<T> const moment = c * wheelset.R.ey;
    wrench[at(brake.wheelset)].moment += moment;
    if (brake.reaction != ground) wrench[at(brake.reaction)].moment -= moment;
    w.power[dissipated_brakes] -= c * turning;
    if constexpr (std::same_as<T, double>) brake_torque_[i] = c;
  }
}

template <Scalar T>
void Dynamics::apply_resistance(Workspace<T>& w) {
  auto const& r = model_->resistance;
  if (r.body != ground) {
    auto& wrench = w.wrench[at(r.body)];
    auto const& m = w.motion[at(r.body)];
    T const force = r.force(w.travel.speed + m.v.x);
    wrench.force.x -= force;
    w.power[work_of_drive] -= force * m.v.x;
  }
  if (r.gradient == 0.0) return;
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    Body const& body = model_->bodies[b];
    if (!body.in_moving_frame || !on_rails_) continue;
    double const force = body.mass * model_->gravity * r.gradient;
    w.wrench[b].force.x -= T(force);
    w.power[work_of_drive] -= force * w.motion[b].v.x;
  }
}

/// Geared rotors and rolling constraints: all wrenches but theirs are there. With a sweep, those of its bodies; the others do
/// not change.
template <Scalar T>
void Dynamics::apply_couplings(Workspace<T>& w, Sweep const* sweep) {
  Model const& model = *model_;
  double const acceleration = value_of(w.travel.acceleration);
  auto const counts = [&](Coupling const& c) { return !sweep || sweep->affected_body[at(c.term[0].body)]; };
  for (std::size_t i = 0; i < model.rolling_constraints.size(); ++i) {
    auto const b = at(model.rolling_constraints[i].wheelset), r = at(model.rolling_constraints[i].roller);
    if (!sweep || sweep->affected_body[b])
      w.power[dissipated_creep] +=
          remove_mean_creep(w.axle_creep[i], w.motion[b], w.motion[r], w.wrench[b], w.wrench[r]);
  }
  for (std::size_t i = 0; i < model.couplings.size(); ++i) {
    Coupling const& coupling = model.couplings[i];
    w.coupling_load[i] = T(0.0);
    if (!counts(coupling)) continue;
    T rate = coupling.rate * coupling_speed(coupling, w.motion);
    for (CouplingTerm const& c : coupling.term) {
      if (c.body < 0) continue;
      auto const b = at(c.body);
      T const pitch(model.bodies[b].prescribed_pitch(acceleration));
      rate = rate + coupling_acceleration(c, model.bodies[b], w.motion[b], w.wrench[b], w.gyroscopic[b], pitch);
    }
    w.coupling_load[i] = -rate;
  }
  for (std::size_t i = 0; i < model.couplings.size(); ++i) {
    Coupling const& coupling = model.couplings[i];
    if (!counts(coupling)) continue;
    T multiplier(0.0);
    for (std::size_t k = 0; k < model.couplings.size(); ++k)
      multiplier = multiplier + model.coupling_matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) *
                                    w.coupling_load[k];
    for (CouplingTerm const& c : coupling.term)
      if (c.body >= 0) apply_coupling(c, w.motion[at(c.body)], multiplier, w.wrench[at(c.body)]);
    if (i < model.rotors) continue;
    std::size_t const constraint = i - model.rotors;
    w.power[dissipated_creep] -= multiplier * coupling_speed(coupling, w.motion);
    if constexpr (std::same_as<T, double>) rolling_force_[constraint] = multiplier - w.axle_creep[constraint].force;
  }
}

template void Dynamics::apply_torques(Workspace<double>&, double const&);
template void Dynamics::apply_torques(Workspace<JacobianDual>&, JacobianDual const&);
template void Dynamics::apply_resistance(Workspace<double>&);
template void Dynamics::apply_resistance(Workspace<JacobianDual>&);
template void Dynamics::apply_couplings(Workspace<double>&, Sweep const*);
template void Dynamics::apply_couplings(Workspace<JacobianDual>&, Sweep const*);

}  // namespace rollerrig
