// system/starting_state.hpp - the state from which a run starts: equilibrium, with the disturbances of the case.
//
//   model -> [without what drives or brakes a train] -> equilibrium -> [disturbances] -> starting state
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/system/model.hpp"

namespace rollerrig {

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

}  // namespace rollerrig
