#include "rollerrig/system/dynamics.hpp"

#include <algorithm>
#include <cmath>

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool rotates(ForceElement const& e) {
  return e.law[coord_roll].active() || e.law[coord_pitch].active() || e.law[coord_yaw].active();
}

/// A roller that can only spin: its frame coincides with the world's.
bool has_fixed_axis(Body const& b) {
  return b.locked[coord_x] && b.locked[coord_y] && b.locked[coord_z] && b.locked[coord_roll] && b.locked[coord_yaw];
}

}  // namespace

Dynamics::Dynamics(std::shared_ptr<Model const> shared) : model_(std::move(shared)), map_(model_->map) {
  Model const& model = *model_;
  resize(work_);
  resize(dual_);
  patches_.resize(model.contacts.size() * max_patches);
  patch_count_.assign(model.contacts.size(), 0);
  off_since_.assign(model.contacts.size(), -1.0);
  element_force_.assign(model.elements.size() * 6, 0.0);
  element_deflection_.assign(model.elements.size() * 6, 0.0);
  for (auto const& e : model.elements) element_rotates_.push_back(rotates(e));
  relaxation_rate_.assign(at(map_.nodes), 0.0);
  for (auto const& e : model.elements)
    for (std::size_t c = 0; c < 6; ++c)
      if (e.node[c] >= 0) relaxation_rate_[at(e.node[c])] = e.law[c].series_stiffness / e.law[c].series_damping;
  for (auto const& c : model.contacts) {
    search_.emplace_back(c.pair);
    // The flange tip is the highest point of the wheel profile on the flange side.
    UniformSpline const& wheel = *c.pair.wheel;
    double tip = wheel.start;
    for (double s = wheel.start; s < 0.0; s += wheel.step)
      if (wheel.at(s).value > wheel.at(tip).value) tip = s;
    flange_tip_.push_back(wheel.at(tip).value > 0.015 * c.pair.size ? tip : wheel.start - 1.0);
    on_rails_ = on_rails_ || c.rail;
    has_adhesion_maps_ = has_adhesion_maps_ || c.laws.friction.map != nullptr;
    foremost_wheel_ = std::max(foremost_wheel_, c.distance_ahead);
  }
  for (auto const& b : model.bodies) {
    rear_ = std::min(rear_, b.position.x);
    front_ = std::max(front_, b.position.x);
  }
  rolling_force_.assign(model.rolling_constraints.size(), 0.0);
  brake_torque_.assign(model.brakes.size(), 0.0);
  evaluated_.assign(at(map_.states()), 0.0);
  plan_sweeps();
  plan_relaxation();
}

template <Scalar T>
void Dynamics::resize(Workspace<T>& w) const {
  std::size_t const n = model_->bodies.size();
  w.motion.resize(n);
  w.wrench.resize(n);
  w.acceleration.resize(n);
  w.constraint_moment.assign(n, T(0.0));
  w.node.assign(at(map_.nodes), T(0.0));
  w.node_rate.assign(at(map_.nodes), T(0.0));
  w.offset.resize(model_->contacts.size());
  w.frame.resize(n);
  w.common.resize(n);
  w.common_wrench.resize(n);
  w.gyroscopic.resize(n);
  w.axle_creep.resize(model_->rolling_constraints.size());
  w.coupling_load.resize(model_->couplings.size());
  update_motion(Body{}, w.ground_motion);
}

void Dynamics::reset_run() {
  counters_ = {};
  failed_contact_ = -1;
  std::fill(off_since_.begin(), off_since_.end(), -1.0);
}

void Dynamics::unpack(double const* x) {
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    auto& m = work_.motion[b];
    for (std::size_t c = 0; c < 6; ++c) {
      int const i = map_.coordinate[b][c];
      int const j = map_.rate[b][c];
      m.q[c] = i >= 0 ? x[i] : 0.0;
      m.rate[c] = j >= 0 ? x[j] : 0.0;
    }
    update_motion(model_->bodies[b], m);
  }
  double const* node = x + map_.coordinates + map_.rates;
  std::copy_n(node, map_.nodes, work_.node.begin());
}

template <Scalar T>
Travel<T> Dynamics::travel_now(T const& t) const {
  if (!inputs.travels) return travel_at(model_->speed, model_->start, t);
  T const since = t - inputs.speed.time;
  T const speed = inputs.speed.at(t);
  return {inputs.distance + 0.5 * since * (inputs.speed.value + speed), speed, T(inputs.speed.slope)};
}

/// Where the track has brought everything at this time; knows nothing of the state.
template <Scalar T>
void Dynamics::place(Workspace<T>& w, T const& t) const {
  Model const& model = *model_;
  bool const has_line = on_rails_ && !model.line.empty();
  if (!has_line && model.irregularity.empty() && !has_adhesion_maps_ && !inputs.travels) {
    w.travel = {T(0.0), model.speed.at(t), T(model.speed.rate(value_of(t)))};
    return;
  }
  w.travel = travel_now(t);
  double const s = value_of(w.travel.s);
  w.curved = has_line && !model.line.straight(s + rear_, s + front_);
  if (w.curved)
    for (std::size_t b = 0; b < model.bodies.size(); ++b)
      w.frame[b] = track_frame(model.line, w.travel, model.bodies[b].position.x);
  if (model.irregularity.empty()) return;
  for (std::size_t i = 0; i < model.contacts.size(); ++i) {
    WheelContact const& contact = model.contacts[i];
    w.offset[i] =
        model.irregularity.at(contact.right, w.travel.s + contact.distance_ahead, model.start + foremost_wheel_);
  }
}

template <Scalar T>
void Dynamics::see_from_common(Workspace<T>& w, int body) const {
  auto const b = at(body);
  see_from_common_frame(model_->bodies[b], w.frame[b], w.travel.speed, w.motion[b], w.common[b]);
}

template <Scalar T>
void Dynamics::apply_element(Workspace<T>& w, int index) {
  ForceElement const& e = model_->elements[at(index)];
  // The ground of an element is the track under the body it holds: its own frame. Two bodies meet in the common one.
  bool const common = w.curved && e.body_a >= 0 && e.body_b >= 0;
  auto const& motion = common ? w.common : w.motion;
  auto& wrench = common ? w.common_wrench : w.wrench;
  auto const& a = e.body_a >= 0 ? motion[at(e.body_a)] : w.ground_motion;
  auto const& b = e.body_b >= 0 ? motion[at(e.body_b)] : w.ground_motion;
  Vec3<double> const origin_a = e.body_a >= 0 ? model_->bodies[at(e.body_a)].position : Vec3<double>{};
  Vec3<double> const origin_b = e.body_b >= 0 ? model_->bodies[at(e.body_b)].position : Vec3<double>{};
  bool const rotational = element_rotates_[at(index)];
  auto const m = element_motion(e, a, b, origin_b - origin_a, rotational);

  std::array<T, 6> f{T(0.0), T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)};
  for (std::size_t c = 0; c < (rotational ? 6U : 3U); ++c) {
    DirectionLaw const& law = e.law[c];
    if (!law.active()) continue;
    int const node = e.node[c];
    auto const out = direction_force(law, m.d[c], m.rate[c], node >= 0 ? w.node[at(node)] : T(0.0));
    f[c] = out.force;
    w.power[dissipated_elements] += out.dissipated;
    if (node >= 0) w.node_rate[at(node)] = out.node_rate;
    if constexpr (std::same_as<T, double>) {
      element_force_[at(index) * 6 + c] = out.force;
      element_deflection_[at(index) * 6 + c] = m.d[c];
    }
  }
  Vec3<T> force = a.R * Vec3<T>{f[0], f[1], f[2]};
  Vec3<T> torque{};
  if (rotational)
    torque = a.R * (f[coord_roll] * m.roll_axis + f[coord_pitch] * m.pitch_axis + f[coord_yaw] * m.yaw_axis);
  if (e.clamped) {
    Vec3<T> const half = T(0.5) * (b.R * Vec3<T>{f[0], f[1], f[2]});
    force = T(0.5) * force + half;
    torque -= cross(m.stretch, half);
  }
  if (e.body_b >= 0) {
    wrench[at(e.body_b)].force += force;
    wrench[at(e.body_b)].moment += cross(m.arm_b, force) + torque;
  }
  if (e.body_a >= 0) {
    wrench[at(e.body_a)].force -= force;
    wrench[at(e.body_a)].moment -= cross(m.arm_a, force) + torque;
  }
}

template <Scalar T>
ContactPlacement<T> Dynamics::placement(int index, Workspace<T> const& w) const {
  WheelContact const& contact = model_->contacts[at(index)];
  auto const& wheelset = w.motion[at(contact.wheelset)];
  bool const irregular = !model_->irregularity.empty();
  BodyMotion<T> const* under = contact.roller >= 0 ? &w.motion[at(contact.roller)] : nullptr;
  ContactPlacement<T> p;
  if (contact.rail) {
    TrackFrame<T> const* frame = w.curved ? &w.frame[at(contact.wheelset)] : nullptr;
    p = under || frame || irregular ? on_rail(contact, wheelset, under, frame, w.offset[at(index)], w.travel.speed)
                                    : on_straight_rail(contact, wheelset, w.travel.speed);
  } else if (!irregular && has_fixed_axis(model_->bodies[at(contact.roller)])) {
    p = on_fixed_roller(contact, wheelset, *under);
  } else {
    p = on_roller(contact, wheelset, *under, irregular ? &w.offset[at(index)] : nullptr, model_->irregularity.steered,
                  w.travel.speed);
  }
  if (contact.right) mirror(p);
  if (contact.laws.friction.map != nullptr) {
    p.motion.arc_length = w.travel.s + contact.distance_ahead;
    p.motion.dissipated_energy = inputs.dissipated_energy.empty() ? 0.0 : inputs.dissipated_energy[at(index)];
  }
  return p;
}

template <Scalar T>
void Dynamics::apply_contact(Workspace<T>& w, T const& t, int index) {
  WheelContact const& contact = model_->contacts[at(index)];
  auto const placed = placement(index, w);
  RelativePose<T> const& pose = placed.pose;
  ContactMotion<T> const& motion = placed.motion;
  ContactSearch& search = search_[at(index)];
  if constexpr (std::same_as<T, double>) {
    if (exhaustive_search)
      search.find_all(pose, 0.0);
    else
      search.find_indented(pose);
  }

  Vec3<T> force{}, on_wheelset{}, on_roller{};  // on_...: moment about the wheelset's centre and about the crown point
  int const constraint = model_->constraint_of_contact[at(index)];
  WheelPatches<T> patches;
  int const count = wheel_patches(contact.pair, contact.laws, search, pose, motion, t, patches);
  if constexpr (std::same_as<T, double>) patch_count_[at(index)] = count;
  for (int k = 0; k < count; ++k) {
    auto const& patch = patches[at(k)];
    force += patch.force;
    on_wheelset += cross(patch.point.p - pose.o, patch.force) + patch.moment;
    on_roller += moment_about_crown(contact.laws.roller, patch);
    w.power[stored_contacts] -= patch.elastic_power;
    w.power[dissipated_normal] -= patch.normal.damping * patch.gap_rate;
    w.power[dissipated_creep] += patch.creep_dissipation();
    if (constraint >= 0)
      w.axle_creep[at(constraint)] += axle_creep(contact, placed, w.motion[at(contact.wheelset)].R.ey, patch);
    if constexpr (std::same_as<T, double>) patches_[at(index * max_patches + k)] = patch;
  }
  // Work of what moves the rail or steers the roller, beside what a state does.
  if (placed.prescribed)
    w.power[work_of_drive] += placed.turned ? dot(force, placed.prescribed_v) + dot(on_roller, placed.prescribed_omega)
                                            : force.x * placed.prescribed_v.x;
  if (contact.right) {
    force = mirrored(force);
    on_wheelset = mirrored_axial(on_wheelset);
    on_roller = mirrored_axial(on_roller);
  }
  Vec3<T> const force_b = force;
  if (placed.turned) {
    force = placed.R * force;
    on_wheelset = placed.R * on_wheelset;
  }
  if constexpr (std::same_as<T, double>) longitudinal_force_ += force.x;
  auto& wheelset = w.wrench[at(contact.wheelset)];
  wheelset.force += force;
  wheelset.moment += on_wheelset;
  if (contact.roller == ground) return;
  auto& under = w.wrench[at(contact.roller)];
  under.force -= force;
  if (contact.rail) return;  // it does not turn
  Vec3<T> const moment = on_roller + cross(lift<T>(contact.crown_in_roller), force_b);
  under.moment -= w.motion[at(contact.roller)].R * moment;
}

/// Force and moment of the elements and of the carrier on a body in a curve; returns the gyroscopic moment. (W4), (W5), (W9)
template <Scalar T>
Vec3<T> Dynamics::moving_frame_wrench(Workspace<T>& w, std::size_t b) const {
  Body const& body = model_->bodies[b];
  auto const& m = w.motion[b];
  auto const& frame = w.frame[b];
  Wrench<T> const common{frame.R.transposed_times(w.common_wrench[b].force),
                         frame.R.transposed_times(w.common_wrench[b].moment)};
  w.wrench[b].force += common.force;
  w.wrench[b].moment += common.moment;
  if (!body.in_moving_frame) return gyroscopic_moment(body, m);
  Vec3<T> const inertial = T(-body.mass) * carrier_acceleration(body, frame, m);
  Vec3<T> const gyroscopic = gyroscopic_moment(body, frame, m);
  w.wrench[b].force += inertial;
  w.power[work_of_drive] +=
      carrier_power(body, frame, w.travel.speed, model_->gravity, m, common, inertial, gyroscopic);
  return gyroscopic;
}

/// Everything that pushes, then Newton and Euler. With a sweep, only what its seeds touch.
template <Scalar T>
void Dynamics::evaluate_forces(Workspace<T>& w, T const& t, Sweep const* sweep) {
  Model const& model = *model_;
  double const acceleration = value_of(w.travel.acceleration);
  auto const wanted_body = [&](std::size_t b) { return !sweep || sweep->affected_body[b]; };

  w.power.fill(T(0.0));
  if constexpr (std::same_as<T, double>) longitudinal_force_ = 0.0;
  for (auto& creep : w.axle_creep) creep = {};
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (!wanted_body(b)) continue;
    w.wrench[b] = {};
    double const weight = model.bodies[b].mass * model.gravity;
    w.wrench[b].force.z = T(-weight);
    if (!w.curved) continue;
    w.common_wrench[b] = {};
    if (model.bodies[b].in_moving_frame) w.wrench[b].force = T(-weight) * w.frame[b].up;
  }
  for (int i = 0; i < static_cast<int>(model.elements.size()); ++i)
    if (!sweep || sweep->touched_element[at(i)]) apply_element(w, i);
  for (int i = 0; i < static_cast<int>(model.contacts.size()); ++i)
    if (!sweep || sweep->touched_contact[at(i)]) apply_contact(w, t, i);
  apply_torques(w, t);
  apply_resistance(w);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (!wanted_body(b)) continue;
    Body const& body = model.bodies[b];
    auto const& m = w.motion[b];
    Vec3<T>& gyroscopic = w.gyroscopic[b];
    if (w.curved) {
      gyroscopic = moving_frame_wrench(w, b);
    } else {
      gyroscopic = gyroscopic_moment(body, m);
      if (on_rails_ && body.in_moving_frame &&
          acceleration != 0.0) {  // the straight track's frame: (W4) is its acceleration
        T const inertia_force = T(-body.mass * acceleration);
        w.wrench[b].force.x += inertia_force;
        w.power[work_of_drive] += inertia_force * m.v.x;
      }
    }
  }
  if (!model.couplings.empty()) apply_couplings(w, sweep);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (!wanted_body(b)) continue;
    Body const& body = model.bodies[b];
    auto const& m = w.motion[b];
    T const pitch(body.prescribed_pitch(acceleration));
    w.acceleration[b] = accelerations(body, m, w.wrench[b], w.gyroscopic[b], pitch, w.constraint_moment[b]);
    if (body.speed_controlled()) w.power[work_of_drive] += w.constraint_moment[b] * w.motion[b].rate[coord_pitch];
  }
}

void Dynamics::evaluate(double t, double const* x) {
  // A step's end is looked at by accept(), the next step's first stage and the Jacobian: evaluated once.
  if (t == evaluated_time_ && std::equal(evaluated_.begin(), evaluated_.end(), x)) return;
  unpack(x);
  place(work_, t);
  if (work_.curved)
    for (int b = 0; b < static_cast<int>(model_->bodies.size()); ++b) see_from_common(work_, b);
  evaluate_forces(work_, t, nullptr);
  evaluated_time_ = t;
  std::copy_n(x, evaluated_.size(), evaluated_.begin());
}

void Dynamics::search_contacts(double t, double const* x) {
  unpack(x);
  place(work_, t);
  forget();
  for (std::size_t i = 0; i < model_->contacts.size(); ++i) {
    auto const pose = placement(static_cast<int>(i), work_).pose;
    if (exhaustive_search)
      search_[i].find_all(pose, 0.0);
    else
      search_[i].find_indented(pose);
  }
}

Status Dynamics::derivative(double t, double const* x, double* x_dot, double* z_dot) {
  evaluate(t, x);
  for (int i = 0; i < map_.coordinates; ++i) x_dot[i] = x[map_.velocity_column[at(i)]];
  for (std::size_t b = 0; b < model_->bodies.size(); ++b)
    for (std::size_t c = 0; c < 6; ++c)
      if (map_.rate[b][c] >= 0) x_dot[map_.rate[b][c]] = work_.acceleration[b][c];
  std::copy_n(work_.node_rate.begin(), map_.nodes, x_dot + map_.coordinates + map_.rates);
  if (z_dot == nullptr) return Status::ok;
  for (std::size_t b = 0; b < model_->bodies.size(); ++b)
    if (map_.angle[b] >= 0) z_dot[map_.angle[b]] = work_.motion[b].rate[coord_pitch];
  std::copy_n(work_.power.begin(), account_count, z_dot + map_.angles);
  return Status::ok;
}

template Travel<double> Dynamics::travel_now(double const&) const;
template ContactPlacement<double> Dynamics::placement(int, Workspace<double> const&) const;
template void Dynamics::place(Workspace<JacobianDual>&, JacobianDual const&) const;
template void Dynamics::see_from_common(Workspace<JacobianDual>&, int) const;
template void Dynamics::evaluate_forces(Workspace<double>&, double const&, Sweep const*);
template void Dynamics::evaluate_forces(Workspace<JacobianDual>&, JacobianDual const&, Sweep const*);

}  // namespace rollerrig
