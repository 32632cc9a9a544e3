#include "rollerrig/system/outputs.hpp"

namespace rollerrig {

double kinetic_energy(Dynamics const& dynamics) {
  Model const& model = dynamics.model();
  auto const& work = dynamics.work();
  double sum = 0.0;
  for (Coupling const& c : model.couplings)  // a constraint has no inertia
    sum += 0.5 * c.inertia * square(coupling_speed(c, work.motion));
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    Body const& body = model.bodies[b];
    auto const& m = work.motion[b];
    auto const& w = m.omega_body;
    sum += 0.5 * body.mass * dot(m.v, m.v) +
           0.5 * (body.inertia.x * w.x * w.x + body.inertia.y * w.y * w.y + body.inertia.z * w.z * w.z);
  }
  return sum;
}

double gravity_energy(Dynamics const& dynamics) {
  Model const& model = dynamics.model();
  auto const& work = dynamics.work();
  double sum = 0.0;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    Body const& body = model.bodies[b];
    auto const& m = work.motion[b];
    bool const canted = work.curved && body.in_moving_frame;
    double const height = canted ? dot(work.frame[b].up, place_in_frame(body, m)) - body.position.z : m.p.z;
    sum += body.mass * model.gravity * height;
  }
  return sum;
}

double element_energy(Dynamics const& dynamics) {
  Model const& model = dynamics.model();
  Evaluation const& evaluation = dynamics.evaluation();
  double sum = 0.0;
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    for (std::size_t c = 0; c < 6; ++c) {
      ForceElement const& e = model.elements[i];
      if (e.law[c].active())
        sum += potential(e.law[c], evaluation.element_deflection[i][c], evaluation.work.node.data() + e.node[c]);
    }
  return sum;
}

namespace {

/// Mean over the wheels of R times what `pitch` says of their rollers, positive where a wheel on it rolls forward.
template <class Pitch>
double mean_over_rollers(Model const& model, Pitch pitch) {
  double sum = 0.0;
  for (auto const& contact : model.contacts) sum -= contact.roller_radius * pitch(at(contact.roller));
  return sum / static_cast<double>(model.contacts.size());
}

}  // namespace

double crown_speed(Dynamics const& dynamics) {
  return mean_over_rollers(dynamics.model(), [&](auto b) { return dynamics.work().motion[b].rate[coord_pitch]; });
}

Travel<double> running_motion(Dynamics const& dynamics, double t, double const* z, Inputs const& inputs) {
  Model const& model = dynamics.model();
  if (model.on_rails || model.contacts.empty()) return travel_now(model, inputs, t);
  auto const angle = [&](std::size_t b) { return dynamics.map().angle[b] >= 0 ? z[dynamics.map().angle[b]] : 0.0; };
  auto const rate_change = [&](std::size_t b) { return dynamics.work().acceleration[b][coord_pitch]; };
  return {mean_over_rollers(model, angle), crown_speed(dynamics), mean_over_rollers(model, rate_change)};
}

double rolling_slip(Dynamics const& dynamics, int constraint) {
  Model const& model = dynamics.model();
  return coupling_speed(model.couplings[model.rotors + at(constraint)], dynamics.work().motion);
}

}  // namespace rollerrig
