#include "rollerrig/system/links.hpp"

#include <Eigen/LU>

namespace rollerrig {

Eigen::MatrixXd link_matrix(std::vector<Link> const& links, std::vector<Body> const& bodies) {
  auto const n = static_cast<Eigen::Index>(links.size());
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    Link const& link = links[static_cast<std::size_t>(i)];
    if (link.inertia > 0.0) G(i, i) = 1.0 / link.inertia;
    for (Eigen::Index k = 0; k < n; ++k)
      for (LinkArm const& a : link.arm)
        for (LinkArm const& b : links[static_cast<std::size_t>(k)].arm) {
          if (a.body < 0 || a.body != b.body) continue;
          Body const& body = bodies[static_cast<std::size_t>(a.body)];
          if (!body.locked[coord_x]) G(i, k) += a.along * b.along / body.mass;
          if (!body.locked[coord_z]) G(i, k) += a.up * b.up / body.mass;
          if (!body.locked[coord_pitch] && !body.driven) G(i, k) += a.turn * b.turn / body.inertia.y;
        }
  }
  return G.inverse();
}

}  // namespace rollerrig
