#include "rollerrig/system/dynamics.hpp"

#include <algorithm>

namespace rollerrig {
static_assert(DifferentialEquation<Dynamics> && DifferentialEquation<DrivenDynamics>);

Evaluation::Evaluation(Model const& model)
    : work(model),
      element_force(model.elements.size()),
      element_deflection(model.elements.size()),
      brake_torque(model.brakes.size(), 0.0),
      rolling_force(model.rolling_constraints.size(), 0.0) {
  for (auto const& c : model.contacts) {
    RailHeads const& heads = c.right ? model.right_heads : model.left_heads;
    head.emplace_back(heads.empty() ? 0 : model.profiles[at(heads.profiles[0])].pieces.size());
  }
}

Dynamics::Dynamics(std::shared_ptr<Model const> model)
    : model_(std::move(model)),
      evaluation_(*model_),
      jacobian_sweeps_(*model_),
      stiff_creep_modes_(*model_),
      monitor_(*model_),
      evaluated_(at(model_->map.states()), 0.0) {}

void Dynamics::unpack(double const* x) {
  auto& work = evaluation_.work;
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    auto& m = work.motion[b];
    for (std::size_t c = 0; c < 6; ++c) {
      int const i = map().coordinate[b][c];
      int const j = map().rate[b][c];
      m.q[c] = i >= 0 ? x[i] : 0.0;
      m.rate[c] = j >= 0 ? x[j] : 0.0;
    }
    update_motion(model_->bodies[b], m);
  }
  double const* node = x + map().coordinates + map().rates;
  std::copy_n(node, map().nodes, work.node.begin());
}

bool Dynamics::evaluated_at(double t, double const* x, Inputs const& inputs) const {
  return t == evaluated_time_ && std::equal(evaluated_.begin(), evaluated_.end(), x) && inputs == evaluated_inputs_;
}

void Dynamics::evaluate(double t, double const* x, Inputs const& inputs) {
  // A step's end is looked at by accept(), the next step's first stage, the Jacobian and outputs: evaluated once.
  if (evaluated_at(t, x, inputs)) return;
  ForceAssembly<double> const forces(*model_, inputs, evaluation_, evaluation_.work);
  unpack(x);
  forces.place_track(t);
  if (evaluation_.work.curved)
    for (std::size_t b = 0; b < model_->bodies.size(); ++b) forces.see_from_common(b);
  forces.accelerate(t);
  evaluated_time_ = t;
  std::copy_n(x, evaluated_.size(), evaluated_.begin());
  if (!(inputs == evaluated_inputs_)) evaluated_inputs_ = inputs;
}

Status Dynamics::derivative(double t, double const* x, double* x_dot, double* z_dot, Inputs const& inputs) {
  evaluate(t, x, inputs);
  auto const& work = evaluation_.work;
  for (int i = 0; i < map().coordinates; ++i) x_dot[i] = x[velocity_column(i)];
  for (std::size_t b = 0; b < model_->bodies.size(); ++b)
    for (std::size_t c = 0; c < 6; ++c)
      if (map().rate[b][c] >= 0) x_dot[map().rate[b][c]] = work.acceleration[b][c];
  std::copy_n(work.node_rate.begin(), map().nodes, x_dot + map().coordinates + map().rates);
  if (z_dot == nullptr) return Status::ok;
  for (std::size_t b = 0; b < model_->bodies.size(); ++b)
    if (map().angle[b] >= 0) z_dot[map().angle[b]] = work.motion[b].rate[coord_pitch];
  std::copy_n(work.power.begin(), account_count, z_dot + map().angles);
  return Status::ok;
}

Status Dynamics::jacobian(double t, double const* x, JacobianData& j, Inputs const& inputs,
                          JacobianSweeps::Reader const& reader) {
  evaluate(t, x, inputs);
  jacobian_sweeps_.fill(*model_, inputs, evaluation_, t, j, reader);
  return Status::ok;
}

Status Dynamics::accept(double t, double const* x, Inputs const& inputs) {
  evaluate(t, x, inputs);
  return monitor_.check(*model_, evaluation_, t);
}

}  // namespace rollerrig
