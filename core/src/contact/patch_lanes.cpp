#include "rollerrig/contact/patch.hpp"

#include <algorithm>

#include "rollerrig/math/dual.hpp"

namespace rollerrig {
#if ROLLERRIG_LANES
namespace {

/// Numbers of W patches side by side: what `get` finds in each of them.
template <int W>
struct Beside {
  std::array<MovingPatch<double> const*, at(W)> of;

  template <class Get>
  Lanes<W> number(Get const& get) const {
    return Lanes<W>(typename Lanes<W>::Register([&](auto k) { return get(*of[k]); }));
  }
  template <class Get>
  Vec3<Lanes<W>> vector(Get const& get) const {
    return {number([&](auto const& m) { return get(m).x; }), number([&](auto const& m) { return get(m).y; }),
            number([&](auto const& m) { return get(m).z; })};
  }
};

template <int W>
NormalPatch<Lanes<W>> normal_patch(Beside<W> const& beside) {
  NormalPatch<Lanes<W>> out;
  out.point.p = beside.vector([](auto const& m) { return m.patch->point.p; });
  out.point.n = beside.vector([](auto const& m) { return m.patch->point.n; });
  out.pressure_moment = beside.vector([](auto const& m) { return m.patch->pressure_moment; });
  out.elastic = beside.number([](auto const& m) { return m.patch->elastic; });
  out.a = beside.number([](auto const& m) { return m.patch->a; });
  out.b = beside.number([](auto const& m) { return m.patch->b; });
  out.log_aspect = beside.number([](auto const& m) { return m.patch->log_aspect; });
  out.weight = beside.number([](auto const& m) { return m.patch->weight; });
  out.damper = beside.number([](auto const& m) { return m.patch->damper; });
  return out;
}

template <int W>
ContactMotion<Lanes<W>> motion_of(Beside<W> const& beside) {
  ContactMotion<Lanes<W>> out;
  out.v_wheel = beside.vector([](auto const& m) { return m.motion->v_wheel; });
  out.omega_wheel = beside.vector([](auto const& m) { return m.motion->omega_wheel; });
  out.v_roller = beside.vector([](auto const& m) { return m.motion->v_roller; });
  out.omega_roller = beside.vector([](auto const& m) { return m.motion->omega_roller; });
  return out;
}

}  // namespace

template <int W>
void add_creep_forces_in_lanes(ContactLaws const& laws, double time, std::span<MovingPatch<double> const> patches) {
  Beside<W> beside;
  for (std::size_t k = 0; k < beside.of.size(); ++k) beside.of[k] = &patches[std::min(k, patches.size() - 1)];
  auto const friction = [&](Lanes<W> const& slip) {
    std::array<RailSurface<double>, at(W)> surface;
    for (std::size_t k = 0; k < surface.size(); ++k)
      surface[k] = beside.of[k]->surface(time, slip[static_cast<int>(k)]);
    return side_by_side(surface);
  };
  auto const wheelset = beside.vector([](auto const& m) { return *m.wheelset; });
  auto const forces = one_by_one(patch_forces<Lanes<W>>(laws, normal_patch(beside), wheelset, motion_of(beside),
                                                        friction, patches.front().friction->map != nullptr));
  for (std::size_t k = 0; k < patches.size(); ++k) {
    PatchForces<double>& out = *patches[k].patch;
    out = forces[k];
  }
}
template void add_creep_forces_in_lanes<2>(ContactLaws const&, double, std::span<MovingPatch<double> const>);
template void add_creep_forces_in_lanes<4>(ContactLaws const&, double, std::span<MovingPatch<double> const>);
template void add_creep_forces_in_lanes<8>(ContactLaws const&, double, std::span<MovingPatch<double> const>);
#endif

namespace {

/// What the strips of a patch do beyond those of its equivalent ellipse: force and moment on the wheel, in place.
///
/// Frame b as in contact/patch.hpp. The friction of strips that are turned against the patch has a part along its normal, and
/// moments along the patch: their power and work are booked with creep. (C17), (C22) of docs/theory/creep_laws.md.
template <Scalar T>
void follow_strips(ContactLaws const& laws, T const& time, MovingPatch<T> const& m) {
  using std::sqrt;
  using L = std::conditional_t<std::same_as<T, double>, Lanes<native_lanes>, T>;
  NormalPatch<T> const& patch = *m.patch;
  PatchForces<T>& out = *m.patch;
  Vec3<T> const& n = patch.point.n;
  auto const [i, t] = contact_axes(n);
  Vec3<T> const omega = relative_turning(laws.roller, *m.motion);
  T const inverse_speed = inverse_rolling_speed(laws, out.rolling_speed);

  T const damping = patch.damper * laws.damping.force(out.gap_rate);
  RailSurface<T> const surface =
      m.surface(time, regularisation::length(out.slip_longitudinal, out.slip_lateral, regularisation::slip));
  T const adhesion = surface.friction * normal_force(patch.elastic, damping).total() + regularisation::adhesion;
  auto query = creep_query(laws, patch, out.creepage, adhesion, T(out.rolling_speed * inverse_speed));
  if (m.friction->map != nullptr) query = with_reduced_stiffness(query, mean_reduction(surface));

  Vec3<T> const slip = out.slip_longitudinal * i + out.slip_lateral * t + out.gap_rate * n;
  auto const strips = strip_wrench<L>(query, *m.strips, patch.point.p, inverse_speed * slip, inverse_speed * omega,
                                      T(adhesion / patch.elastic));
  auto const ellipse = ellipse_force<L>(query);
  Vec3<T> const force = patch.weight * (strips.force - ellipse.longitudinal * i - ellipse.lateral * t);
  Vec3<T> moment = patch.weight * (strips.moment - ellipse.spin_moment * n);

  out.creep.longitudinal += dot(force, i);
  out.creep.lateral += dot(force, t);
  T const about_normal = dot(moment, n);
  out.creep.spin_moment += about_normal;
  out.bending_power = dot(force, n) * out.gap_rate + dot(moment, omega) - about_normal * out.spin_rate;
  // Both together are approximations: the moment gives way where they would drive, (C16).
  T const power = -out.creep_dissipation();
  auto const drives = power > 0.0 && !(out.spin_rate * out.spin_rate < square(regularisation::spin));
  T const less = select(drives, power, T(0.0)) / select(drives, out.spin_rate, T(1.0));
  out.creep.spin_moment -= less;
  out.bending_work = inverse_speed * out.bending_power;
  auto const linear = linear_creep_force(query.creepage, query.stiffness);
  out.creep.saturation =
      saturation(out.creep.longitudinal, out.creep.lateral,
                 T(patch.weight * regularisation::length(linear.longitudinal, linear.lateral, regularisation::force)));
  out.force += force;
  out.moment += moment - less * n;
}

}  // namespace

template <Scalar T>
void add_creep_forces(ContactLaws const& laws, T const& time, std::span<MovingPatch<T> const> patches) {
  constexpr std::size_t most = std::same_as<T, double> ? native_lanes : 1;
  for (std::size_t first = 0; first < patches.size(); first += most) {
    auto const some = patches.subspan(first, std::min(most, patches.size() - first));
    // To put patches side by side costs as much as two of them: a register that is half empty does not pay.
    if constexpr (most > 1) {
      if (2 * some.size() > most) {
        add_creep_forces_in_lanes<most>(laws, time, some);
        continue;
      }
    }
    if constexpr (most == 8) {
      if (some.size() > 2) {
        add_creep_forces_in_lanes<4>(laws, time, some);
        continue;
      }
    }
    for (auto const& patch : some) add_creep_force(laws, time, patch);
  }
  for (auto const& patch : patches)
    if (patch.strips && patch.strips->count > 0) follow_strips(laws, time, patch);
}

template void add_creep_forces<double>(ContactLaws const&, double const&, std::span<MovingPatch<double> const>);
template void add_creep_forces<JacobianDual>(ContactLaws const&, JacobianDual const&,
                                             std::span<MovingPatch<JacobianDual> const>);

}  // namespace rollerrig
