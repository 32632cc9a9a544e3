// Actuators: motors, brakes and roller drives, running resistance, geared rotors and rolling constraints.
#include "rollerrig/system/force_assembly.hpp"

namespace rollerrig {
namespace {

/// The torque of a table, and that of an input beside it.
template <Scalar T>
T torque_at(TimeTable const& table, std::vector<HeldInput> const& inputs, std::size_t index, T const& t) {
  T const torque = table.at(t);
  return inputs.empty() ? torque : torque + inputs[index].at(t);
}

}  // namespace

/// What holds a motor against the moment it exerts: the reaction body, or for an axle-hung one a vertical force at its link
/// there and the opposite one on the axle. (A9)
template <Scalar T>
void ForceAssembly<T>::apply_reaction(AxleTorque const& torque, Vec3<T> const& moment) const {
  auto const& motion = w_.curved ? w_.common : w_.motion;
  auto& wrench = w_.curved ? w_.common_wrench : w_.wrench;
  auto const& axle = motion[at(torque.wheelset)];
  auto const& body = motion[at(torque.reaction)];
  auto& on_body = wrench[at(torque.reaction)];
  if (torque.link == 0.0) {
    on_body.moment -= moment;
    w_.power[work_of_torque] -= dot(moment, body.omega);
    return;
  }
  Vec3<T> const arm = T(torque.link_on_reaction) * body.R.ex;
  Vec3<T> const force = (dot(moment, axle.R.ey) / torque.link) * body.R.ez;
  on_body.force += force;
  on_body.moment += cross(arm, force);
  wrench[at(torque.wheelset)].force -= force;
  w_.power[work_of_torque] += dot(force, body.v + cross(body.omega, arm) - axle.v);
}

template <Scalar T>
void ForceAssembly<T>::apply_axle_torques(T const& t) const {
  auto const& motion = w_.curved ? w_.common : w_.motion;
  auto& wrench = w_.curved ? w_.common_wrench : w_.wrench;
  for (std::size_t i = 0; i < model_.axle_torques.size(); ++i) {
    AxleTorque const& torque = model_.axle_torques[i];
    auto const& wheelset = motion[at(torque.wheelset)];
    Vec3<T> const moment = torque_at(torque.torque, inputs_.axle_torque, i, t) * wheelset.R.ey;
    wrench[at(torque.wheelset)].moment += moment;
    w_.power[work_of_torque] += dot(moment, wheelset.omega);
    if (torque.reaction != ground) apply_reaction(torque, moment);
  }
}

template <Scalar T>
void ForceAssembly<T>::apply_roller_torques(T const& t) const {
  for (std::size_t i = 0; i < model_.roller_torques.size(); ++i) {
    RollerTorque const& torque = model_.roller_torques[i];
    auto const& roller = w_.motion[at(torque.roller)];
    Vec3<T> const moment = -(torque_at(torque.torque, inputs_.roller_torque, i, t) * roller.R.ey);
    w_.wrench[at(torque.roller)].moment += moment;
    w_.power[work_of_drive] += dot(moment, roller.omega);
  }
}

template <Scalar T>
void ForceAssembly<T>::apply_brakes(T const& t) const {
  auto const& motion = w_.curved ? w_.common : w_.motion;
  auto& wrench = w_.curved ? w_.common_wrench : w_.wrench;
  for (std::size_t i = 0; i < model_.brakes.size() && !inputs_.cylinder.empty(); ++i) {
    AxleBrake const& brake = model_.brakes[i];
    auto const& wheelset = motion[at(brake.wheelset)];
    T turning = dot(wheelset.R.ey, wheelset.omega);
    if (brake.reaction != ground) turning = turning - dot(wheelset.R.ey, motion[at(brake.reaction)].omega);
    T const torque = brake.brake.torque(inputs_.cylinder[i].at(t), turning);
    Vec3<T> const moment = torque * wheelset.R.ey;
    wrench[at(brake.wheelset)].moment += moment;
    if (brake.reaction != ground) wrench[at(brake.reaction)].moment -= moment;
    w_.power[dissipated_brakes] -= torque * turning;
    if constexpr (std::same_as<T, double>) evaluation_.brake_torque[i] = torque;
  }
}

/// Against running, in the line of the centre of what carries the magnets.
template <Scalar T>
void ForceAssembly<T>::apply_track_brakes(T const& t) const {
  for (BodyTrackBrake const& own : model_.track_brakes) {
    auto const& m = w_.motion[at(own.body)];
    T const force = inputs_.track_brake.at(t) * own.brake.force(w_.travel.speed + m.v.x);
    w_.wrench[at(own.body)].force.x -= force;
    w_.power[work_of_drive] -= force * m.v.x;
  }
}

template <Scalar T>
void ForceAssembly<T>::apply_resistance() const {
  RunningResistance const& r = model_.resistance;
  if (r.body != ground) {
    auto const& m = w_.motion[at(r.body)];
    T const force = r.force(w_.travel.speed + m.v.x);
    w_.wrench[at(r.body)].force.x -= force;
    w_.power[work_of_drive] -= force * m.v.x;
  }
  if (r.gradient == 0.0 || !model_.on_rails) return;
  for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
    Body const& body = model_.bodies[b];
    if (!body.in_moving_frame) continue;
    double const force = body.mass * model_.gravity * r.gradient;
    w_.wrench[b].force.x -= T(force);
    w_.power[work_of_drive] -= force * w_.motion[b].v.x;
  }
}

/// Geared rotors and rolling constraints: all wrenches but theirs are there. Of a selection those of its bodies; the others
/// do not change.
template <Scalar T>
void ForceAssembly<T>::apply_couplings(Selection const* selection) const {
  double const acceleration = value_of(w_.travel.acceleration);
  auto const selected = [&](int body) { return !selection || selection->body[at(body)]; };
  for (std::size_t i = 0; i < model_.rolling_constraints.size(); ++i) {
    auto const b = at(model_.rolling_constraints[i].wheelset), r = at(model_.rolling_constraints[i].roller);
    if (!selected(static_cast<int>(b))) continue;
    w_.power[dissipated_creep] +=
        remove_mean_creep(w_.axle_creep[i], w_.motion[b], w_.motion[r], w_.wrench[b], w_.wrench[r]);
  }
  for (std::size_t i = 0; i < model_.couplings.size(); ++i) {
    Coupling const& coupling = model_.couplings[i];
    w_.coupling_load[i] = T(0.0);
    if (!selected(coupling.term[0].body)) continue;
    T rate = coupling.rate * coupling_speed(coupling, w_.motion);
    for (CouplingTerm const& c : coupling.term) {
      if (c.body < 0) continue;
      auto const b = at(c.body);
      T const pitch(model_.bodies[b].prescribed_pitch(acceleration));
      rate = rate + coupling_acceleration(c, model_.bodies[b], w_.motion[b], w_.wrench[b], w_.gyroscopic[b], pitch);
    }
    w_.coupling_load[i] = -rate;
  }
  for (std::size_t i = 0; i < model_.couplings.size(); ++i) {
    Coupling const& coupling = model_.couplings[i];
    if (!selected(coupling.term[0].body)) continue;
    T multiplier(0.0);
    for (std::size_t k = 0; k < model_.couplings.size(); ++k)
      multiplier = multiplier + model_.coupling_matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) *
                                    w_.coupling_load[k];
    for (CouplingTerm const& c : coupling.term)
      if (c.body >= 0) apply_coupling(c, w_.motion[at(c.body)], multiplier, w_.wrench[at(c.body)]);
    if (i < model_.rotors) continue;
    std::size_t const constraint = i - model_.rotors;
    w_.power[dissipated_creep] -= multiplier * coupling_speed(coupling, w_.motion);
    if constexpr (std::same_as<T, double>)
      evaluation_.rolling_force[constraint] = multiplier - w_.axle_creep[constraint].force;
  }
}

#define ROLLERRIG_INSTANTIATE(T)                                        \
  template void ForceAssembly<T>::apply_axle_torques(T const&) const;   \
  template void ForceAssembly<T>::apply_roller_torques(T const&) const; \
  template void ForceAssembly<T>::apply_brakes(T const&) const;         \
  template void ForceAssembly<T>::apply_track_brakes(T const&) const;   \
  template void ForceAssembly<T>::apply_resistance() const;             \
  template void ForceAssembly<T>::apply_couplings(Selection const*) const;
ROLLERRIG_INSTANTIATE(double)
ROLLERRIG_INSTANTIATE(JacobianDual)
#undef ROLLERRIG_INSTANTIATE

}  // namespace rollerrig
