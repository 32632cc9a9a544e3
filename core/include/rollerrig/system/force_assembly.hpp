// system/force_assembly.hpp - all forces on all bodies in one state, then Newton and Euler.
//
//   motion of the bodies, track, inputs -> [suspension, contacts, actuators, couplings] -> wrenches -> accelerations
//
// The same code runs in double and in JacobianDual. A sweep of the Jacobian evaluates only what its seeds touch.
#pragma once
#include "rollerrig/math/dual.hpp"
#include "rollerrig/system/contact_placement.hpp"
#include "rollerrig/system/inputs.hpp"
#include "rollerrig/system/workspace.hpp"

namespace rollerrig {

/// Which parts of a model depend on a few states, or on time.
struct Selection {
  std::vector<char> element, contact;
  std::vector<char> body;  ///< its acceleration depends on them
};

/// Where the vehicle's reference point is along the line.
template <Scalar T>
Travel<T> travel_now(Model const& model, Inputs const& inputs, T const& t) {
  if (!inputs.frame_moves) return travel_at(model.speed, model.start, t);
  T const since = t - inputs.speed.time;
  T const speed = inputs.speed.at(t);
  return {inputs.distance + 0.5 * since * (inputs.speed.value + speed), speed, T(inputs.speed.slope)};
}

template <Scalar T>
class ForceAssembly {
 public:
  /// @param evaluation  the one in double; gets its results where T is double
  ForceAssembly(Model const& model, Inputs const& inputs, Evaluation& evaluation, Workspace<T>& work)
      : model_{model}, inputs_{inputs}, evaluation_{evaluation}, w_{work} {}

  /// Where the track has brought everything at this time; knows nothing of the state.
  void place_track(T const& t) const;
  /// The motion of a body as elements between two track frames see it.
  void see_from_common(std::size_t body) const {
    see_from_common_frame(model_.bodies[body], w_.frame[body], w_.travel.speed, w_.motion[body], w_.common[body]);
  }

  /// Everything from the motion to the accelerations; of a selection only what it names.
  void accelerate(T const& t, Selection const* selection = nullptr) const;

 private:
  Model const& model_;
  Inputs const& inputs_;
  Evaluation& evaluation_;
  Workspace<T>& w_;
};

}  // namespace rollerrig
