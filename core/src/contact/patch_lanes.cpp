#include "rollerrig/contact/patch.hpp"

#include <algorithm>

#include "rollerrig/contact/bent_patch.hpp"
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
