#include "rollerrig/system/statics.hpp"

#include <stdexcept>

#include "rollerrig/math/least_norm.hpp"

namespace rollerrig {

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
