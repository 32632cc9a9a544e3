// system/model.hpp - the assembled model: constant data that any number of simulations share.
//
// Nothing here knows whether it is a rig or a track, a wheelset or a vehicle: rollers are bodies, a rail is a contact
// whose surface runs backwards and whose inverse radius is zero; it lies on the ground or is a body on springs.
#pragma once
#include <deque>
#include <memory>
#include <vector>

#include "rollerrig/contact/normal/strip_kernel.hpp"
#include "rollerrig/contact/patch.hpp"
#include "rollerrig/geometry/interpenetration.hpp"
#include "rollerrig/mechatronics/pneumatic_brake.hpp"
#include "rollerrig/multibody/force_element.hpp"
#include "rollerrig/system/links.hpp"
#include "rollerrig/track/irregularity.hpp"
#include "rollerrig/track/line.hpp"

namespace rollerrig {

constexpr int ground = -1;

/// One wheel on one roller or rail.
struct WheelContact {
  int wheelset{0};
  int roller{ground};                  ///< body of the roller or of an elastic rail; ground: a rigid rail
  bool right{false};                   ///< right wheel: mirrored before and after
  bool rail{false};                    ///< the surface runs backwards with the drive speed and does not turn
  double along{0.0};                   ///< design position along the vehicle: the rail is read at s + along [m]
  Vec3<double> wheelset_from_crown{};  ///< design position of the wheelset's centre from the origin of b, world [m]
  Vec3<double> crown_in_roller{};      ///< origin of b from the roller's centre of mass, roller frame [m]
  WheelRollerPair pair{};
  ContactLaws laws{};
};

/// Torque about the axle, positive when it drives forward; reacts on another body or on nothing.
struct AxleTorque {
  int wheelset{0};
  int reaction{ground};
  TimeTable torque{};  ///< [N m]
  /// Of an axle-hung motor: from the axle to the link by which it holds on to the reaction body, along x [m]; 0: a moment.
  double link{0.0};
  double link_on_reaction{0.0};  ///< place of that link from the reaction body's centre of mass, along x [m]
};

/// Torque on a roller about its axle, positive when it drives the wheel forward (turns the roller backwards).
struct RollerTorque {
  int roller{0};
  TimeTable torque{};  ///< [N m]
};

/// A friction brake between an axle and the body that carries its callipers or blocks.
struct AxleBrake {
  int wheelset{0};
  int reaction{ground};
  PneumaticBrake brake{};
};

/// What resists running: Davis' formula on one body, and the gradient on all that travel.
struct RunningResistance {
  int body{ground};       ///< that feels it; ground: nobody
  double constant{0.0};   ///< [N]
  double linear{0.0};     ///< [N s/m]
  double quadratic{0.0};  ///< [N s^2/m^2]
  double gradient{0.0};   ///< positive uphill [-]

  template <Scalar T>
  T force(T const& speed) const {
    return constant + speed * (linear + quadratic * speed);
  }
};

struct Model {
  std::vector<Body> bodies;
  std::vector<ForceElement> elements;
  std::vector<WheelContact> contacts;
  std::vector<AxleTorque> axle_torques;
  std::vector<RollerTorque> roller_torques;
  std::vector<AxleBrake> brakes;
  std::vector<Link> rotors;  ///< geared to axles and rollers
  RunningResistance resistance{};
  TimeTable speed{};                          ///< running speed V(t) [m/s] of driven rollers (crown speed) and of rails
  double start{0.0};                          ///< arc length of the vehicle's reference point at time 0 [m]
  Line line{};                                ///< curves and cant; empty: straight and level
  Irregularity irregularity{};                ///< of the rails, or of what rollers stand for; empty: perfect
  std::vector<double> driven_inverse_radius;  ///< per body: 1/R of a driven roller [1/m], else 0
  double gravity{9.81};                       ///< [m/s^2]
  double contact_loss_limit{0.2};             ///< a wheel may be off its roller for this long [s]

  // Shared tables; a deque keeps their addresses.
  std::deque<UniformSpline> profiles;
  std::deque<KalkerTable> kalker_tables;
  std::deque<AdhesionMap> adhesion_maps;
  std::shared_ptr<HertzTable const> hertz;
  std::shared_ptr<StripKernel const> strip_kernel;
  std::deque<ArcLength> wheel_arcs;
  std::vector<std::shared_ptr<CreepTable const>> creep_tables;  ///< kept for the laws that read them
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

  explicit StateMap(Model const& model);
  int states() const { return coordinates + rates + nodes; }
};

/// Energies that accumulate over a run, in this order behind the angles in z [J].
enum Account : int {
  work_of_drive,        ///< by roller drives, moving rails and the travelling frames
  work_of_torque,       ///< by axle torques
  dissipated_elements,  ///< in suspension dampers
  dissipated_normal,    ///< in the contacts' normal damping
  dissipated_creep,     ///< by creep forces
  dissipated_brakes,    ///< in friction brakes
  stored_contacts,      ///< work done against the contacts' elastic normal force
  account_count
};

}  // namespace rollerrig
