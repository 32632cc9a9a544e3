#include "rollerrig/contact/creep/strip_theory.hpp"

namespace rollerrig::strip_theory {

/// Chebyshev's nodes of the second kind: the area is exact, the load to 1e-5.
EllipseNodes::EllipseNodes() {
  double sum = 0.0;
  for (std::size_t k = 0; k < node_count; ++k) {
    double const angle = (static_cast<double>(k) + 1.0) * pi / (node_count + 1.0);
    cosine[k] = std::cos(angle);
    sine[k] = std::sin(angle);
    area[k] = 2.0 / (node_count + 1.0) * sine[k] * sine[k];
    load[k] = area[k] * sine[k];
    sum += load[k];
  }
  for (double& of_node : load) of_node /= sum;
}

EllipseNodes const& ellipse_nodes() {
  static EllipseNodes const nodes;
  return nodes;
}

}  // namespace rollerrig::strip_theory
