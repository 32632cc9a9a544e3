#include "rollerrig/system/equilibrium.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "rollerrig/math/lu.hpp"

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

StaticLoads static_loads(std::vector<StandingBody> const& bodies, std::vector<LoadSpring> const& springs,
                         double gravity) {
  auto const at = [&](int body) -> std::size_t {
    if (body < 0 || body >= static_cast<int>(bodies.size()))
      throw std::invalid_argument("static loads: a spring names body " + std::to_string(body) + ", which is not there");
    return static_cast<std::size_t>(body);
  };
  std::vector<Eigen::Index> row_of(bodies.size(), -1);
  Eigen::Index rows = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (!bodies[b].on_wheels) row_of[b] = 3 * rows++;

  // Per body: vertical force, moments about x and y of a vertical force at (x, y) from its centre of mass.
  auto const columns = static_cast<Eigen::Index>(springs.size());
  Eigen::MatrixXd balance = Eigen::MatrixXd::Zero(3 * rows, columns);
  Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * rows);
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (row_of[b] >= 0) load[row_of[b]] = bodies[b].mass * gravity;
  for (Eigen::Index k = 0; k < columns; ++k) {
    LoadSpring const& spring = springs[static_cast<std::size_t>(k)];
    for (auto [body, sign] : {std::pair{at(spring.body_b), 1.0}, std::pair{at(spring.body_a), -1.0}}) {
      Eigen::Index const row = row_of[body];
      if (row < 0) continue;
      Vec3<double> const arm = spring.point - bodies[body].position;
      balance(row, k) += sign;
      balance(row + 1, k) += sign * arm.y;
      balance(row + 2, k) -= sign * arm.x;
    }
  }
  Eigen::VectorXd preload = Eigen::VectorXd::Zero(columns);
  if (rows > 0 && columns > 0) {
    preload = LeastNorm(balance).solve(load);
    load -= balance * preload;
  }

  StaticLoads loads{{preload.begin(), preload.end()}, {}, rows > 0 ? load.cwiseAbs().maxCoeff() : 0.0};
  for (StandingBody const& body : bodies) loads.on_body.push_back(body.mass * gravity);
  for (std::size_t k = 0; k < springs.size(); ++k) {
    loads.on_body[at(springs[k].body_b)] -= loads.preload[k];
    loads.on_body[at(springs[k].body_a)] += loads.preload[k];
  }
  return loads;
}

}  // namespace rollerrig
