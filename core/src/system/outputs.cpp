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

Vec3<double> specific_force(Dynamics const& dynamics, int body) {
  auto const b = static_cast<std::size_t>(body);
  Model const& model = dynamics.model();
  auto const& work = dynamics.work();
  auto const& a = work.acceleration[b];
  bool const moving = model.bodies[b].in_moving_frame && model.on_rails;
  Vec3<double> f{a[coord_x], a[coord_y], a[coord_z]};
  if (moving && work.curved) {
    f += transport_acceleration(model.bodies[b], work.frame[b], work.motion[b]) + model.gravity * work.frame[b].up;
  } else {
    f.z += model.gravity;
    if (moving) f.x += work.travel.acceleration;
  }
  return work.motion[b].R.transposed_times(f);
}

double rolling_slip(Dynamics const& dynamics, int constraint) {
  Model const& model = dynamics.model();
  return coupling_speed(model.couplings[model.rotors + static_cast<std::size_t>(constraint)], dynamics.work().motion);
}

}  // namespace rollerrig
