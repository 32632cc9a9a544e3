// contact/creep/strip_theory.hpp - creep forces strip by strip: each with its own normal, creepages, spin and friction limit.
//
//     strips of the patch, rigid motion -> [strip_wrench] -> force and moment;   F = F_strips + g (F_table - F_ellipse)
//
// A strip along rolling has the linear theory's traction, Kalker's coefficients of the equivalent ellipse over its share of the
// area, limited by its own pressure at three places along it. The spin of a strip acts where traction has grown, ahead
// of the place, as long as it sticks, and at the place itself where it slides. What this leaves out is known on the
// equivalent ellipse, in its plane and under its mean creepages: there the table has the exact theory. (C17)-(C21) of
// docs/theory/creep_laws.md.
// A patch without strips is its ellipse: then the law is that of the table, within the table's a/b.
//
// Source  Kalker, A strip theory for rolling with slip and spin, Proc. Kon. Ned. Akad. Wet. B70 (1967); Sichani, Enblom, Berg,
//         An alternative to FASTSIM for tangential solution of the wheel-rail contact, Vehicle System Dynamics 54 (2016), for
//         the strips' stiffness by Kalker's coefficients. The closed form and the correction are our own.
#pragma once
#include "rollerrig/contact/creep/creep_table.hpp"
#include "rollerrig/contact/patch_strips.hpp"
#include "rollerrig/math/vector.hpp"

namespace rollerrig {

namespace strip_theory {

/// Places along the strip over a, from the front, and their parts of the pressure: Gauss' rule for a semi-ellipse.
inline constexpr std::array<double, 3> place{0.70710678118654752, 0.0, -0.70710678118654752}, part{0.25, 0.5, 0.25};
/// Traction there over friction's, per demand: it grows from the front. Mean 1.
inline constexpr std::array<double, 3> growth{4.0 / 9.0, 8.0 / 9.0, 16.0 / 9.0};
/// Middle of what lies ahead of the place, (1 + x)/2, over the mean of that with growth.
inline constexpr std::array<double, 3> ahead = [] {
  std::array<double, 3> middle{};
  double mean = 0.0;
  for (std::size_t k = 0; k < 3; ++k) middle[k] = 0.5 * (1.0 + place[k]), mean += part[k] * growth[k] * middle[k];
  for (double& m : middle) m /= mean;
  return middle;
}();
inline constexpr double sliding = 2.5;   ///< demand at which half of the slip at the place itself counts, about [-]
inline constexpr double rounding = 0.5;  ///< half-width of the passage from stick to slip, over the friction limit [-]
inline constexpr double fading = 0.5;    ///< of the table's correction beyond the table's end, in ln(a/b) [-]

/// An ellipse across rolling: cosine and sine are y/b and the half-length over a; parts of load and area.
inline constexpr std::size_t node_count = 16;
struct EllipseNodes {
  std::array<double, node_count> cosine, sine, load, area;
  EllipseNodes();
};
EllipseNodes const& ellipse_nodes();

template <class L, class T>
L widened(T const& x) {
  if constexpr (std::same_as<L, T>)
    return x;
  else
    return L(x);
}

template <class T, class L>
T sum_of(L const& x) {
  if constexpr (std::same_as<L, T>) {
    return x;
  } else {
    T sum(0.0);
    for (int k = 0; k < lanes_of<L>; ++k) sum += x[k];
    return sum;
  }
}

}  // namespace strip_theory

/// Of one strip: force against its slip over mu N, moment about its normal over mu N a.
template <class T>
struct StripTraction {
  T along, across, moment;
};

/// (C18), (C19)
///
/// @param along, across  what the creepages demand by linear theory, over the friction limit
/// @param spin           demand across of the slip that spin makes a half-length ahead
/// @param lagging        demand across of spin by linear theory
/// @param ratio          stiffness along over that across: where it slides, the traction is against the slip
template <class T>
StripTraction<T> strip_traction(T const& along, T const& across, T const& spin, T const& lagging, T const& ratio) {
  using namespace strip_theory;
  using std::sqrt;
  StripTraction<T> sum{T(0.0), T(0.0), T(0.0)};
  for (std::size_t k = 0; k < place.size(); ++k) {
    double const x = place[k], g = growth[k];
    T const grown = across + ahead[k] * lagging;
    T const sticks = 1.0 / sqrt(1.0 + square(g / sliding) * (along * along + grown * grown));
    T const here = ratio * (across + x * spin);
    T const qx = g * along, qy = g * (here + sticks * (grown - here));
    T const size = sqrt(qx * qx + qy * qy + square(regularisation::demand));
    T const inverse = 1.0 / size, over = size - (1.0 - rounding);
    T const between = 1.0 - (0.25 / rounding) * (over * over * inverse);
    T const limited = part[k] * select(size < 1.0 - rounding, T(1.0), select(size > 1.0 + rounding, inverse, between));
    sum.along += limited * qx;
    sum.across += limited * qy;
    sum.moment += x * (limited * qy);
  }
  return sum;
}

/// What all strips of a patch have in common: linear forces per area and unit of slip over V, of spin per half-length.
template <class T>
struct StripStiffness {
  T along, across, spin, lagging;  ///< [N/m^2]
  T ratio;                         ///< along over across
  T direction;                     ///< of rolling

  explicit StripStiffness(CreepQuery<T> const& query) {
    auto const& f = query.stiffness;
    T const per_area = 1.0 / (pi * query.a * query.b);
    along = per_area * f.f11;
    across = per_area * f.f22;
    spin = query.direction * across;
    lagging = (3.0 * pi / 8.0) * per_area * f.f23 / query.a;
    ratio = f.f11 / f.f22;
    direction = query.direction;
  }
  /// Against the slip [N], [N m].
  ///
  /// @param limit  mu N of the strip [N]
  template <class L>
  StripTraction<L> operator()(Creepage<L> const& e, L const& limit, L const& area, L const& half_length) const {
    using strip_theory::widened;
    L const demand = area / limit, turning = demand * (half_length * e.spin);
    auto const q =
        strip_traction<L>(widened<L>(along) * (demand * e.longitudinal), widened<L>(across) * (demand * e.lateral),
                          widened<L>(spin) * turning, widened<L>(lagging) * turning, widened<L>(ratio));
    return {limit * q.along, limit * q.across, widened<L>(direction) * (limit * half_length * q.moment)};
  }
};

/// The strips of the equivalent ellipse in its plane. (C20)
///
/// @tparam L  as many of its strips at once; T: of several patches at once, one after the other
template <class L, Scalar T>
CreepForce<T> ellipse_force(CreepQuery<T> const& query) {
  using namespace strip_theory;
  auto const& nodes = ellipse_nodes();
  StripStiffness<T> const stiffness(query);
  auto const& e = query.creepage;
  T const whole = pi * query.a * query.b;
  L x(0.0), y(0.0), moment(0.0);
  constexpr std::size_t step = std::same_as<L, T> ? 1 : static_cast<std::size_t>(lanes_of<L>);
  for (std::size_t k = 0; k < node_count; k += step) {
    auto const at = [k](std::array<double, node_count> const& row) {
      if constexpr (step == 1)
        return L(row[k]);
      else
        return loaded<L>(&row[k]);
    };
    L const across = at(nodes.cosine) * widened<L>(query.b), half = at(nodes.sine) * widened<L>(query.a);
    Creepage<L> const own{widened<L>(e.longitudinal) - widened<L>(e.spin) * across, widened<L>(e.lateral),
                          widened<L>(e.spin)};
    auto const t =
        stiffness(own, L(at(nodes.load) * widened<L>(query.adhesion)), L(at(nodes.area) * widened<L>(whole)), half);
    x += t.along;
    y += t.across;
    moment += t.moment - across * t.along;
  }
  return {-sum_of<T>(x), -sum_of<T>(y), -sum_of<T>(moment), T(1.0)};
}

/// Force and moment about a point, frame b.
template <class T>
struct PointWrench {
  Vec3<T> force, moment;
};

/// The strips where they are. (C17)
///
/// @param slip, turning  velocity of the wheel relative to the roller at the point, over the rolling speed [-], and its angular
///                       velocity over that [1/m]
/// @param friction       mu N over the strips' pressures [-]
template <class L, Scalar T>
PointWrench<T> strip_wrench(CreepQuery<T> const& query, PatchStrips<T> const& strips, Vec3<T> const& point,
                            Vec3<T> const& slip, Vec3<T> const& turning, T const& friction) {
  using namespace strip_theory;
  using std::sqrt;
  StripStiffness<T> const stiffness(query);
  auto const wide = [](Vec3<T> const& v) { return Vec3<L>{widened<L>(v.x), widened<L>(v.y), widened<L>(v.z)}; };
  Vec3<L> const from = wide(point), v = wide(slip), omega = wide(turning);
  Vec3<L> force{}, moment{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(strips.count); k += static_cast<std::size_t>(lanes_of<L>)) {
    auto const at = [k](typename PatchStrips<T>::Row const& row) { return loaded<L>(&row[k]); };
    auto const vector = [&](auto const& rows) { return Vec3<L>{at(rows[0]), at(rows[1]), at(rows[2])}; };
    Vec3<L> const n = vector(strips.normal), arm = vector(strips.point) - from;
    L const across = 1.0 / sqrt(n.y * n.y + n.z * n.z);
    Vec3<L> const t{L(0.0), n.z * across, -(n.y * across)};  // as in contact/patch.hpp
    Vec3<L> const i = cross(t, n);
    Vec3<L> const u = v + cross(omega, arm);
    L const limit = widened<L>(friction) * at(strips.force) + regularisation::adhesion;
    auto const q =
        stiffness(Creepage<L>{dot(u, i), dot(u, t), dot(omega, n)}, limit, at(strips.area), at(strips.half_length));
    Vec3<L> const f = q.along * i + q.across * t;
    force -= f;
    moment -= cross(arm, f) + q.moment * n;
  }
  auto const narrow = [](Vec3<L> const& a) { return Vec3<T>{sum_of<T>(a.x), sum_of<T>(a.y), sum_of<T>(a.z)}; };
  return {narrow(force), narrow(moment)};
}

struct StripTheory {
  static constexpr char const* name = "strip_theory";
  static constexpr bool in_lanes = true;
  static constexpr bool follows_strips = true;
  std::shared_ptr<CreepTable const> table{};
  static constexpr auto fields() { return members(Member{"table", &StripTheory::table}); }

  /// How far the table's correction of the strips counts: to the end of its ratios of the axes, then fading. (C21)
  template <Scalar T>
  T correction(CreepQuery<T> const& query) const {
    T const& x = query.log_aspect;
    T const beyond = (1.0 / strip_theory::fading) * (select(x < 0.0, -x, x) - table->log_aspect_end);
    T const t = select(beyond < 0.0, T(0.0), select(beyond > 1.0, T(1.0), beyond));
    return 1.0 - t * t * (3.0 - 2.0 * t);
  }

  /// A patch that is its ellipse.
  template <Scalar T>
  CreepForce<T> operator()(CreepQuery<T> const& query) const {
    auto const exact = table_force(*table, query);
    T const g = correction(query);
    if (!any(g < 1.0)) return exact;
    auto const strips = ellipse_force<T>(query);
    auto const mix = [&](T const& from, T const& to) { return from + g * (to - from); };
    T const tx = mix(strips.longitudinal, exact.longitudinal), ty = mix(strips.lateral, exact.lateral);
    auto const linear = linear_creep_force(query.creepage, query.stiffness);
    T const demanded = regularisation::length(linear.longitudinal, linear.lateral, regularisation::force);
    return never_drives(
        query, CreepForce<T>{tx, ty, mix(strips.spin_moment, exact.spin_moment), saturation(tx, ty, demanded)});
  }
};

}  // namespace rollerrig
