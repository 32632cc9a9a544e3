// Contacts: where each wheel lies on its rail or roller, its patches, and what they do to both bodies. Actuators: motors, brakes and
// roller drives, running resistance, geared rotors and rolling constraints.
#include "rollerrig/system/force_assembly.hpp"

namespace rollerrig {
namespace {

/// The torque of a table, and that of an input beside it.
template <Scalar T>
T torque_at(TimeTable const& table, std::vector<HeldInput> const& inputs, std::size_t index, T const& t) {
  T const torque = table.at(t);
  return inputs.empty() ? torque : torque + inputs[index].at(t);
}

/// Where the load of a wheel lies on the head, its mean [m].
template <Scalar T>
T loaded_abscissa(WheelPatches<T> const& patches, int count) {
  T load(1e-9), moment(0.0);
  for (int k = 0; k < count; ++k) {
    auto const& patch = patches[at(k)];
    load += patch.weight * patch.elastic;
    moment += patch.weight * patch.elastic * patch.point.rail_y;
  }
  return moment / load;
}

template <Scalar T>
struct Forces {
  Model const& model_;
  Inputs const& inputs_;
  Evaluation& evaluation_;
  Workspace<T>& w_;

  /// Two bodies of the vehicle; a rail and its sleeper lie in one frame.
  bool curved_motion(int a, int b) const {
    return w_.curved && a >= 0 && b >= 0 && model_.bodies[at(b)].in_moving_frame;
  }

  void place_track(T const& t) const {
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

  void apply_weight(std::size_t b) const {
    Body const& body = model_.bodies[b];
    double const weight = body.mass * model_.gravity;
    w_.wrench[b] = {};
    w_.wrench[b].force.z = T(-weight);
    if (!w_.curved) return;
    w_.common_wrench[b] = {};
    if (body.in_moving_frame) w_.wrench[b].force = T(-weight) * w_.frame[b].up;
  }

  /// Bearings and air around a body that spins; what holds them is the ground.
  void apply_loss(std::size_t b) const {
    Body const& body = model_.bodies[b];
    auto const& m = w_.motion[b];
    T const torque = body.loss(m.omega_body.y);
    w_.wrench[b].moment -= torque * m.R.ey;
    w_.power[dissipated_elements] += torque * m.omega_body.y;
  }

  void apply_element(std::size_t index) const {
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
  Vec3<T> moving_frame_wrench(std::size_t b) const {
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
  void apply_inertia(std::size_t b) const {
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

  /// A spot of a roller comes round under each wheel at the same time.
  T distance_along(WheelContact const& contact) const {
    return w_.travel.s + (contact.rail ? contact.distance_ahead : 0.0);
  }

  ContactPlacement<T> placement(std::size_t index) const {
    WheelContact const& contact = model_.contacts[index];
    auto const& wheelset = w_.motion[at(contact.wheelset)];
    bool const displaced = model_.displaces_rails();
    BodyMotion<T> const* under = contact.roller >= 0 ? &w_.motion[at(contact.roller)] : nullptr;
    ContactPlacement<T> p;
    if (contact.rail) {
      TrackFrame<T> const* frame = w_.curved ? &w_.frame[at(contact.wheelset)] : nullptr;
      p = under || frame || displaced ? on_rail(contact, wheelset, under, frame, w_.offset[index], w_.travel.speed)
                                      : on_straight_rail(contact, wheelset, w_.travel.speed);
    } else if (!displaced && model_.bodies[at(contact.roller)].only_spins()) {
      p = on_fixed_roller(contact, wheelset, *under);
    } else {
      p = on_roller(contact, wheelset, *under, displaced ? &w_.offset[index] : nullptr,
                    model_.irregularity && model_.irregularity->steered, w_.travel.speed);
    }
    if (contact.right) mirror(p);
    p.motion.friction_factor = inputs_.friction.empty() ? 1.0 : inputs_.friction[index];
    if (contact.friction.map != nullptr) {
      p.motion.arc_length = w_.travel.s + contact.distance_ahead;
      p.motion.dissipated_energy = inputs_.dissipated_energy.empty() ? 0.0 : inputs_.dissipated_energy[index];
      p.motion.sand = inputs_.sand.empty() ? 0.0 : inputs_.sand[index];
    }
    return p;
  }

  /// The head on which a wheel stands where heads change.
  WheelRollerPair const& head_under(std::size_t index) const {
    WheelContact const& contact = model_.contacts[index];
    RailHeads const& heads = contact.right ? model_.right_heads : model_.left_heads;
    if (heads.empty()) return contact.pair;
    T const place = heads.at(distance_along(contact)).value;
    HeadUnderWheel& head = evaluation_.head[index];
    head.move_to(value_of(place), heads, model_.splines);
    if constexpr (!std::same_as<T, double>) {  // of the derivative over time: the head rises under the load
      double const y = loaded_abscissa(evaluation_.work.patches[index], evaluation_.work.patch_count[index]);
      w_.placed[index].pose.o.z -= (place - value_of(place)) * head.rise(y);
    }
    return head.under(contact.pair);
  }

  /// A surface that changes along its way rises under the wheel: as much for all of its patches.
  void move_head(std::size_t index) const {
    WheelContact const& contact = model_.contacts[index];
    RailHeads const& heads = contact.right ? model_.right_heads : model_.left_heads;
    if (heads.empty()) return;
    T const y = loaded_abscissa(w_.patches[index], w_.patch_count[index]);
    T const up = w_.travel.speed * heads.at(distance_along(contact)).slope * evaluation_.head[index].rise(y);
    w_.placed[index].motion.v_roller.z += up;
    w_.placed[index].prescribed_v_b.z += up;
  }

  /// Patches of all wheels: they are placed first, then each law sees all of them at once.
  void find_patches(T const& t, Selection const* selection) const {
    ContactLaws const& laws = model_.laws;
    bool const with_strips = follows_strips(laws.creep);
    w_.wheels.clear();
    for (std::size_t index = 0; index < model_.contacts.size(); ++index) {
      if (selection && !selection->contact[index]) continue;
      auto& placed = w_.placed[index];
      placed = placement(index);
      WheelContact const& contact = model_.contacts[index];
      w_.wheels.push_back({{head_under(index), laws.material, contact.nodes.get()},
                           &placed.pose,
                           &w_.patches[index],
                           &w_.patch_count[index],
                           with_strips ? &w_.strips[index] : nullptr});
    }
    normal_patches<T, Patch<T>>(laws.normal, w_.wheels);
    w_.under_load.clear();
    for (std::size_t index = 0; index < model_.contacts.size(); ++index) {
      if (selection && !selection->contact[index]) continue;
      move_head(index);
      auto const& placed = w_.placed[index];
      for (int k = 0; k < w_.patch_count[index]; ++k)
        w_.under_load.push_back({&w_.patches[index][at(k)], &placed.pose.o, &placed.motion,
                                 &model_.contacts[index].friction, with_strips ? &w_.strips[index][at(k)] : nullptr});
    }
    add_creep_forces<T>(laws, t, w_.under_load);
  }

  /// What the patches of a wheel do to both bodies.
  void apply_contact(std::size_t index) const {
    WheelContact const& contact = model_.contacts[index];
    auto const& placed = w_.placed[index];
    ContactWrenches<T> sum;  // of all patches
    int const constraint = model_.constraint_of_contact[index];
    for (int k = 0; k < w_.patch_count[index]; ++k) {
      auto const& patch = w_.patches[index][at(k)];
      sum += contact_wrenches(model_.laws.roller, placed, patch.point.p, patch.force, patch.moment);
      w_.power[stored_contacts] -= patch.elastic_power;
      w_.power[dissipated_normal] -= patch.normal.damping * patch.gap_rate;
      w_.power[dissipated_creep] += patch.creep_dissipation();
      if (constraint >= 0)
        w_.axle_creep[at(constraint)] +=
            axle_creep(model_, contact, placed, w_.motion[at(contact.wheelset)].R.ey, patch);
    }
    w_.power[work_of_drive] += prescribed_power(placed, sum);
    BodyWrenches<T> const total = body_wrenches(contact, placed, sum);
    if constexpr (std::same_as<T, double>) evaluation_.longitudinal_force += total.force_F.x;
    auto& wheelset = w_.wrench[at(contact.wheelset)];
    wheelset.force += total.force_F;
    wheelset.moment += total.on_wheelset_F;
    if (contact.roller == ground) return;
    auto& under = w_.wrench[at(contact.roller)];
    under.force -= total.force_F;
    under.moment -= (contact.rail ? placed.R_Fb : w_.motion[at(contact.roller)].R) * total.on_roller_b;
  }

  void apply_contacts(T const& t, Selection const* selection) const {
    if (!w_.patches_given) find_patches(t, selection);
    for (std::size_t i = 0; i < model_.contacts.size(); ++i)
      if (!selection || selection->contact[i]) apply_contact(i);
  }

  /// What holds a motor against the moment it exerts: the reaction body, or for an axle-hung one a vertical force at its link
  /// there and the opposite one on the axle. (A9)
  void apply_reaction(AxleTorque const& torque, Vec3<T> const& moment) const {
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

  void apply_axle_torques(T const& t) const {
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

  void apply_roller_torques(T const& t) const {
    for (std::size_t i = 0; i < model_.roller_torques.size(); ++i) {
      RollerTorque const& torque = model_.roller_torques[i];
      auto const& roller = w_.motion[at(torque.roller)];
      Vec3<T> const moment = -(torque_at(torque.torque, inputs_.roller_torque, i, t) * roller.R.ey);
      w_.wrench[at(torque.roller)].moment += moment;
      w_.power[work_of_drive] += dot(moment, roller.omega);
    }
  }

  void apply_brakes(T const& t) const {
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
  void apply_track_brakes(T const& t) const {
    for (BodyTrackBrake const& own : model_.track_brakes) {
      auto const& m = w_.motion[at(own.body)];
      T const force = inputs_.track_brake.at(t) * own.brake.force(w_.travel.speed + m.v.x);
      w_.wrench[at(own.body)].force.x -= force;
      w_.power[work_of_drive] -= force * m.v.x;
    }
  }

  void apply_resistance() const {
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
  void apply_couplings(Selection const* selection) const {
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

  void accelerate(T const& t, Selection const* selection) const {
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
};

}  // namespace

template <Scalar T>
void ForceAssembly<T>::place_track(T const& t) const {
  Forces<T>{model_, inputs_, evaluation_, w_}.place_track(t);
}
template <Scalar T>
void ForceAssembly<T>::accelerate(T const& t, Selection const* selection) const {
  Forces<T>{model_, inputs_, evaluation_, w_}.accelerate(t, selection);
}

template class ForceAssembly<double>;
template class ForceAssembly<JacobianDual>;

}  // namespace rollerrig
