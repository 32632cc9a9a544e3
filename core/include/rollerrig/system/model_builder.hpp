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
#include <vector>

#include "rollerrig/system/model.hpp"

namespace rollerrig {

/// Of a model over full scale; nodes lie along a wheel profile in proportion to it.
inline constexpr Range contact_size{1e-3, 1e3, "between 0.001 and 1000"};

/// One wheel on one roller or rail. Where they lie follows from the bodies: the crown is at z = 0, below the wheelset's centre.
struct ContactDescription {
  int wheelset{0};
  int roller{ground};  ///< body of the roller or of an elastic rail; ground: a rigid rail
  double roller_radius{0.0};
  bool right{false};
  int wheel_profile{0}, rail_profile{0};
  double wheel_radius{0.0}, tape_circle_y{0.0}, rail_origin_y{0.0}, size{1.0};
  ContactLaws laws{};  ///< without the tables that follow from them

  static constexpr auto fields() {
    using P = ContactDescription;
    return members(
        Member{"wheelset", &P::wheelset, an_index}, Member{"roller", &P::roller, index_or_none},
        Member{"roller_radius", &P::roller_radius, "m", "radius of the roller at the crown; 0: a rail", not_negative},
        Member{"right", &P::right}, Member{"wheel_profile", &P::wheel_profile, an_index},
        Member{"rail_profile", &P::rail_profile, an_index},
        Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheel at the tape circle", positive},
        Member{"tape_circle_y", &P::tape_circle_y, "m", "lateral position of the tape circle on the wheelset"},
        Member{"rail_origin_y", &P::rail_origin_y, "m",
               "lateral position of the highest point of the left roller or rail"},
        Member{"size", &P::size, "1", "size over a full-scale wheel and rail", contact_size}, Member{"laws", &P::laws});
  }
};

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

/// In the order of the model's indices.
struct ModelParts {
  double gravity{};
  std::vector<Body> bodies{};
  std::vector<ForceElement> elements{};
  std::vector<UniformSpline> profiles{};
  std::vector<ContactDescription> contacts{};
  std::vector<AxleTorque> axle_torques{};
  std::vector<RollerTorque> roller_torques{};
  std::vector<AxleBrake> brakes{};
  std::vector<BodyTrackBrake> track_brakes{};
  std::vector<int> rolling_wheelsets{};  ///< bodies that roll on their rollers without slip
  RunningResistance resistance{};
  TimeTable speed{};
  Line line{};
  double start{};
  std::optional<Irregularity> irregularity{};
  RailHeads left_heads{}, right_heads{};
  double contact_loss_limit{};

  static constexpr auto fields() {
    using P = ModelParts;
    return members(Member{"gravity", &P::gravity, "m/s^2", "acceleration of free fall"}, Member{"bodies", &P::bodies},
                   Member{"elements", &P::elements}, Member{"profiles", &P::profiles}, Member{"contacts", &P::contacts},
                   Member{"axle_torques", &P::axle_torques}, Member{"roller_torques", &P::roller_torques},
                   Member{"brakes", &P::brakes}, Member{"track_brakes", &P::track_brakes},
                   Member{"rolling_wheelsets", &P::rolling_wheelsets, an_index}, Member{"resistance", &P::resistance},
                   Member{"speed", &P::speed, "m/s", "running speed over time"}, Member{"line", &P::line},
                   Member{"start", &P::start, "m", "arc length of the vehicle's reference point at time 0"},
                   Member{"irregularity", &P::irregularity}, Member{"left_heads", &P::left_heads},
                   Member{"right_heads", &P::right_heads},
                   Member{"contact_loss_limit", &P::contact_loss_limit, "s", "duration without contact that ends a run",
                          positive});
  }
};

ModelParts parts_of(Model const& model);

/// Throws std::invalid_argument that names what cannot be built.
std::shared_ptr<Model const> model_of(ModelParts const& parts);

}  // namespace rollerrig
