#include "rollerrig/system/couplings.hpp"

#include "rollerrig/math/lu.hpp"

namespace rollerrig {

Eigen::MatrixXd coupling_matrix(std::vector<Coupling> const& couplings, std::vector<Body> const& bodies) {
  auto const n = static_cast<Eigen::Index>(couplings.size());
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    Coupling const& own = couplings[at(i)];
    if (own.inertia > 0.0) G(i, i) = 1.0 / own.inertia;
    for (Eigen::Index k = 0; k < n; ++k)
      for (CouplingTerm const& a : own.term)
        for (CouplingTerm const& b : couplings[at(k)].term) {
          if (a.body < 0 || a.body != b.body) continue;
          Body const& body = bodies[at(a.body)];
          if (!body.locked[coord_x]) G(i, k) += a.x * b.x / body.mass;
          if (!body.locked[coord_z]) G(i, k) += a.z * b.z / body.mass;
          if (!body.locked[coord_pitch] && !body.speed_controlled()) G(i, k) += a.pitch * b.pitch / body.inertia.y;
        }
  }
  return G.inverse();
}

}  // namespace rollerrig
