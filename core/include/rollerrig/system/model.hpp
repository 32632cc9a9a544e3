// system/model.hpp - the assembled model: constant data that any number of runs share, in any number of threads.
//
//   ModelParts: bodies, elements, profiles, contacts, machines, track -> [model_of] -> Model -> Dynamics, equilibrium, recorder
//
// Nothing here knows whether it is a rig or a track, a wheelset or a vehicle: rollers are bodies, a rail is a contact
// whose surface runs backwards and whose inverse radius is zero; it lies on the ground or is a body on springs.
// Every index, size and number of the parts is checked once, in model_of; what follows from them (positions of contacts from
// those of bodies, inner nodes, couplings, tables) is derived there. A copy shares the tables, so that it may outlive the original.
#pragma once
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "rollerrig/contact/patch.hpp"
#include "rollerrig/mechatronics/brakes.hpp"
#include "rollerrig/multibody/force_element.hpp"
#include "rollerrig/system/couplings.hpp"
#include "rollerrig/system/rail_heads.hpp"
#include "rollerrig/track/line.hpp"

namespace rollerrig {

constexpr int ground = -1;

/// Of a model over full scale; nodes lie along a wheel profile in proportion to it.
inline constexpr Range contact_size{1e-3, 1e3, "between 0.001 and 1000"};

/// One wheel on one roller or rail. Where they lie follows from the bodies: the crown is at z = 0, below the wheelset's centre.
struct ContactDescription {
  int wheelset{0};
  int roller{ground};  ///< body of the roller or of an elastic rail; ground: a rigid rail
  double roller_radius{0.0};
  bool right{false};  ///< mirrored before and after
  int wheel_profile{0}, rail_profile{0};
  double wheel_radius{0.0}, tape_circle_y{0.0}, rail_origin_y{0.0}, size{1.0};
  Friction friction{};

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
        Member{"size", &P::size, "1", "size over a full-scale wheel and rail", contact_size},
        Member{"friction", &P::friction});
  }
};

/// The same with what follows from it.
struct WheelContact : ContactDescription {
  bool rail{false};                    ///< the surface runs backwards with the running speed and does not spin
  double distance_ahead{0.0};          ///< of the wheelset from the vehicle's reference point, along the line [m]
  Vec3<double> wheelset_from_crown{};  ///< design position of the wheelset's centre from the origin of b, world [m]
  Vec3<double> crown_in_roller{};      ///< origin of b from the roller's or rail's centre of mass, its frame [m]
  WheelRollerPair pair{};
  std::shared_ptr<GapNodes const> nodes{};  ///< along the wheel
  double flange_tip{0.0};                   ///< wheel abscissa of the highest point on the flange side [m]
};

/// Torque about an axle, positive when it drives forward: of a traction motor, or one that a test prescribes.
struct AxleTorque {
  int wheelset{0};
  int reaction{ground};  ///< body that takes the opposite
  TimeTable torque{};
  double link{0.0}, gear_ratio{1.0}, rotor_inertia{0.0};
  double link_on_reaction{0.0};  ///< x of the link from the reaction body's centre of mass [m]; set by model_of

  static constexpr auto fields() {
    using P = AxleTorque;
    return members(Member{"wheelset", &P::wheelset, an_index}, Member{"reaction", &P::reaction, index_or_none},
                   Member{"torque", &P::torque, "N m", "torque over time, beside that of the inputs"},
                   Member{"link", &P::link, "m",
                          "x of the link by which an axle-hung motor hangs on the reaction body, from the axle; 0: "
                          "the reaction is a moment"},
                   Member{"gear_ratio", &P::gear_ratio, "1",
                          "speed of the rotor over that of the axle; negative: they turn against each other"},
                   Member{"rotor_inertia", &P::rotor_inertia, "kg m^2",
                          "moment of inertia of the rotor about its shaft", not_negative});
  }
};

/// Torque on a roller about its axle, positive when it drives the wheel forward (turns the roller backwards).
struct RollerTorque {
  int roller{0};
  TimeTable torque{};
  double gear_ratio{1.0}, rotor_inertia{0.0};

  static constexpr auto fields() {
    using P = RollerTorque;
    return members(Member{"roller", &P::roller, an_index},
                   Member{"torque", &P::torque, "N m", "torque over time, beside that of the inputs"},
                   Member{"gear_ratio", &P::gear_ratio, "1",
                          "speed of the rotor over that of the axle; negative: they turn against each other"},
                   Member{"rotor_inertia", &P::rotor_inertia, "kg m^2",
                          "moment of inertia of the rotor about its shaft", not_negative});
  }
};

/// A friction brake between an axle and the body that carries its callipers or blocks.
struct AxleBrake {
  int wheelset{0};
  int reaction{ground};
  FrictionBrake brake{};

  static constexpr auto fields() {
    using P = AxleBrake;
    return members(Member{"wheelset", &P::wheelset, an_index}, Member{"reaction", &P::reaction, index_or_none},
                   Member{"brake", &P::brake});
  }
};

/// Running resistance by Davis' formula on one body, and the gradient on all bodies in moving track frames.
struct RunningResistance {
  int body{ground};  ///< on which it acts; ground: on none
  double constant{0.0}, linear{0.0}, quadratic{0.0}, gradient{0.0};

  static constexpr auto fields() {
    using P = RunningResistance;
    return members(Member{"body", &P::body, index_or_none},
                   Member{"constant", &P::constant, "N", "running resistance R = A + B v + C v^2: A"},
                   Member{"linear", &P::linear, "N s/m", "running resistance R = A + B v + C v^2: B"},
                   Member{"quadratic", &P::quadratic, "N s^2/m^2", "running resistance R = A + B v + C v^2: C"},
                   Member{"gradient", &P::gradient, "1", "gradient of the line, positive uphill"});
  }

  template <Scalar T>
  T force(T const& speed) const {
    return constant + speed * (linear + quadratic * speed);
  }
};

/// A track brake on the body that carries its magnets, for a vehicle on rails.
struct BodyTrackBrake {
  int body{0};
  TrackBrake brake{};

  static constexpr auto fields() {
    return members(Member{"body", &BodyTrackBrake::body, an_index}, Member{"brake", &BodyTrackBrake::brake});
  }
};

/// An axle that rolls on its roller without slip: r w = R W, system/contact_placement.hpp.
struct RollingConstraint {
  int wheelset{0}, roller{0};  ///< bodies
  double wheel_radius{0.0};    ///< r, nominal [m]
  double roller_radius{0.0};   ///< R [m]
  double rate{20.0};           ///< 1/tau at which slip that rounding adds up to decays [1/s]
};

/// Where each body's coordinates stand in x = [coordinates, rates, element nodes], and what z holds.
struct StateMap {
  std::vector<std::array<int, 6>> coordinate;  ///< -1: locked, or the cyclic pitch of an axisymmetric body
  std::vector<std::array<int, 6>> rate;        ///< -1: locked
  std::vector<int> angle;                      ///< per body: index in z of its pitch angle, -1: none
  std::vector<int> velocity_column;            ///< per kinematic state: index of its rate
  int coordinates{0};
  int rates{0};
  int nodes{0};
  int angles{0};

  StateMap() = default;
  StateMap(std::vector<Body> const& bodies, std::size_t inner_nodes);
  int states() const { return coordinates + rates + nodes; }
};

/// What a model is made of, in the order of its indices.
struct ModelParts {
  double gravity{9.81};
  std::vector<Body> bodies{};
  std::vector<ForceElement> elements{};
  std::vector<UniformSpline> profiles{};
  ContactLaws laws{};
  std::vector<ContactDescription> described_contacts{};
  std::vector<AxleTorque> axle_torques{};
  std::vector<RollerTorque> roller_torques{};
  std::vector<AxleBrake> brakes{};
  std::vector<BodyTrackBrake> track_brakes{};
  std::vector<int> rolling_wheelsets{};  ///< bodies that roll on their rollers without slip
  RunningResistance resistance{};
  TimeTable speed{};  ///< running speed V(t) [m/s] of speed-controlled rollers (at the crown) and of rails
  Line line{};        ///< curves and cant; empty: straight and level
  double start{};     ///< arc length of the vehicle's reference point at time 0 [m]
  std::optional<Irregularity> irregularity{};  ///< of the rails, or of what rollers stand for; absent: perfect
  RailHeads left_heads{}, right_heads{};       ///< of rails or rollers that change; empty: as the contacts have them
  double contact_loss_limit{0.2};              ///< a wheel may be off its roller for this long [s]

  static constexpr auto fields() {
    using P = ModelParts;
    return members(Member{"gravity", &P::gravity, "m/s^2", "acceleration of free fall", Range{0.0, 1e4, "0 to 1e4"}},
                   Member{"bodies", &P::bodies}, Member{"elements", &P::elements}, Member{"profiles", &P::profiles},
                   Member{"laws", &P::laws}, Member{"contacts", &P::described_contacts},
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

struct Model : ModelParts {
  explicit Model(ModelParts const& parts) : ModelParts(parts) {}

  bool changes_heads() const { return !left_heads.empty() || !right_heads.empty(); }
  /// Whether rails, or the rollers that stand for them, lie elsewhere than the contacts have them, or are others.
  bool displaces_rails() const { return irregularity || (on_rails && line.moves_rails()) || changes_heads(); }

  // Derived by model_of.
  std::vector<WheelContact> contacts;
  std::vector<RollingConstraint> rolling_constraints;
  StateMap map{};
  std::vector<InnerNode> nodes;            ///< of the elements' laws
  bool on_adhesion_map{false};             ///< the contacts' friction depends on their place
  bool on_rails{false};                    ///< some contact is with a rail: the vehicle's frames move
  double rear{0.0}, front{0.0};            ///< x of the last and the first body from the vehicle's reference point [m]
  double foremost_wheel{0.0};              ///< x of it [m]
  std::vector<Coupling> couplings;         ///< geared rotors, then rolling constraints
  std::size_t rotors{0};                   ///< of the couplings
  Eigen::MatrixXd coupling_matrix;         ///< inverse of G, system/couplings.hpp
  std::vector<int> constraint_of_contact;  ///< rolling constraint of the axle; -1: none
  std::vector<std::shared_ptr<UniformSpline const>> splines;  ///< the profiles, what the contacts point to
};

/// Throws std::invalid_argument that names what cannot be built.
std::shared_ptr<Model const> model_of(ModelParts const& parts);

/// A model that differs only in the running speed; the tables are shared.
std::shared_ptr<Model const> with_speed(Model const& model, TimeTable const& speed);

/// Energies that accumulate over a run, in this order behind the angles in z [J].
enum Account : int {
  work_of_drive,        ///< by roller drives, moving rails and the moving track frames
  work_of_torque,       ///< by axle torques
  dissipated_elements,  ///< in suspension dampers
  dissipated_normal,    ///< in the contacts' normal damping
  dissipated_creep,     ///< by creep forces
  dissipated_brakes,    ///< in friction brakes
  stored_contacts,      ///< work done against the contacts' elastic normal force
  account_count
};

}  // namespace rollerrig
