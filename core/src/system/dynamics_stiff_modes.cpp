// Along which directions creep forces and dampers' inner nodes make the states relax: docs/theory/time_integration.md, (T7).
#include <algorithm>
#include <cmath>

#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr std::size_t most_slips = 8;  // of one wheelset: two for each of four patches
constexpr double renewal = 0.05;       // change of a viscosity that asks for new directions [-]
constexpr double least_rate = 20.0;    // slower than this no method minds [1/s]
constexpr double drift_change = 0.02;  // of V' [m/s^2],
constexpr double speed_change = 1e-3;  // and of V that ask for new directions [-]

using Square = std::array<std::array<double, most_slips>, most_slips>;

/// Eigenvectors (columns of w) of the symmetric (n, n) matrix g by Jacobi's rotations; g becomes diagonal.
void diagonalise(Square& g, Square& w, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) w[i][j] = i == j ? 1.0 : 0.0;
  for (int sweep = 0; sweep < 12; ++sweep) {
    bool turned = false;
    for (std::size_t p = 0; p + 1 < n; ++p)
      for (std::size_t q = p + 1; q < n; ++q) {
        if (!(std::fabs(g[p][q]) > 1e-13 * std::sqrt(g[p][p] * g[q][q]))) continue;
        turned = true;
        double const theta = 0.5 * (g[q][q] - g[p][p]) / g[p][q];
        double const t = std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
        double const c = 1.0 / std::sqrt(t * t + 1.0);
        double const s = t * c;
        for (std::size_t k = 0; k < n; ++k) {
          double const a = g[k][p], b = g[k][q];
          g[k][p] = c * a - s * b;
          g[k][q] = s * a + c * b;
        }
        for (std::size_t k = 0; k < n; ++k) {
          double const a = g[p][k], b = g[q][k];
          g[p][k] = c * a - s * b;
          g[q][k] = s * a + c * b;
          double const v = w[k][p], u = w[k][q];
          w[k][p] = c * v - s * u;
          w[k][q] = s * v + c * u;
        }
      }
    if (!turned) return;
  }
}

}  // namespace

/// Velocities that the slips of one wheelset consist of.
struct Dynamics::Slips {
  std::size_t count{0};
  std::array<std::array<double, most_velocities>, most_slips> d{};  ///< times the root of its viscosity
  std::array<std::array<double, most_velocities>, most_slips> u{};  ///< M^-1 d
  std::array<double, most_slips> drift{};                           ///< rate of what no state makes: of the rail
  std::array<double, most_slips> work{};                            ///< work of drives on an impulse of one
};

void Dynamics::plan_relaxation() {
  rotor_inertia_.assign(model_->bodies.size(), 0.0);
  for (Coupling const& rotor : model_->couplings)
    for (CouplingTerm const& c : rotor.term)
      if (c.body >= 0) rotor_inertia_[at(c.body)] += rotor.inertia * c.pitch * c.pitch;
  for (std::size_t i = 0; i < model_->contacts.size(); ++i) {
    WheelContact const& contact = model_->contacts[i];
    auto group = std::find_if(creep_groups_.begin(), creep_groups_.end(),
                              [&](CreepGroup const& g) { return g.body[0] == contact.wheelset; });
    if (group == creep_groups_.end()) group = creep_groups_.insert(group, {{contact.wheelset}, {}});
    group->contact.push_back(static_cast<int>(i));
    bool const known = std::count(group->body.begin(), group->body.end(), contact.roller) > 0;
    if (contact.roller != ground && !known && group->body.size() < most_bodies) group->body.push_back(contact.roller);
  }
}

RelaxingDirections Dynamics::relaxing_directions() const {
  std::size_t const nodes = at(map_.nodes);
  std::size_t const groups = creep_groups_.size();
  return {nodes + groups * most_slips, nodes + groups * most_slips * (most_velocities + 1), groups * most_slips + 2};
}

/// How hard each slip is to force: f_11 and f_22 of (22) over the rolling speed, with what saturation leaves of them [N s/m].
///
/// The secant of the creep law, not its slope: it does not vanish on a sliding wheel that is about to stick again.
std::array<double, 2> Dynamics::viscosity(int contact, int k) const {
  ContactLaws const& laws = model_->contacts[at(contact)].laws;
  auto const& own = patch(contact, k);
  auto const f = kalker_stiffness(laws.kalker->at(own.log_aspect), laws.material.shear_modulus, own.a, own.b, 1.0);
  double const v = std::hypot(own.rolling_speed, laws.creepage_regularisation_speed);
  double const left = own.weight * own.creep.saturation / v;
  return {left * f.f11, left * f.f22};
}

/// Unit force at a patch along `direction` (b, mirrored like the patch): what it is on the velocities of a group, and what
/// accelerations follow.
void Dynamics::add_slip(CreepGroup const& group, int contact, int k, ContactPlacement<double> const& placed,
                        bool lateral, double viscosity, Slips& slips) const {
  WheelContact const& model = model_->contacts[at(contact)];
  Patch<double> unit;
  unit.point = patch(contact, k).point;
  Vec3<double> const& n = unit.point.n;
  double const across = 1.0 / std::sqrt(n.y * n.y + n.z * n.z);
  Vec3<double> const t{0.0, n.z * across, -n.y * across};
  unit.force = std::sqrt(viscosity) * (lateral ? t : cross(t, n));
  unit.moment = {};
  Vec3<double> force = unit.force;
  Vec3<double> on_wheelset = cross(unit.point.p - placed.pose.o, unit.force);
  Vec3<double> on_roller = moment_about_crown(model.laws.roller, unit);
  double work = 0.0;
  if (placed.prescribed)
    work = placed.turned ? dot(force, placed.prescribed_v) + dot(on_roller, placed.prescribed_omega)
                         : force.x * placed.prescribed_v.x;
  if (model.right) {
    force = mirrored(force);
    on_wheelset = mirrored_axial(on_wheelset);
    on_roller = mirrored_axial(on_roller);
  }
  on_roller += cross(model.crown_in_roller, force);
  if (placed.turned) {
    force = placed.R * force;
    on_wheelset = placed.R * on_wheelset;
  }
  auto& d = slips.d[slips.count];
  auto& u = slips.u[slips.count];
  slips.drift[slips.count] = model.rail ? -force.x * work_.travel.acceleration : 0.0;  // the rail runs at -V
  d.fill(0.0);
  u.fill(0.0);
  for (std::size_t i = 0; i < group.body.size(); ++i) {
    auto const b = at(group.body[i]);
    auto const& m = work_.motion[b];
    Wrench<double> wrench{force, on_wheelset};
    if (i > 0) {
      if (group.body[i] != model.roller) continue;
      wrench = {-force, model.rail ? Vec3<double>{} : -(m.R * on_roller)};
    }
    if (model_->constraint_of_contact[at(contact)] >= 0) {  // the constraint takes this part of all creep out
      wrench.force.x = 0.0;
      wrench.moment -= dot(m.R.ey, wrench.moment) * m.R.ey;
    }
    BodyMotion<double> still = m;
    still.rate.fill(0.0);
    double ignored = 0.0;
    Body body = model_->bodies[b];
    body.inertia.y += rotor_inertia_[b];
    auto const a = accelerations(body, still, wrench, {}, 0.0, ignored);
    // Dual to the rates of roll, pitch and yaw: R = Rz Rx Ry.
    Vec3<double> const roll_axis = m.cos_pitch * m.R.ex + m.sin_pitch * m.R.ez;
    std::array<double, 6> const g{
        wrench.force.x, wrench.force.y, wrench.force.z, dot(roll_axis, wrench.moment), dot(m.R.ey, wrench.moment),
        wrench.moment.z};
    for (std::size_t c = 0; c < 6; ++c) {
      d[6 * i + c] = map_.rate[b][c] >= 0 ? g[c] : 0.0;
      u[6 * i + c] = a[c];
    }
    if (model_->bodies[b].speed_controlled()) work -= g[coord_pitch] * m.rate[coord_pitch];
  }
  slips.work[slips.count++] = work;
}

/// D = sum of viscosity d d^T brakes the velocities, v' = -M^-1 D v: its eigenvectors, orthogonal with respect to M.
bool Dynamics::renew_relaxing_directions(RelaxingDirections const& now, RelaxingDirections& next) const {
  std::array<double, 2> const none{0.0, 0.0};
  auto const slips_of = [&](CreepGroup const& group, auto const& take) {
    std::size_t count = 0;
    for (int c : group.contact)
      for (int k = 0; k < patch_count_[at(c)] && count + 2 <= most_slips; ++k, count += 2) take(c, k);
    return count;
  };
  next.clear();
  bool same = now.origin.size() == creep_groups_.size() * most_slips + 2;
  auto const travel = work_.travel;
  if (same)
    same = std::fabs(travel.speed - now.origin[0]) <= speed_change * std::fabs(now.origin[0]) &&
           std::fabs(travel.acceleration - now.origin[1]) <= drift_change;
  next.origin.push_back(travel.speed);
  next.origin.push_back(travel.acceleration);
  for (CreepGroup const& group : creep_groups_) {
    auto const take = [&](int c, int k) {
      for (double v : viscosity(c, k)) {
        double const before = same ? now.origin[next.origin.size()] : 0.0;
        same = same && std::fabs(v - before) <= renewal * before;
        next.origin.push_back(v);
      }
    };
    for (std::size_t count = slips_of(group, take); count < most_slips; count += 2)
      for (double v : none) {
        same = same && now.origin[next.origin.size()] == 0.0;
        next.origin.push_back(v);
      }
  }
  if (same) return false;

  for (int i = 0; i < map_.nodes; ++i) {
    next.begin(relaxation_rate_[at(i)], 0.0);
    next.add(map_.coordinates + map_.rates + i, 1.0, 1.0);
  }
  std::size_t origin = 2;
  for (CreepGroup const& group : creep_groups_) {
    Slips slips;
    std::size_t own = origin;
    origin += most_slips;
    int placed_contact = -1;
    ContactPlacement<double> placed;
    slips_of(group, [&](int c, int k) {
      if (placed_contact != c) placed = placement(c, work_);
      placed_contact = c;
      for (bool lateral : {false, true})
        if (double const v = next.origin[own++]; v > 0.0) add_slip(group, c, k, placed, lateral, v, slips);
    });
    add_directions(group, slips, next);
  }
  return true;
}

void Dynamics::add_directions(CreepGroup const& group, Slips const& slips, RelaxingDirections& out) const {
  std::size_t const n = slips.count;
  std::size_t const velocities = 6 * group.body.size();
  Square g, w;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = 0.0;
      for (std::size_t c = 0; c < velocities; ++c) sum += slips.d[i][c] * slips.u[j][c];
      g[i][j] = g[j][i] = sum;
    }
  diagonalise(g, w, n);
  for (std::size_t k = 0; k < n; ++k) {
    if (!(g[k][k] > least_rate)) continue;
    double drift = 0.0, work = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      drift += w[i][k] * slips.drift[i];
      work += w[i][k] * slips.work[i];
    }
    out.begin(g[k][k], drift);
    for (std::size_t c = 0; c < velocities; ++c) {
      double d = 0.0, u = 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        d += w[i][k] * slips.d[i][c];
        u += w[i][k] * slips.u[i][c];
      }
      int const state = map_.rate[at(group.body[c / 6])][c % 6];
      if (state >= 0 && (d != 0.0 || u != 0.0)) out.add(state, d, u / g[k][k]);
    }
    // What moves s is an impulse of the contact, on which the drive of rail or roller works: the audit has to see it.
    if (work != 0.0) out.add(map_.states() + map_.angles + work_of_drive, 0.0, work / g[k][k]);
  }
}

}  // namespace rollerrig
