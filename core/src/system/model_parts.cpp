#include "rollerrig/system/model_builder.hpp"

#include <algorithm>

namespace rollerrig {
namespace {

/// A contact as it was described, without what the builder derives.
ContactDescription description_of(WheelContact const& contact, std::vector<UniformSpline const*> const& profiles) {
  auto const index = [&](UniformSpline const* profile) {
    return static_cast<int>(std::ranges::find(profiles, profile) - profiles.begin());
  };
  ContactDescription d;
  d.wheelset = contact.wheelset, d.roller = contact.roller, d.right = contact.right;
  d.roller_radius = contact.rail ? 0.0 : contact.roller_radius();
  d.wheel_profile = index(contact.pair.wheel), d.rail_profile = index(contact.pair.rail);
  d.wheel_radius = contact.pair.wheel_radius;
  d.tape_circle_y = contact.pair.tape_circle_y;
  d.rail_origin_y = contact.pair.rail_origin_y;
  d.size = contact.pair.size;
  d.laws = contact.laws;
  d.laws.kalker = nullptr, d.laws.nodes = nullptr;
  return d;
}

}  // namespace

ModelParts parts_of(Model const& model) {
  ModelParts parts;
  std::vector<UniformSpline const*> profiles;
  for (auto const& profile : model.profiles) {
    profiles.push_back(profile.get());
    parts.profiles.push_back(*profile);
  }
  parts.gravity = model.gravity;
  parts.bodies = model.bodies;
  parts.elements = model.elements;
  for (WheelContact const& contact : model.contacts) parts.contacts.push_back(description_of(contact, profiles));
  parts.axle_torques = model.axle_torques;
  parts.roller_torques = model.roller_torques;
  parts.brakes = model.brakes;
  parts.track_brakes = model.track_brakes;
  for (RollingConstraint const& constraint : model.rolling_constraints)
    parts.rolling_wheelsets.push_back(constraint.wheelset);
  parts.resistance = model.resistance;
  parts.speed = model.speed;
  parts.line = model.line, parts.start = model.start;
  if (!model.irregularity.empty()) parts.irregularity = model.irregularity;
  parts.left_heads = model.left_heads, parts.right_heads = model.right_heads;
  parts.contact_loss_limit = model.contact_loss_limit;
  return parts;
}

std::shared_ptr<Model const> model_of(ModelParts const& parts) {
  ModelBuilder builder(parts.gravity);
  for (Body const& body : parts.bodies) builder.add_body(body);
  for (ForceElement const& element : parts.elements) builder.add_element(element);
  for (UniformSpline const& profile : parts.profiles) builder.add_profile(profile);
  for (ContactDescription const& contact : parts.contacts) builder.add_contact(contact);
  for (AxleTorque const& torque : parts.axle_torques) builder.add_axle_torque(torque);
  for (RollerTorque const& torque : parts.roller_torques) builder.add_roller_torque(torque);
  for (AxleBrake const& brake : parts.brakes) builder.add_brake(brake);
  for (BodyTrackBrake const& brake : parts.track_brakes) builder.add_track_brake(brake);
  for (int const wheelset : parts.rolling_wheelsets) builder.add_rolling_constraint(wheelset);
  builder.set_resistance(parts.resistance);
  builder.set_speed(parts.speed);
  if (!parts.line.empty() || parts.start != 0.0) builder.set_line(parts.line, parts.start);
  if (parts.irregularity) builder.set_irregularity(*parts.irregularity);
  builder.set_heads(parts.left_heads, parts.right_heads);
  builder.set_contact_loss_limit(parts.contact_loss_limit);
  return builder.finish();
}

}  // namespace rollerrig
