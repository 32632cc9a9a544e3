#include "rollerrig/track/line.hpp"

#include <cmath>

namespace rollerrig {
namespace {

// Gauss-Legendre on (0, 1), five points: exact for polynomials of ninth degree. A heading changes by less than 0.1 rad over a
// vehicle, which leaves less than 1e-14 m.
constexpr double node[5] = {0.04691007703066800, 0.23076534494715846, 0.5, 0.76923465505284154, 0.95308992296933200};
constexpr double weight[5] = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444, 0.23931433524968324,
                              0.11846344252809454};

/// Adds the stretch from a to b, which lies in one piece.
void add_stretch(PiecewiseCubic const& curvature, int piece, double a, double b, PlanStep& step) {
  double const from = curvature.primitive(piece, a);
  double const length = b - a;
  double x = 0.0, y = 0.0;
  for (int i = 0; i < 5; ++i) {
    double const heading = step.heading + (curvature.primitive(piece, a + length * node[i]) - from);
    x += weight[i] * std::cos(heading);
    y += weight[i] * std::sin(heading);
  }
  step.x += length * x;
  step.y += length * y;
  step.heading += curvature.primitive(piece, b) - from;
}

}  // namespace

PlanStep plan_step(PiecewiseCubic const& curvature, double s, double distance) {
  PlanStep step;
  double const target = s + distance;
  if (curvature.vanishes(std::min(s, target), std::max(s, target))) {
    step.x = distance;
    return step;
  }
  int piece = curvature.piece_of(s);
  double arc_length = s;
  if (distance >= 0.0) {
    for (; curvature.end_of(piece) < target; ++piece) {
      add_stretch(curvature, piece, arc_length, curvature.end_of(piece), step);
      arc_length = curvature.end_of(piece);
    }
  } else {
    for (; piece >= 0 && curvature.start[static_cast<std::size_t>(piece)] > target; --piece) {
      double const begin = curvature.start[static_cast<std::size_t>(piece)];
      add_stretch(curvature, piece, arc_length, begin, step);
      arc_length = begin;
    }
  }
  add_stretch(curvature, piece, arc_length, target, step);
  return step;
}

}  // namespace rollerrig
