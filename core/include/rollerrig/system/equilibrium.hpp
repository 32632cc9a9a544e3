// system/equilibrium.hpp - how a vehicle stands in its design position, runs steadily, and starts a run.
//
//   masses and load-carrying springs -> [least squares] -> preload of each spring, load of each axle
//   model -> [without what drives or brakes a train] -> equilibrium -> [disturbances of the case] -> starting state
//
// Equilibrium, static and of steady rolling, by Newton's method with the exact Jacobian.
// Unknown: coordinates, wheelset spin rates, inner nodes of dampers. Given: rollers turn (or rails move) at the running
// speed, all other rates are zero. Equations: accelerations and node rates vanish; a vehicle that is free along its track may
// keep up to 10 N of rolling resistance that nothing can balance (it coasts). Where Newton's method leads nowhere the system
// is let run there in heavily damped motion first.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

/// A coordinate kept at a value while the others find their equilibrium.
struct FixedCoordinate {
  int body{0};
  int coordinate{coord_y};
  double value{0.0};  ///< [m or rad]
};

struct Equilibrium {
  bool converged{false};
  int iterations{0};      ///< Jacobians evaluated
  double residual{0.0};   ///< largest unbalanced force [N] or moment [N m]
  std::vector<double> x;  ///< state
};

/// @param speed  running speed [m/s]; may be zero
/// @param t      time at which tables are read [s]
/// @param fixed   coordinates that keep their value
/// @param near   state close to the one looked for, such as that of a neighbouring speed, or the one without the fixed
///               coordinates: Newton's method starts there, with the spins of rolling, and with wheelsets that have fixed
///               coordinates stood on their wheels; empty, or where it leads nowhere: from a first guess
/// @param only_near  Newton's method alone, from that state as it is: continuation takes a smaller step where it leads nowhere
Equilibrium solve_equilibrium(Dynamics& dynamics, double speed, double t,
                              std::vector<FixedCoordinate> const& fixed = {}, std::vector<double> const& near = {},
                              bool only_near = false);

/// Lowers or lifts a body in the state x to where what carries it balances what presses on it, within `reach` [m] and to a
/// `resolution` [m]; whether there is such a place.
bool set_down(Dynamics& dynamics, double t, std::vector<double>& x, int body, double reach, double resolution);

/// A coordinate that a run starts off its equilibrium.
struct Disturbance {
  int body{0};
  int coordinate{coord_y};
  double offset{0.0};

  static constexpr auto fields() {
    using P = Disturbance;
    return members(Member{"body", &P::body, an_index}, Member{"coordinate", &P::coordinate, Range{0.0, 5.0, "0 to 5"}},
                   Member{"offset", &P::offset, "m or rad", "offset from the undisturbed equilibrium"});
  }
};

struct StartingState {
  enum Found { ok, no_equilibrium, no_support } found{ok};
  int body{-1};                     ///< that floats or sinks everywhere within 30 mm of its place
  double residual{0.0};             ///< largest unbalanced force [N] or moment [N m] of the undisturbed equilibrium
  std::vector<double> rest{}, x{};  ///< undisturbed equilibrium, and with the disturbances
};

/// The model whose equilibrium a run starts from: a train starts on level track, coasting, its track brakes lifted, its axles free
/// to slip. The model itself where it is so already.
std::shared_ptr<Model const> coasting_model(std::shared_ptr<Model const> const& model);

/// Throws std::invalid_argument for a coordinate that the model does not have.
void check_disturbances(std::span<Disturbance const> disturbances, Model const& model);

/// Equilibrium at the model's speed at time t [s], with the disturbed coordinates at their offsets.
///
/// Everything else is in equilibrium with the disturbed bodies. Where there is no such equilibrium (on a flange), everything else
/// stays at the undisturbed one, and the disturbed bodies are set down.
StartingState starting_state(std::shared_ptr<Model const> const& model, double t,
                             std::span<Disturbance const> disturbances);

/// A body of a vehicle at rest.
struct StandingBody {
  double mass{0.0};
  Vec3<double> position{};
  bool on_wheels{false};  ///< a wheelset: whatever presses on it, the track carries

  static constexpr auto fields() {
    using P = StandingBody;
    return members(Member{"mass", &P::mass, "kg", "mass", not_negative},
                   Member{"position", &P::position, "m", "position of the centre of mass"},
                   Member{"on_wheels", &P::on_wheels});
  }
};

/// An element that carries load in the design position.
struct LoadSpring {
  int body_a{0}, body_b{0};
  Vec3<double> point{};

  static constexpr auto fields() {
    using P = LoadSpring;
    return members(Member{"body_a", &P::body_a, an_index}, Member{"body_b", &P::body_b, an_index},
                   Member{"point", &P::point, "m", "point of action of its force"});
  }
};

struct StaticLoads {
  std::vector<double> preload;  ///< per spring: vertical force on its body b [N]
  std::vector<double> on_body;  ///< per body: weight and what the springs press on it; of a wheelset the axle load [N]
  double imbalance{0.0};        ///< largest force [N] or moment [N m] that no spring balances
};

/// Preloads that hold the design position: the smallest forces (least squares) for which every body but the wheelsets is in
/// balance, locks ignored.
///
/// Throws std::invalid_argument where a spring names a body that is not there.
StaticLoads static_loads(std::vector<StandingBody> const& bodies, std::vector<LoadSpring> const& springs,
                         double gravity);

}  // namespace rollerrig
