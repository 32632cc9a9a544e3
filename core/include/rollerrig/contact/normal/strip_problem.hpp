// contact/normal/strip_problem.hpp - two elastic half-spaces pressed together along strips: pressure without assuming an ellipse.
//
//   interpenetration of the undeformed surfaces, strip by strip -> [strip problem] -> line load and half-length per strip
//
// On every strip the pressure is semi-elliptic along x (half-length a, line load w), across the strips it is free. Where a
// strip carries load its middle deflects by the interpenetration d, and the surfaces conform along x, as in Hertz:
//
//     (Q/pi) sum_i w_i K_ji(a_i) = d_j,   w_j >= 0;   q_j = 2 Q w_j / (pi a_j^2),   sum_i q_i S_ji(a_i) = A_j    (S3)-(S5)
//
// K_ji, S_ji: Psi and Chi/4 of contact/normal/strip_kernel.hpp over the width of strip i seen from the middle of strip j.
// Exact where the contact is Hertz'. Solved by a fixed number of passes from a fixed start, Hertz' solution for the parabola
// of the same width and mean depth, so that the result is a plain function of its input: a linear solve for w, an update of
// q and a, and both again. The force is nearly stationary in a.
// Source: our own formulation; Kalker (1990) for the half-space; compared with CONTACT in docs/validation.md.
#pragma once
#include <array>

#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/contact/normal/strip_kernel.hpp"

namespace rollerrig {

/// Regions of strips along one wheel. Within an region strips are equally wide and touch each other.
template <Scalar T>
struct Strips {
  static constexpr int per_region = 20;
  static constexpr int max_regions = 3;
  static constexpr int capacity = per_region * max_regions;

  int regions{0};
  std::array<T, max_regions> width;  ///< of the strips of an region [m]
  std::array<T, max_regions> reach;  ///< width of the overlap over that of all strips of a region, 1 or more [-]
  std::array<T, capacity> position;  ///< of the middle, across the rolling direction along the surfaces [m]
  std::array<T, capacity> offset;    ///< of the middle, along the rolling direction [m]
  std::array<T, capacity> interpenetration;  ///< d [m]; negative: the surfaces are apart
  std::array<T, capacity> curvature;         ///< A, half the sum of both curvatures along x [1/m]
  std::array<T, capacity> load;              ///< w [N/m]; result, not negative
  std::array<T, capacity> half_length;       ///< a [m]; result

  int count() const { return regions * per_region; }
};

/// Fills load and half_length. T: double or StripDual.
template <Scalar T>
void solve_strips(Material const& material, Strips<T>& strips);

}  // namespace rollerrig
