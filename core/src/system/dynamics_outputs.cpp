// What is read off the dynamics at a step's end: whether the model still holds, energies, what an accelerometer feels.
#include <cmath>

#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

Status Dynamics::accept(double t, double const* x) {
  evaluate(t, x);
  for (std::size_t i = 0; i < model_->contacts.size(); ++i) {
    WheelContact const& contact = model_->contacts[i];
    int const n = patch_count_[i];
    ++counters_.checked;
    counters_.several_patches += n > 1;
    failed_contact_ = static_cast<int>(i);
    if (n == 0) {
      ++counters_.lost;
      if (off_since_[i] < 0.0) off_since_[i] = t;
      if (t - off_since_[i] > model_->contact_loss_limit) return Status::contact_lost;
    } else {
      off_since_[i] = -1.0;
    }
    for (int k = 0; k < n; ++k) {
      Patch<double> const& p = patch(static_cast<int>(i), k);
      counters_.limited_curvature += p.limited;
      counters_.faded += p.weight < 1.0;
      counters_.clamped_aspect += !contact.laws.kalker->covers(p.log_aspect);
      counters_.negative_dissipation += p.creep_dissipation() < -1e-6;
      if (k > 0 && std::holds_alternative<HertzEllipses>(contact.laws.normal)) {
        Patch<double> const& left = patch(static_cast<int>(i), k - 1);
        double const distance = std::hypot(p.point.p.y - left.point.p.y, p.point.p.z - left.point.p.z);
        counters_.overlapping += distance < p.b + left.b;
      }
      if (p.point.wheel_s < flange_tip_[i] + 1e-3 * contact.pair.size) return Status::derailed;
      double const edge = 0.5e-3 * contact.pair.size;  // closer than this to the end of a profile counts as off it [m]
      auto const near_edge = [edge](UniformSpline const& c, double y) {
        return y < c.start + edge || y > c.end() - edge;
      };
      if (near_edge(*contact.pair.wheel, p.point.wheel_s) || near_edge(*contact.pair.rail, p.point.rail_y))
        return Status::off_profile;
    }
  }
  failed_contact_ = -1;
  return Status::ok;
}

double Dynamics::kinetic_energy() const {
  double sum = 0.0;
  for (Coupling const& c : model_->couplings)  // a constraint has no inertia
    sum += 0.5 * c.inertia * square(coupling_speed(c, work_.motion));
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    Body const& body = model_->bodies[b];
    auto const& m = work_.motion[b];
    auto const& w = m.omega_body;
    sum += 0.5 * body.mass * dot(m.v, m.v) +
           0.5 * (body.inertia.x * w.x * w.x + body.inertia.y * w.y * w.y + body.inertia.z * w.z * w.z);
  }
  return sum;
}

double Dynamics::gravity_energy() const {
  double sum = 0.0;
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    Body const& body = model_->bodies[b];
    auto const& m = work_.motion[b];
    bool const canted = work_.curved && body.in_moving_frame;
    double const height = canted ? dot(work_.frame[b].up, place_in_frame(body, m)) - body.position.z : m.p.z;
    sum += body.mass * model_->gravity * height;
  }
  return sum;
}

Vec3<double> Dynamics::felt_acceleration(int body) const {
  auto const b = at(body);
  auto const& a = work_.acceleration[b];
  auto const& m = work_.motion[b];
  bool const carried = model_->bodies[b].in_moving_frame && on_rails_;
  Vec3<double> felt{a[coord_x], a[coord_y], a[coord_z]};
  if (carried && work_.curved) {
    felt += carrier_acceleration(model_->bodies[b], work_.frame[b], m) + model_->gravity * work_.frame[b].up;
  } else {
    felt.z += model_->gravity;
    if (carried) felt.x += work_.travel.acceleration;
  }
  return m.R.transposed_times(felt);
}

double Dynamics::rolling_slip(int constraint) const {
  return coupling_speed(model_->couplings[model_->rotors + at(constraint)], work_.motion);
}

double Dynamics::element_energy() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < model_->elements.size(); ++i)
    for (std::size_t c = 0; c < 6; ++c) {
      ForceElement const& e = model_->elements[i];
      double const s = e.node[c] >= 0 ? work_.node[at(e.node[c])] : 0.0;
      if (e.law[c].active()) sum += e.law[c].potential(element_deflection_[i * 6 + c], s);
    }
  return sum;
}

}  // namespace rollerrig
