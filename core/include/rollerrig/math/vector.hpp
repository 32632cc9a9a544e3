// math/vector.hpp - three-vectors and rotations for any scalar.
//
// A vector's components are in the frame named where it is declared. The rotation R of a frame B in a frame A holds the axes of
// B in components of A: R * v turns B components into A components, R.transposed_times(v) back.
#pragma once
#include "rollerrig/scalar.hpp"

namespace rollerrig {

template <Scalar T>
struct Vec3 {
  T x{0.0}, y{0.0}, z{0.0};

  friend Vec3 operator+(Vec3 const& a, Vec3 const& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(Vec3 const& a, Vec3 const& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator-(Vec3 const& a) { return {-a.x, -a.y, -a.z}; }
  friend Vec3 operator*(T const& s, Vec3 const& a) { return {s * a.x, s * a.y, s * a.z}; }
  Vec3& operator+=(Vec3 const& b) { return x += b.x, y += b.y, z += b.z, *this; }
  Vec3& operator-=(Vec3 const& b) { return x -= b.x, y -= b.y, z -= b.z, *this; }
};

template <Scalar T>
T dot(Vec3<T> const& a, Vec3<T> const& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <Scalar T>
Vec3<T> cross(Vec3<T> const& a, Vec3<T> const& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// A constant vector (model data) in the scalar of the computation.
template <Scalar T>
Vec3<T> lift(Vec3<double> const& a) {
  return {T(a.x), T(a.y), T(a.z)};
}

/// Rotation matrix, stored as its three columns (the axes of the turned frame).
template <Scalar T>
struct Rotation {
  Vec3<T> ex, ey, ez;

  Vec3<T> operator*(Vec3<T> const& a) const { return a.x * ex + a.y * ey + a.z * ez; }
  Vec3<T> transposed_times(Vec3<T> const& a) const { return {dot(ex, a), dot(ey, a), dot(ez, a)}; }
};

template <Scalar T>
Rotation<T> lift(Rotation<double> const& R) {
  return {lift<T>(R.ex), lift<T>(R.ey), lift<T>(R.ez)};
}

/// R_A^T R_B: the orientation of B seen from A.
template <Scalar T>
Rotation<T> relative(Rotation<T> const& a, Rotation<T> const& b) {
  return {a.transposed_times(b.ex), a.transposed_times(b.ey), a.transposed_times(b.ez)};
}

}  // namespace rollerrig
