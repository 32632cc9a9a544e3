#include "rollerrig/system/force_assembly.hpp"

namespace rollerrig {

template <Scalar T>
void ForceAssembly<T>::place_track(T const& t) const {
  bool const has_line = model_.on_rails && !model_.line.empty();
  if (!has_line && !model_.displaces_rails() && !model_.on_adhesion_map && !inputs_.frame_moves) {
    w_.travel = {T(0.0), model_.speed.at(t), T(model_.speed.rate(value_of(t)))};
    return;
  }
  w_.travel = travel_now(model_, inputs_, t);
  double const s = value_of(w_.travel.s);
  w_.curved = has_line && !model_.line.straight(s + model_.rear, s + model_.front);
  if (w_.curved)
    for (std::size_t b = 0; b < model_.bodies.size(); ++b)
      w_.frame[b] = track_frame(model_.line, w_.travel, model_.bodies[b].position.x);
  if (!model_.displaces_rails()) return;
  for (std::size_t i = 0; i < model_.contacts.size(); ++i) {
    WheelContact const& contact = model_.contacts[i];
    T const place = w_.travel.s + contact.distance_ahead;
    w_.offset[i] = model_.irregularity
                       ? model_.irregularity->at(contact.right, place, model_.start + model_.foremost_wheel)
                       : RailOffset<T>{};
    if (has_line) (contact.right ? model_.line.right : model_.line.left).add_to(w_.offset[i], place);
  }
}

template <Scalar T>
void ForceAssembly<T>::apply_weight(std::size_t b) const {
  Body const& body = model_.bodies[b];
  double const weight = body.mass * model_.gravity;
  w_.wrench[b] = {};
  w_.wrench[b].force.z = T(-weight);
  if (!w_.curved) return;
  w_.common_wrench[b] = {};
  if (body.in_moving_frame) w_.wrench[b].force = T(-weight) * w_.frame[b].up;
}

/// Bearings and air around a body that spins; what holds them is the ground.
template <Scalar T>
void ForceAssembly<T>::apply_loss(std::size_t b) const {
  Body const& body = model_.bodies[b];
  auto const& m = w_.motion[b];
  T const torque = body.loss(m.omega_body.y);
  w_.wrench[b].moment -= torque * m.R.ey;
  w_.power[dissipated_elements] += torque * m.omega_body.y;
}

template <Scalar T>
void ForceAssembly<T>::apply_element(std::size_t index) const {
  ForceElement const& e = model_.elements[index];
  // The ground of an element is the track under the body it holds: its own frame. Two bodies meet in the common one.
  bool const common = curved_motion(e.body_a, e.body_b);
  auto const& motion = common ? w_.common : w_.motion;
  auto& wrench = common ? w_.common_wrench : w_.wrench;
  auto const& a = e.body_a >= 0 ? motion[at(e.body_a)] : w_.ground_motion;
  auto const& b = e.body_b >= 0 ? motion[at(e.body_b)] : w_.ground_motion;
  Vec3<double> const origin_a = e.body_a >= 0 ? model_.bodies[at(e.body_a)].position : Vec3<double>{};
  Vec3<double> const origin_b = e.body_b >= 0 ? model_.bodies[at(e.body_b)].position : Vec3<double>{};
  auto const m = element_motion(e, a, b, origin_b - origin_a);

  std::array<T, 6> f{T(0.0), T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)};
  for (std::size_t c = 0; c < (e.rotational ? 6U : 3U); ++c) {
    DirectionLaw const& law = e.law[c];
    if (!law.active()) continue;
    auto const out =
        direction_force(law, m.d[c], m.rate[c], w_.node.data() + e.node[c], w_.node_rate.data() + e.node[c]);
    f[c] = out.force;
    w_.power[dissipated_elements] += out.dissipated;
    if constexpr (std::same_as<T, double>) {
      evaluation_.element_force[index][c] = out.force;
      evaluation_.element_deflection[index][c] = m.d[c];
    }
  }
  auto const on_b = element_wrench(e, m, a, b, f);
  if (e.body_b >= 0) {
    wrench[at(e.body_b)].force += on_b.force;
    wrench[at(e.body_b)].moment += cross(m.arm_b, on_b.force) + on_b.moment;
  }
  if (e.body_a >= 0) {
    wrench[at(e.body_a)].force -= on_b.force;
    wrench[at(e.body_a)].moment -= cross(m.arm_a, on_b.force) + on_b.moment;
  }
}

/// Force and moment of the elements and of the moving frame on a body in a curve; returns the gyroscopic moment. (W4), (W5), (W9)
template <Scalar T>
Vec3<T> ForceAssembly<T>::moving_frame_wrench(std::size_t b) const {
  Body const& body = model_.bodies[b];
  auto const& m = w_.motion[b];
  auto const& frame = w_.frame[b];
  Wrench<T> const common{frame.R.transposed_times(w_.common_wrench[b].force),
                         frame.R.transposed_times(w_.common_wrench[b].moment)};
  w_.wrench[b].force += common.force;
  w_.wrench[b].moment += common.moment;
  if (!body.in_moving_frame) return gyroscopic_moment(body, m);
  Vec3<T> const inertial = T(-body.mass) * transport_acceleration(body, frame, m);
  Vec3<T> const gyroscopic = gyroscopic_moment(body, frame, m);
  w_.wrench[b].force += inertial;
  w_.power[work_of_drive] +=
      transport_power(body, frame, w_.travel.speed, model_.gravity, m, common, inertial, gyroscopic);
  return gyroscopic;
}

/// What the motion of the frames and of the body itself adds to the applied forces.
template <Scalar T>
void ForceAssembly<T>::apply_inertia(std::size_t b) const {
  if (w_.curved) {
    w_.gyroscopic[b] = moving_frame_wrench(b);
    return;
  }
  Body const& body = model_.bodies[b];
  w_.gyroscopic[b] = gyroscopic_moment(body, w_.motion[b]);
  double const acceleration = value_of(w_.travel.acceleration);
  if (!model_.on_rails || !body.in_moving_frame || acceleration == 0.0) return;
  T const force = T(-body.mass * acceleration);  // the straight track's frame: (W4) is its acceleration
  w_.wrench[b].force.x += force;
  w_.power[work_of_drive] += force * w_.motion[b].v.x;
}

template <Scalar T>
void ForceAssembly<T>::accelerate(T const& t, Selection const* selection) const {
  auto const selected = [&](std::size_t b) { return !selection || selection->body[b]; };
  std::size_t const bodies = model_.bodies.size();

  w_.power.fill(T(0.0));
  if constexpr (std::same_as<T, double>) evaluation_.longitudinal_force = 0.0;
  for (auto& creep : w_.axle_creep) creep = {};
  for (std::size_t b = 0; b < bodies; ++b)
    if (selected(b)) apply_weight(b);
  for (std::size_t b = 0; b < bodies; ++b)
    if (selected(b) && model_.bodies[b].has_losses()) apply_loss(b);
  for (std::size_t i = 0; i < model_.elements.size(); ++i)
    if (!selection || selection->element[i]) apply_element(i);
  apply_contacts(t, selection);
  apply_axle_torques(t);
  apply_roller_torques(t);
  apply_brakes(t);
  apply_track_brakes(t);
  apply_resistance();
  for (std::size_t b = 0; b < bodies; ++b)
    if (selected(b)) apply_inertia(b);
  if (!model_.couplings.empty()) apply_couplings(selection);
  double const acceleration = value_of(w_.travel.acceleration);
  for (std::size_t b = 0; b < bodies; ++b) {
    if (!selected(b)) continue;
    Body const& body = model_.bodies[b];
    auto const& m = w_.motion[b];
    T const pitch(body.prescribed_pitch(acceleration));
    w_.acceleration[b] = accelerations(body, m, w_.wrench[b], w_.gyroscopic[b], pitch, w_.constraint_moment[b]);
    if (body.speed_controlled()) w_.power[work_of_drive] += w_.constraint_moment[b] * m.rate[coord_pitch];
  }
}

template void ForceAssembly<double>::place_track(double const&) const;
template void ForceAssembly<JacobianDual>::place_track(JacobianDual const&) const;
template void ForceAssembly<double>::accelerate(double const&, Selection const*) const;
template void ForceAssembly<JacobianDual>::accelerate(JacobianDual const&, Selection const*) const;

}  // namespace rollerrig
