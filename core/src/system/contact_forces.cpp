// Contact forces: where each wheel lies on its rail or roller, its patches, and what they do to both bodies.
#include "rollerrig/system/force_assembly.hpp"

namespace rollerrig {

template <Scalar T>
ContactPlacement<T> ForceAssembly<T>::placement(std::size_t index) const {
  WheelContact const& contact = model_.contacts[index];
  auto const& wheelset = w_.motion[at(contact.wheelset)];
  bool const irregular = !model_.irregularity.empty();
  BodyMotion<T> const* under = contact.roller >= 0 ? &w_.motion[at(contact.roller)] : nullptr;
  ContactPlacement<T> p;
  if (contact.rail) {
    TrackFrame<T> const* frame = w_.curved ? &w_.frame[at(contact.wheelset)] : nullptr;
    p = under || frame || irregular ? on_rail(contact, wheelset, under, frame, w_.offset[index], w_.travel.speed)
                                    : on_straight_rail(contact, wheelset, w_.travel.speed);
  } else if (!irregular && model_.bodies[at(contact.roller)].only_spins()) {
    p = on_fixed_roller(contact, wheelset, *under);
  } else {
    p = on_roller(contact, wheelset, *under, irregular ? &w_.offset[index] : nullptr, model_.irregularity.steered,
                  w_.travel.speed);
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

template <Scalar T>
void ForceAssembly<T>::search_contact(std::size_t index, RelativePose<T> const& pose) const {
  if constexpr (std::same_as<T, double>) {
    if (evaluation_.exhaustive_search)
      evaluation_.search[index].find_all(pose, 0.0);
    else
      evaluation_.search[index].find_indented(pose);
  }
}

/// Patches of the wheels of one group, which have the same laws: all are placed first, then each law sees all of them at once.
template <Scalar T>
void ForceAssembly<T>::find_patches(T const& t, std::vector<int> const& group, Selection const* selection) const {
  ContactLaws const& laws = model_.contacts[at(group.front())].laws;
  w_.wheels.clear();
  for (int i : group) {
    std::size_t const index = at(i);
    if (selection && !selection->contact[index]) continue;
    auto& placed = w_.placed[index];
    placed = placement(index);
    if (follows_minima(laws.normal)) search_contact(index, placed.pose);
    WheelContact const& contact = model_.contacts[index];
    w_.wheels.push_back({{contact.pair, laws.material, contact.laws.nodes.get()},
                         &placed.pose,
                         &evaluation_.search[index],
                         &w_.patches[index],
                         &w_.patch_count[index]});
  }
  normal_patches<T, Patch<T>>(laws.normal, w_.wheels);
  w_.under_load.clear();
  for (int i : group) {
    std::size_t const index = at(i);
    if (selection && !selection->contact[index]) continue;
    auto const& placed = w_.placed[index];
    for (int k = 0; k < w_.patch_count[index]; ++k)
      w_.under_load.push_back(
          {&w_.patches[index][at(k)], &placed.pose.o, &placed.motion, &model_.contacts[index].laws.friction});
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
template void ForceAssembly<double>::search_contact(std::size_t, RelativePose<double> const&) const;
template void ForceAssembly<double>::apply_contacts(double const&, Selection const*) const;
template void ForceAssembly<JacobianDual>::apply_contacts(JacobianDual const&, Selection const*) const;

}  // namespace rollerrig
