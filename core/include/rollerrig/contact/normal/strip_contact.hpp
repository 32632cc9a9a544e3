// contact/normal/strip_contact.hpp - the normal contact of wheels with non-elliptical contact patches: elastic strips over
// every interpenetration region.
//
//   poses of the wheels -> interpenetration regions -> strips -> [strip problem] -> patches: force, centre, equivalent ellipse
//
// A region is one patch. Two minima of one region are one patch where the rise between them is deep in the material and two
// where it is not; in between both readings count with smooth blending weights, because the creep forces of one wide patch
// and of two narrow ones differ: (S8) of docs/theory/non_elliptic_contact.md. Where the rise comes up to the surface the two are
// solved by themselves, (S17): region_pieces.hpp.
#pragma once
#include <span>

#include "rollerrig/contact/normal/normal_patch.hpp"
#include "rollerrig/fields.hpp"
#include "rollerrig/math/dual.hpp"
#include "rollerrig/math/lane.hpp"

namespace rollerrig {

/// Seeds: the pose's translation and rotation. All derivatives of a contact go through them.
using StripDual = Dual<6>;

/// A region of strips, or a part of it, as one patch, frame b. Forces act on the wheel. T: a number, a dual one or lanes.
template <class T>
struct StripPatch {
  using N = NumberOf<T>;
  T weight{1.0};         ///< blending weight of this reading of the strips, 0 to 1
  T force;               ///< sum of the strips' forces, whichever their directions [N]
  T normal;              ///< resultant of the pressures [N]
  Vec3<T> direction;     ///< its direction, out of the roller
  Vec3<T> point;         ///< centre of the pressures on the roller [m]
  Vec3<T> moment;        ///< of the pressures about it [N m]: their normals differ
  T wheel_s, rail_y;     ///< centre of the pressures [m]
  T a, b;                ///< ellipse of the same area and the same ratio of the pressures' second moments [m]
  N approach{0.0};       ///< largest interpenetration [m]
  N peak_pressure{0.0};  ///< [Pa]
  N length{0.0};         ///< along the rolling direction [m]
  N width{0.0};          ///< across it, gaps between loaded strips left out [m]

  /// Every number through a function.
  template <class To>
  StripPatch<To> converted(auto const& to) const {
    auto const to3 = [&](Vec3<T> const& v) { return Vec3<To>{to(v.x), to(v.y), to(v.z)}; };
    return {to(weight), to(force), to(normal), to3(direction), to3(point),        to3(moment), to(wheel_s),
            to(rail_y), to(a),     to(b),      to(approach),   to(peak_pressure), to(length),  to(width)};
  }
};

template <Scalar T>
struct StripSolution {
  static constexpr int capacity = GapScan::most_minima;
  int count{0};
  int refined{0};  ///< regions that were solved again with many strips, because a few had not settled
  std::array<StripPatch<T>, capacity> patch;
};

template <Scalar T>
struct StripWheel {
  NormalSetting const* wheel{nullptr};
  RelativePose<T> pose;
  StripSolution<T> found;
  WheelStrips<T>* strips{nullptr};  ///< of the patches found, if asked for
};

/// The contact of several wheels, solved side by side. T: double or StripDual.
///
/// @tparam W  regions that are solved at once, at most; derivatives come one region after the other
template <Scalar T, int W = native_lanes>
void strip_contacts(std::span<StripWheel<T>> wheels);

/// A pose with seeds of its own along its six directions, and the way back to the derivatives it came with.
template <Scalar T>
class SeededPose {
 public:
  explicit SeededPose(RelativePose<T> const& pose) {
    auto const [o, R] = numbers_of(pose);
    // A small turn about x, y, z of b after R.
    auto const turned = [&](Vec3<double> const& e) {
      Vec3<StripDual> out = lift<StripDual>(e);
      out.x.d[4] = e.z, out.x.d[5] = -e.y;
      out.y.d[5] = e.x, out.y.d[3] = -e.z;
      out.z.d[3] = e.y, out.z.d[4] = -e.x;
      return out;
    };
    pose_ = {lift<StripDual>(o), {turned(R.ex), turned(R.ey), turned(R.ez)}};
    pose_.o.x.d[0] = pose_.o.y.d[1] = pose_.o.z.d[2] = 1.0;
    // How the pose given moves along those six: (dR) R^T is the turn.
    auto const turn = [&](auto row, auto column) {
      T sum = (pose.R.ex.*row) * (R.ex.*column);
      sum += (pose.R.ey.*row) * (R.ey.*column);
      sum += (pose.R.ez.*row) * (R.ez.*column);
      return sum;
    };
    motion_ = {pose.o.x,
               pose.o.y,
               pose.o.z,
               turn(&Vec3<T>::z, &Vec3<double>::y),
               turn(&Vec3<T>::x, &Vec3<double>::z),
               turn(&Vec3<T>::y, &Vec3<double>::x)};
  }
  RelativePose<StripDual> const& pose() const { return pose_; }

  T chain(StripDual const& x) const {
    T out(x.value);
    for (int i = 0; i < 6; ++i) out.d += x.d[i] * motion_[at(i)].d;
    return out;
  }
  StripSolution<T> chained(StripSolution<StripDual> const& found) const {
    auto const along = [&](auto const& x) {
      if constexpr (std::same_as<std::remove_cvref_t<decltype(x)>, double>)
        return x;
      else
        return chain(x);
    };
    StripSolution<T> out;
    out.count = found.count;
    out.refined = found.refined;
    for (std::size_t k = 0; k < at(found.count); ++k) out.patch[k] = found.patch[k].template converted<T>(along);
    return out;
  }

 private:
  RelativePose<StripDual> pose_;
  std::array<T, 6> motion_;
};

/// One wheel, for any scalar: with derivatives, by the chain rule over the pose's six directions.
template <Scalar T>
StripSolution<T> strip_contact(NormalSetting const& wheel, RelativePose<T> const& pose,
                               WheelStrips<T>* strips = nullptr) {
  if constexpr (std::same_as<T, double>) {
    StripWheel<double> one{&wheel, pose, {}, strips};
    strip_contacts<double>({&one, 1});
    return one.found;
  } else {
    thread_local WheelStrips<StripDual> seeded_strips;  // scratch
    SeededPose<T> const seeded(pose);
    StripWheel<StripDual> one{&wheel, seeded.pose(), {}, strips ? &seeded_strips : nullptr};
    strip_contacts<StripDual>({&one, 1});
    for (std::size_t k = 0; strips && k < at(one.found.count); ++k)
      convert(seeded_strips[k], (*strips)[k], [&](StripDual const& x) { return seeded.chain(x); });
    return seeded.chained(one.found);
  }
}

/// Elastic strips over everything that overlaps; the creep law works on the equivalent ellipse at the pressures' centre. The
/// wheel has one normal damper (12), which its patches share by their load, so that a patch comes and goes without a step.
/// (S6)-(S9)
struct ElasticStrips {
  static constexpr char const* name = "strips";
  static constexpr auto fields() { return members(); }

  template <Scalar T, std::derived_from<NormalPatch<T>> P>
  void operator()(std::span<NormalContact<T, P> const> contacts) const {
    constexpr std::size_t most = 16;  // at once
    if constexpr (std::same_as<T, double>) {
      thread_local std::array<StripWheel<double>, most> wheels;  // scratch, too large to be set up in every call
      for (; !contacts.empty(); contacts = contacts.subspan(std::min(most, contacts.size()))) {
        std::size_t const n = std::min(most, contacts.size());
        for (std::size_t i = 0; i < n; ++i)
          wheels[i].wheel = &contacts[i].wheel, wheels[i].pose = *contacts[i].pose,
          wheels[i].strips = contacts[i].strips;
        strip_contacts<double>({wheels.data(), n});
        for (std::size_t i = 0; i < n; ++i) *contacts[i].count = put(wheels[i].found, *contacts[i].patches);
      }
    } else {
      for (auto const& c : contacts) *c.count = put(strip_contact(c.wheel, *c.pose, c.strips), *c.patches);
    }
  }

 private:
  template <Scalar T, std::derived_from<NormalPatch<T>> P>
  static int put(StripSolution<T> const& found, PatchList<P>& patches) {
    using std::log;
    auto const n = at(found.count);
    T total(0.0);
    for (std::size_t k = 0; k < n; ++k) total += found.patch[k].weight * found.patch[k].normal;
    for (std::size_t k = 0; k < n; ++k) {
      auto const& strip = found.patch[k];
      NormalPatch<T>& patch = patches[k];
      patch.point = {};
      patch.point.wheel_s = strip.wheel_s;
      patch.point.rail_y = strip.rail_y;
      patch.point.gap = T(-strip.approach);
      patch.point.p = strip.point;
      patch.point.n = strip.direction;
      patch.elastic = strip.normal;
      patch.a = strip.a;
      patch.b = strip.b;
      patch.log_aspect = log(strip.a / strip.b);
      patch.weight = strip.weight;
      patch.damper = strip.normal / total;
      patch.pressure_moment = strip.moment;
      patch.peak_pressure = strip.peak_pressure;
      patch.length = strip.length;
      patch.width = strip.width;
      patch.refined = found.refined > 0;
    }
    return found.count;
  }
};

}  // namespace rollerrig
