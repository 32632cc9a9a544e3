// system/model_builder.hpp - the one way to make a Model: typed descriptions in, checked once, a constant model out.
//
//   bodies, elements, profiles, contacts, actuators, track -> [ModelBuilder] -> shared_ptr<Model const>
//
// Every index, size and number is checked where it is added; a mistake throws std::invalid_argument that names it. What
// follows from other data (positions of contacts from those of bodies, inner nodes, couplings, tables) is derived here.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "rollerrig/system/model.hpp"

namespace rollerrig {

class ModelBuilder {
 public:
  /// @param gravity  [m/s^2]
  explicit ModelBuilder(double gravity);

  // Each returns the index of what was added.
  int add_body(Body const& body);
  int add_element(ForceElement const& element);
  int add_profile(UniformSpline const& profile);
  int add_contact(ContactDescription const& contact);
  int add_axle_torque(AxleTorque const& torque);
  int add_roller_torque(RollerTorque const& torque);
  int add_brake(AxleBrake const& brake);
  int add_track_brake(BodyTrackBrake const& brake);
  /// The axle whose two wheels stand on one roller rolls on it without slip.
  int add_rolling_constraint(int wheelset);

  /// The friction of a contact by a map, in place of that of its laws.
  void set_adhesion(int contact, std::shared_ptr<AdhesionMap const> const& map);
  void set_resistance(RunningResistance const& resistance);
  void set_speed(TimeTable const& speed);
  /// @param start  arc length of the vehicle's reference point at time 0 [m]
  void set_line(Line const& line, double start = 0.0);
  /// Of the line that was set: where its rails lie.
  void set_rails(RailLayout const& left, RailLayout const& right);
  /// Heads that change along the rails or round the rollers, for contacts whose law looks at the profiles in every call.
  void set_heads(RailHeads const& left, RailHeads const& right);
  void set_irregularity(Irregularity const& irregularity);
  /// @param duration  for which a wheel may be off its roller [s]
  void set_contact_loss_limit(double duration);
  void set_gravity(double gravity);

  /// The model so far. The builder may go on: what it adds later is in the next model only.
  std::shared_ptr<Model const> finish() const;

 private:
  void check_body(int body, std::string const& what, bool may_be_ground = false) const;

  Model model_;
  std::map<double, std::shared_ptr<KalkerTable const>> kalker_;              ///< over Poisson's ratio
  std::map<std::pair<int, double>, std::shared_ptr<GapNodes const>> nodes_;  ///< over wheel profile and size
  std::map<std::pair<int, double>, std::optional<double>> flange_tips_;      ///< likewise [m]
};

/// A model that differs only in the running speed; the tables are shared.
std::shared_ptr<Model const> with_speed(Model const& model, TimeTable const& speed);

/// Throws std::invalid_argument that names what cannot be built.
std::shared_ptr<Model const> model_of(ModelParts const& parts);

}  // namespace rollerrig
