#include "rollerrig/system/stiff_creep_modes.hpp"

#include <algorithm>
#include <cmath>

namespace rollerrig {
namespace {

constexpr double viscosity_change = 0.05;     // of a viscosity, which asks for new modes [-]
constexpr double least_rate = 20.0;           // no explicit method here is limited in its step by a slower decay [1/s]
constexpr double acceleration_change = 0.02;  // of V', which asks for new modes [m/s^2],
constexpr double speed_change = 1e-3;         // and of V [-]
constexpr double orthogonal = 1e-13;          // off-diagonal of a diagonalised matrix over its diagonal [-]
constexpr int most_jacobi_sweeps = 12;

/// How much force each slip makes: f_11 and f_22 of (22) over the rolling speed, with what saturation leaves of them [N s/m].
///
/// The secant of the creep law, not its slope: it does not vanish on a sliding wheel that is about to stick again.
std::array<double, 2> viscosity(ContactLaws const& laws, Patch<double> const& patch) {
  auto const query = creep_query(laws, patch, patch.creepage, 1.0, 1.0);
  auto const f = std::visit(
      [&](auto const& law) {
        if constexpr (requires { law.stiffness(query); })
          return law.stiffness(query);
        else
          return query.stiffness;
      },
      laws.creep);
  double const v = std::hypot(patch.rolling_speed, laws.creepage_regularisation_speed);
  double const left = patch.weight * patch.creep.saturation / v;
  return {left * f.f11, left * f.f22};
}

}  // namespace

StiffCreepModes::StiffCreepModes(Model const& model)
    : nodes_(model.nodes.size()), rotor_inertia_(model.bodies.size(), 0.0) {
  for (Coupling const& rotor : model.couplings)
    for (CouplingTerm const& c : rotor.term)
      if (c.body >= 0) rotor_inertia_[at(c.body)] += rotor.inertia * c.pitch * c.pitch;
  for (std::size_t i = 0; i < model.contacts.size(); ++i) {
    WheelContact const& contact = model.contacts[i];
    auto group =
        std::find_if(groups_.begin(), groups_.end(), [&](Group const& g) { return g.body[0] == contact.wheelset; });
    if (group == groups_.end()) group = groups_.insert(group, {{contact.wheelset}, {}});
    group->contact.push_back(static_cast<int>(i));
    bool const known = std::count(group->body.begin(), group->body.end(), contact.roller) > 0;
    if (contact.roller != ground && !known && group->body.size() < most_bodies) group->body.push_back(contact.roller);
  }
}

StiffModes StiffCreepModes::room() const {
  std::size_t const slips = groups_.size() * most_slips;
  return {nodes_ + slips, nodes_ + slips * (most_velocities + 1), slips + 2};
}

/// Calls take(contact, patch) for the patches of a group that are looked at; returns the number of their slips, two each.
template <class Take>
std::size_t StiffCreepModes::for_each_slip(Group const& group, Evaluation const& evaluation, Take const& take) {
  std::size_t count = 0;
  for (int c : group.contact)
    for (int k = 0; k < evaluation.patch_count(c) && count + 2 <= most_slips; ++k, count += 2) take(c, k);
  return count;
}

/// Puts V, V' and the viscosities into next.origin; false where they are those of `now`, nearly.
bool StiffCreepModes::look_up_viscosities(Model const& model, Evaluation const& evaluation, StiffModes const& now,
                                          StiffModes& next) const {
  next.clear();
  auto const& travel = evaluation.work.travel;
  bool same = now.origin.size() == groups_.size() * most_slips + 2;
  if (same)
    same = std::fabs(travel.speed - now.origin[0]) <= speed_change * std::fabs(now.origin[0]) &&
           std::fabs(travel.acceleration - now.origin[1]) <= acceleration_change;
  next.origin.push_back(travel.speed);
  next.origin.push_back(travel.acceleration);
  for (Group const& group : groups_) {
    auto const compare = [&](double v) {
      double const before = same ? now.origin[next.origin.size()] : 0.0;
      same = same && std::fabs(v - before) <= viscosity_change * before;
      next.origin.push_back(v);
    };
    std::size_t count = for_each_slip(group, evaluation, [&](int c, int k) {
      for (double v : viscosity(model.laws, evaluation.patch(c, k))) compare(v);
    });
    for (; count < most_slips; ++count) compare(0.0);
  }
  return !same;
}

bool StiffCreepModes::renew(Model const& model, Evaluation const& evaluation, StiffModes const& now,
                            StiffModes& next) const {
  if (!look_up_viscosities(model, evaluation, now, next)) return false;
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    next.begin(model.nodes[i].relaxation_rate(), 0.0);
    next.add(model.map.coordinates + model.map.rates + static_cast<int>(i), 1.0, 1.0);
  }
  std::size_t origin = 2;
  for (Group const& group : groups_) {
    Slips slips;
    std::size_t own = origin;
    origin += most_slips;
    for_each_slip(group, evaluation, [&](int c, int k) {
      for (bool lateral : {false, true})
        if (double const v = next.origin[own++]; v > 0.0) add_slip(model, evaluation, group, c, k, lateral, v, slips);
    });
    add_modes(model, group, slips, next);
  }
  return true;
}

/// Unit force at a patch along or across the rolling direction, times the root of the viscosity: what it is on the velocities
/// of a group, and what accelerations follow.
void StiffCreepModes::add_slip(Model const& model, Evaluation const& evaluation, Group const& group, int contact, int k,
                               bool lateral, double viscosity, Slips& slips) const {
  WheelContact const& own = model.contacts[at(contact)];
  ContactPlacement<double> const& placed = evaluation.work.placed[at(contact)];
  Vec3<double> const& p = evaluation.patch(contact, k).point.p;
  Vec3<double> const& n = evaluation.patch(contact, k).point.n;
  double const across = 1.0 / std::sqrt(n.y * n.y + n.z * n.z);
  Vec3<double> const t{0.0, n.z * across, -n.y * across};
  Vec3<double> const force = std::sqrt(viscosity) * (lateral ? t : cross(t, n));
  auto const sum = contact_wrenches<double>(model.laws.roller, placed, p, force, {});
  double work = prescribed_power(placed, sum);
  BodyWrenches<double> const total = body_wrenches(own, placed, sum);

  auto& d = slips.d[slips.count];
  auto& u = slips.u[slips.count];
  d.fill(0.0);
  u.fill(0.0);
  slips.trend[slips.count] = own.rail ? -total.force_F.x * evaluation.work.travel.acceleration : 0.0;  // it runs at -V
  for (std::size_t i = 0; i < group.body.size(); ++i) {
    int const body = group.body[i];
    auto const& m = evaluation.work.motion[at(body)];
    Wrench<double> wrench{total.force_F, total.on_wheelset_F};
    if (i > 0) {
      if (body != own.roller) continue;
      wrench = {-total.force_F, -((own.rail ? placed.R_Fb : m.R) * total.on_roller_b)};
    }
    if (model.constraint_of_contact[at(contact)] >= 0) {  // the constraint takes this part of all creep out
      wrench.force.x = 0.0;
      wrench.moment -= dot(m.R.ey, wrench.moment) * m.R.ey;
    }
    work -= add_velocities(model, evaluation, body, wrench, &d[6 * i], &u[6 * i]);
  }
  slips.work[slips.count++] = work;
}

/// What a wrench is on the six rates of a body and what accelerations follow, at rest; returns the power of its drive.
double StiffCreepModes::add_velocities(Model const& model, Evaluation const& evaluation, int body,
                                       Wrench<double> const& wrench, double* d, double* u) const {
  auto const& m = evaluation.work.motion[at(body)];
  BodyMotion<double> still = m;
  still.rate.fill(0.0);
  double ignored = 0.0;
  Body with_rotor = model.bodies[at(body)];
  with_rotor.inertia.y += rotor_inertia_[at(body)];
  auto const a = accelerations(with_rotor, still, wrench, {}, 0.0, ignored);
  // Dual to the rates of roll, pitch and yaw: R = Rz Rx Ry.
  Vec3<double> const roll_axis = m.cos_pitch * m.R.ex + m.sin_pitch * m.R.ez;
  std::array<double, 6> const g{
      wrench.force.x, wrench.force.y, wrench.force.z, dot(roll_axis, wrench.moment), dot(m.R.ey, wrench.moment),
      wrench.moment.z};
  for (std::size_t c = 0; c < 6; ++c) {
    d[c] = model.map.rate[at(body)][c] >= 0 ? g[c] : 0.0;
    u[c] = a[c];
  }
  return with_rotor.speed_controlled() ? g[coord_pitch] * m.rate[coord_pitch] : 0.0;
}

/// Eigenvectors (columns of w) of the symmetric (n, n) matrix g by Jacobi's rotations; g becomes diagonal.
void StiffCreepModes::diagonalise(Square& g, Square& w, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) w[i][j] = i == j ? 1.0 : 0.0;
  for (int sweep = 0; sweep < most_jacobi_sweeps; ++sweep) {
    bool turned = false;
    for (std::size_t p = 0; p + 1 < n; ++p)
      for (std::size_t q = p + 1; q < n; ++q) {
        if (!(std::fabs(g[p][q]) > orthogonal * std::sqrt(g[p][p] * g[q][q]))) continue;
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

void StiffCreepModes::add_modes(Model const& model, Group const& group, Slips const& slips, StiffModes& out) const {
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
    double trend = 0.0, work = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      trend += w[i][k] * slips.trend[i];
      work += w[i][k] * slips.work[i];
    }
    out.begin(g[k][k], trend);
    for (std::size_t c = 0; c < velocities; ++c) {
      double d = 0.0, u = 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        d += w[i][k] * slips.d[i][c];
        u += w[i][k] * slips.u[i][c];
      }
      int const state = model.map.rate[at(group.body[c / 6])][c % 6];
      if (state >= 0 && (d != 0.0 || u != 0.0)) out.add(state, d, u / g[k][k]);
    }
    // What moves s is an impulse of the contact, on which the drive of rail or roller works: the audit has to see it.
    if (work != 0.0) out.add(model.map.states() + model.map.angles + work_of_drive, 0.0, work / g[k][k]);
  }
}

}  // namespace rollerrig
