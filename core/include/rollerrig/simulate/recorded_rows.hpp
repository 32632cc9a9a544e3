// simulate/recorded_rows.hpp - what is recorded of one body and of one wheel, in the scalar of the evaluation.
//
//   workspace of an evaluation, or of a sweep of the Jacobian -> [rows] -> recorder; derivatives of the outputs
//
// The columns are those of Recorder::body_fields() and wheel_fields(), in their order.
#pragma once
#include <algorithm>
#include <array>
#include <iterator>
#include <limits>

#include "rollerrig/system/outputs.hpp"

namespace rollerrig {

constexpr std::size_t body_columns = 27, wheel_columns = 18;

/// @param out  body_columns numbers; the pitch of a body whose angle is a quadrature is not known here
template <Scalar T>
void body_row(Model const& model, Workspace<T> const& work, std::size_t b, T* out) {
  auto const& m = work.motion[b];
  for (std::size_t c = 0; c < 6; ++c) {
    out[c] = m.q[c];
    out[6 + c] = m.rate[c];
    out[12 + c] = work.acceleration[b][c];
  }
  out[18] = work.constraint_moment[b];
  Vec3<T> const measured = specific_force(model, work, static_cast<int>(b));
  auto const [rate, acceleration] = inertial_turning(model, work, static_cast<int>(b));
  T const felt[] = {measured.y, measured.z, rate.x, rate.y, rate.z, acceleration.x, acceleration.y, acceleration.z};
  static_assert(19 + std::size(felt) == body_columns);
  std::copy(std::begin(felt), std::end(felt), out + 19);
}

/// Force on a wheel along its rail as it lies without load: Y and Q stay in the plane of the track where a rail rolls or leans.
template <Scalar T>
Vec3<T> track_force(Model const& model, Workspace<T> const& work, std::size_t wheel) {
  WheelContact const& contact = model.contacts[wheel];
  Vec3<T> force{};
  for (int k = 0; k < work.patch_count[wheel]; ++k) force += work.patches[wheel][at(k)].force;
  bool const moves = contact.rail && contact.roller != ground, leans = work.offset[wheel].rolled;
  if (!moves && !leans) return force;
  if (contact.right) force = mirrored(force);
  if (leans) force = work.offset[wheel].lean() * force;
  if (moves) force = work.motion[at(contact.roller)].R * force;
  return contact.right ? mirrored(force) : force;
}

/// @param out  wheel_columns numbers
template <Scalar T>
void wheel_row(Model const& model, Workspace<T> const& work, std::size_t wheel, T* out) {
  WheelContact const& contact = model.contacts[wheel];
  T const side(contact.right ? -1.0 : 1.0);
  int const n = work.patch_count[wheel];
  T load(0.0), creep(0.0), moment(0.0), power(0.0), wear(0.0);
  Vec3<T> const force = track_force(model, work, wheel);
  std::array<T, 7> mean;
  mean.fill(T(0.0));
  for (int k = 0; k < n; ++k) {
    Patch<T> const& p = work.patches[wheel][at(k)];
    T const w = p.normal.total();
    load += w;
    creep += p.creep.longitudinal;
    moment += p.creep.spin_moment;
    power += p.creep_dissipation();
    wear += p.wear_number();
    T const value[] = {p.slip_longitudinal,
                       side * p.slip_lateral,
                       p.creepage.longitudinal,
                       side * p.creepage.lateral,
                       p.rolling_speed,
                       p.point.wheel_s,
                       contact.pair.wheel_radius + contact.pair.wheel->at(p.point.wheel_s).value};
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += w * value[i];
  }
  bool const loaded = load > 0.0;
  for (T& v : mean) v = loaded ? v / load : T(std::numeric_limits<double>::quiet_NaN());
  T const row[] = {T(static_cast<double>(n)),
                   load,
                   force.x,
                   creep,
                   side * force.y,
                   force.z,
                   side * moment,
                   mean[0],
                   mean[1],
                   mean[2],
                   mean[3],
                   mean[4],
                   power,
                   mean[5],
                   mean[6],
                   wear,
                   work.offset[wheel].y.value,
                   work.offset[wheel].z.value};
  static_assert(std::size(row) == wheel_columns);
  std::copy(std::begin(row), std::end(row), out);
}

}  // namespace rollerrig
