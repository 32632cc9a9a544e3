#include "rollerrig/system/starting_state.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "rollerrig/system/equilibrium.hpp"
#include "rollerrig/system/model_builder.hpp"

namespace rollerrig {
namespace {

constexpr double set_down_reach = 0.03;        ///< [m]
constexpr double set_down_resolution = 1e-12;  ///< [m]

}  // namespace

std::shared_ptr<Model const> coasting_model(std::shared_ptr<Model const> const& model) {
  RunningResistance const& r = model->resistance;
  bool const resisted = r.constant != 0.0 || r.linear != 0.0 || r.quadratic != 0.0 || r.gradient != 0.0;
  if (!resisted && model->rolling_constraints.empty() && model->track_brakes.empty()) return model;
  ModelParts parts = *model;
  parts.resistance = {};
  parts.rolling_wheelsets.clear();
  parts.track_brakes.clear();
  return model_of(parts);
}

void check_disturbances(std::span<Disturbance const> disturbances, Model const& model) {
  for (auto const& [body, coordinate, offset] : disturbances)
    if (body < 0 || body >= static_cast<int>(model.bodies.size()) || coordinate < 0 || coordinate > 5 ||
        model.map.coordinate[at(body)][at(coordinate)] < 0)
      throw std::invalid_argument("disturbances: there is no such coordinate");
}

StartingState starting_state(std::shared_ptr<Model const> const& model, double t,
                             std::span<Disturbance const> disturbances) {
  check_disturbances(disturbances, *model);
  Dynamics dynamics(coasting_model(model));
  double const speed = model->speed.at(t);
  StateMap const& map = dynamics.map();
  auto rest = solve_equilibrium(dynamics, speed, t);
  StartingState start;
  start.found = rest.converged ? StartingState::ok : StartingState::no_equilibrium;
  start.residual = rest.residual;
  start.rest = start.x = rest.x;
  if (!rest.converged || disturbances.empty()) return start;

  auto const place = [&](int body, int coordinate) { return map.coordinate[at(body)][at(coordinate)]; };
  std::vector<FixedCoordinate> disturbed, all;
  std::set<int> bodies;
  for (auto const& [body, coordinate, offset] : disturbances) {
    disturbed.push_back({body, coordinate, rest.x[at(place(body, coordinate))] + offset});
    bodies.insert(body);
  }
  all = disturbed;
  for (int b = 0; b < static_cast<int>(map.coordinate.size()); ++b)
    for (int c = 0; c < 6 && !bodies.contains(b); ++c)
      if (place(b, c) >= 0) all.push_back({b, c, rest.x[at(place(b, c))]});

  // Far from equilibrium the others may have none: they stay where they were.
  for (auto const* fixed : {&disturbed, &all}) {
    auto const found = solve_equilibrium(dynamics, speed, t, *fixed, rest.x);
    // A wheelset is stood on its rollers to begin with, even where a disturbance lifts it.
    bool const kept = std::ranges::all_of(
        disturbed, [&](auto const& one) { return found.x[at(place(one.body, one.coordinate))] == one.value; });
    if (!found.converged || !kept) continue;
    start.x = found.x;
    return start;
  }
  for (auto const& [body, coordinate, value] : disturbed) {
    start.x[at(place(body, coordinate))] = value;
    if (coordinate == coord_z) bodies.erase(body);
  }
  for (int const body : bodies)
    if (!set_down(dynamics, t, start.x, body, set_down_reach, set_down_resolution)) {
      start.found = StartingState::no_support;
      start.body = body;
      return start;
    }
  return start;
}

}  // namespace rollerrig
