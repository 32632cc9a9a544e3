// contact/normal/oblique_ellipse.hpp - Hertz' ellipse cut into chords that are not along its axes: what strips along the wheel's
// circles have to know of it.
//
//   curvature along the strips, slope and curvature of their middles' line -> [Hertz' ellipse, chord by chord] -> correction
//
// At yaw the ellipse of contact is turned against the wheel's circles. Cut into chords along u, its middles lie on the line
// x = skew y, and every chord has a semi-elliptic pressure: the strips of an upright ellipse with the semi-axes
// half_length and half_width, pushed along u. Strips push each other less the further they are pushed. Solved as if upright,
// they carry the load and lengths of the turned ellipse if their influence is multiplied by two factors and the
// interpenetration is taken less by a parabola: three numbers for depth, curvature along and curvature across, which are
// exact where the gap is a paraboloid. (S11), (S12)
// Source: Johnson, Contact Mechanics (1985), (4.26), for both ellipses; the reduction is our own.
#pragma once
#include "rollerrig/contact/normal/strip_tables.hpp"

namespace rollerrig {

/// A Hertz pressure of one over compliance Q = 1 on an ellipse.
template <class T>
struct EllipseDeflection {
  T depth;                     ///< in its middle [m]
  T curvature_a, curvature_b;  ///< half the second derivative along both axes [1/m]
};

/// Complete elliptic integrals by the arithmetic-geometric mean: six steps for any ratio of the axes up to 10^4.
template <class T>
EllipseDeflection<T> ellipse_deflection(T const& semi_a, T const& semi_b) {
  using std::sqrt;
  auto const swapped = semi_a < semi_b;
  T const a = select(swapped, semi_b, semi_a), b = select(swapped, semi_a, semi_b);
  T const ratio = b / a;
  T const modulus2 = 1.0 - ratio * ratio + 1e-12;
  // sum = (K - E) / (e^2 K)
  T mean(1.0), root = ratio, sum(0.5);
  double power = 0.5;
  for (int i = 0; i < 6; ++i) {
    T const half = 0.5 * (mean - root);
    T const next = 0.5 * (mean + root);
    root = sqrt(mean * root);
    mean = next;
    power *= 2.0;
    sum += power * (half * half) / modulus2;
  }
  T const k = 0.5 * pi / mean;
  T const d = k * sum;
  T const along = (ratio / a) * d;
  T const across = (k - d) / (ratio * a);  // (E / ratio^2 - K) / e^2
  return {b * k, select(swapped, across, along), select(swapped, along, across)};
}

/// What strips along u need of the ellipse of a region.
template <class T>
struct ObliqueEllipse {
  T half_length,
      half_width;           ///< of the chord in its middle, and of the ellipse across the chords, at depth one [m^0.5]
  T skew;                   ///< of the line of the chords' middles: x/y [-]
  T deflection, curvature;  ///< factors of the influence of one strip on another [-]
  T taken;                  ///< interpenetration less by this times the square of the distance from the middle [1/m]
  T pressure_gradient;      ///< Q p0 / half_length at depth one: q of every chord [1/m]
  StripTables::Place<T> place;  ///< ln(A/B) of the upright ellipse
};

/// @param along  half the second derivative of the gap along the strips [1/m]
/// @param skew   x/y of the line of the deepest points of the strips [-]
/// @param across half the second derivative of the gap along that line, over y [1/m]
template <class T>
ObliqueEllipse<T> oblique_ellipse(StripTables const& tables, T const& along, T const& skew, T const& across) {
  using std::log;
  using std::sqrt;
  // The paraboloid along x^2 - 2 mixed x y + ... in its principal axes.
  T const mixed = -(skew * along);
  T const beside = across - skew * mixed;
  T const middle = 0.5 * (along + beside), half = 0.5 * (along - beside);
  T const radius = sqrt(half * half + mixed * mixed + square(T(1e-9 * middle)));
  T const steep = middle + radius, flat = along * across / steep;
  // Square of the cosine between the strips and the steep axis, and sine times cosine.
  T const cosine2 = 0.5 * (1.0 + half / radius), product = 0.5 * (mixed / radius);
  T const sum = steep + flat;
  auto const principal = tables.place(T(log(flat / steep)));
  T const long_axis = sqrt(tables.at(StartFunction::length, principal) / sum);
  T const short_axis = sqrt(tables.at(StartFunction::breadth, principal) / sum);
  auto const turned = ellipse_deflection(long_axis, short_axis);

  ObliqueEllipse<T> out;
  T const long2 = long_axis * long_axis, short2 = short_axis * short_axis;
  T const reach2 = long2 * cosine2 + short2 * (1.0 - cosine2);
  out.half_width = sqrt(reach2);
  out.half_length = long_axis * short_axis / out.half_width;
  out.skew = (short2 - long2) * product / reach2;
  auto const upright = ellipse_deflection(out.half_length, out.half_width);
  out.deflection = turned.depth / upright.depth;
  T const along_turned = turned.curvature_b * cosine2 + turned.curvature_a * (1.0 - cosine2);
  out.curvature = along_turned / upright.curvature_a;
  out.taken = upright.curvature_b * out.deflection / turned.depth - across;
  out.pressure_gradient = 1.0 / (turned.depth * out.half_length);
  out.place = tables.place(T(log(upright.curvature_a / upright.curvature_b)));
  return out;
}

}  // namespace rollerrig
