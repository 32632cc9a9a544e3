#include "rollerrig/system/model_builder.hpp"

namespace rollerrig {

std::shared_ptr<Model const> model_of(ModelParts const& parts) {
  ModelBuilder builder(parts.gravity);
  for (Body const& body : parts.bodies) builder.add_body(body);
  for (ForceElement const& element : parts.elements) builder.add_element(element);
  for (UniformSpline const& profile : parts.profiles) builder.add_profile(profile);
  for (ContactDescription const& contact : parts.described_contacts) builder.add_contact(contact);
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
