// Contact forces: where each wheel lies on its rail or roller, its patches, and what they do to both bodies.
#include "rollerrig/system/force_assembly.hpp"

namespace rollerrig {

template <Scalar T>
ContactPlacement<T> ForceAssembly<T>::placement(std::size_t index) const {
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
  if (contact.laws.friction.map != nullptr) {
    p.motion.arc_length = w_.travel.s + contact.distance_ahead;
    p.motion.dissipated_energy = inputs_.dissipated_energy.empty() ? 0.0 : inputs_.dissipated_energy[index];
    p.motion.sand = inputs_.sand.empty() ? 0.0 : inputs_.sand[index];
  }
  return p;
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

/// The head on which a wheel stands where heads change.
template <Scalar T>
WheelRollerPair const& ForceAssembly<T>::head_under(std::size_t index) const {
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
template <Scalar T>
void ForceAssembly<T>::move_head(std::size_t index) const {
  WheelContact const& contact = model_.contacts[index];
  RailHeads const& heads = contact.right ? model_.right_heads : model_.left_heads;
  if (heads.empty()) return;
  T const y = loaded_abscissa(w_.patches[index], w_.patch_count[index]);
  T const up = w_.travel.speed * heads.at(distance_along(contact)).slope * evaluation_.head[index].rise(y);
  w_.placed[index].motion.v_roller.z += up;
  w_.placed[index].prescribed_v.z += up;
}

/// Patches of the wheels of one group, which have the same laws: all are placed first, then each law sees all of them at once.
template <Scalar T>
void ForceAssembly<T>::find_patches(T const& t, std::vector<int> const& group, Selection const* selection) const {
  ContactLaws const& laws = model_.contacts[at(group.front())].laws;
  bool const with_strips = follows_strips(laws.creep);
  w_.wheels.clear();
  for (int i : group) {
    std::size_t const index = at(i);
    if (selection && !selection->contact[index]) continue;
    auto& placed = w_.placed[index];
    placed = placement(index);
    WheelContact const& contact = model_.contacts[index];
    w_.wheels.push_back({{head_under(index), laws.material, contact.laws.nodes.get()},
                         &placed.pose,
                         &w_.patches[index],
                         &w_.patch_count[index],
                         with_strips ? &w_.strips[index] : nullptr});
  }
  normal_patches<T, Patch<T>>(laws.normal, w_.wheels);
  w_.under_load.clear();
  for (int i : group) {
    std::size_t const index = at(i);
    if (selection && !selection->contact[index]) continue;
    move_head(index);
    auto const& placed = w_.placed[index];
    for (int k = 0; k < w_.patch_count[index]; ++k)
      w_.under_load.push_back({&w_.patches[index][at(k)], &placed.pose.o, &placed.motion,
                               &model_.contacts[index].laws.friction,
                               with_strips ? &w_.strips[index][at(k)] : nullptr});
  }
  add_creep_forces<T>(laws, t, w_.under_load);
}

/// What the patches of a wheel do to both bodies.
template <Scalar T>
void ForceAssembly<T>::apply_contact(std::size_t index) const {
  WheelContact const& contact = model_.contacts[index];
  auto const& placed = w_.placed[index];
  ContactWrenches<T> sum;  // of all patches, b components
  int const constraint = model_.constraint_of_contact[index];
  for (int k = 0; k < w_.patch_count[index]; ++k) {
    auto const& patch = w_.patches[index][at(k)];
    sum += contact_wrenches(contact.laws.roller, placed, patch.point.p, patch.force, patch.moment);
    w_.power[stored_contacts] -= patch.elastic_power;
    w_.power[dissipated_normal] -= patch.normal.damping * patch.gap_rate;
    w_.power[dissipated_creep] += patch.creep_dissipation();
    if (constraint >= 0)
      w_.axle_creep[at(constraint)] += axle_creep(contact, placed, w_.motion[at(contact.wheelset)].R.ey, patch);
  }
  w_.power[work_of_drive] += prescribed_power(placed, sum);
  sum = in_wheelset_frame(contact, placed, sum);
  if constexpr (std::same_as<T, double>) evaluation_.longitudinal_force += sum.force.x;
  auto& wheelset = w_.wrench[at(contact.wheelset)];
  wheelset.force += sum.force;
  wheelset.moment += sum.on_wheelset;
  if (contact.roller == ground) return;
  auto& under = w_.wrench[at(contact.roller)];
  under.force -= sum.force;
  under.moment -= (contact.rail ? placed.R : w_.motion[at(contact.roller)].R) * sum.on_roller;
}

template <Scalar T>
void ForceAssembly<T>::apply_contacts(T const& t, Selection const* selection) const {
  for (auto const& group : model_.contact_groups) find_patches(t, group, selection);
  for (std::size_t i = 0; i < model_.contacts.size(); ++i)
    if (!selection || selection->contact[i]) apply_contact(i);
}

template ContactPlacement<double> ForceAssembly<double>::placement(std::size_t) const;
template void ForceAssembly<double>::apply_contacts(double const&, Selection const*) const;
template void ForceAssembly<JacobianDual>::apply_contacts(JacobianDual const&, Selection const*) const;

}  // namespace rollerrig
