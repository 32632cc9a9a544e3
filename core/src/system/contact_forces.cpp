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
  if (contact.laws.friction.map != nullptr) {
    p.motion.arc_length = w_.travel.s + contact.distance_ahead;
    p.motion.dissipated_energy = inputs_.dissipated_energy.empty() ? 0.0 : inputs_.dissipated_energy[index];
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

template <Scalar T>
void ForceAssembly<T>::apply_contact(T const& t, std::size_t index) const {
  WheelContact const& contact = model_.contacts[index];
  auto const placed = placement(index);
  search_contact(index, placed.pose);

  ContactWrenches<T> sum;  // of all patches, b components
  int const constraint = model_.constraint_of_contact[index];
  WheelPatches<T> patches;
  int const count =
      wheel_patches(contact.pair, contact.laws, evaluation_.search[index], placed.pose, placed.motion, t, patches);
  for (int k = 0; k < count; ++k) {
    auto const& patch = patches[at(k)];
    sum += contact_wrenches(contact.laws.roller, placed, patch);
    w_.power[stored_contacts] -= patch.elastic_power;
    w_.power[dissipated_normal] -= patch.normal.damping * patch.gap_rate;
    w_.power[dissipated_creep] += patch.creep_dissipation();
    if (constraint >= 0)
      w_.axle_creep[at(constraint)] += axle_creep(contact, placed, w_.motion[at(contact.wheelset)].R.ey, patch);
    if constexpr (std::same_as<T, double>) evaluation_.patches[index * max_patches + at(k)] = patch;
  }
  w_.power[work_of_drive] += prescribed_power(placed, sum);
  sum = in_wheelset_frame(contact, placed, sum);
  if constexpr (std::same_as<T, double>) {
    evaluation_.patch_count[index] = count;
    evaluation_.longitudinal_force += sum.force.x;
  }
  auto& wheelset = w_.wrench[at(contact.wheelset)];
  wheelset.force += sum.force;
  wheelset.moment += sum.on_wheelset;
  if (contact.roller == ground) return;
  auto& under = w_.wrench[at(contact.roller)];
  under.force -= sum.force;
  if (!contact.rail) under.moment -= w_.motion[at(contact.roller)].R * sum.on_roller;  // a rail does not turn
}

template ContactPlacement<double> ForceAssembly<double>::placement(std::size_t) const;
template void ForceAssembly<double>::search_contact(std::size_t, RelativePose<double> const&) const;
template void ForceAssembly<double>::apply_contact(double const&, std::size_t) const;
template void ForceAssembly<JacobianDual>::apply_contact(JacobianDual const&, std::size_t) const;

}  // namespace rollerrig
