#include "rollerrig/system/dynamics.hpp"

#include <algorithm>

namespace rollerrig {
namespace {

constexpr int seeds = 16;  // of JacobianDual

BodyMotion<JacobianDual> constant(BodyMotion<double> const& m) {
  BodyMotion<JacobianDual> out;
  for (std::size_t c = 0; c < 6; ++c) {
    out.q[c] = JacobianDual(m.q[c]);
    out.rate[c] = JacobianDual(m.rate[c]);
  }
  auto const up = [](Vec3<double> const& v) { return lift<JacobianDual>(v); };
  out.R = lift<JacobianDual>(m.R);
  out.p = up(m.p);
  out.v = up(m.v);
  out.omega_body = up(m.omega_body);
  out.frame_body = up(m.frame_body);
  out.omega = up(m.omega);
  out.frame_omega = up(m.frame_omega);
  out.sin_roll = JacobianDual(m.sin_roll);
  out.cos_roll = JacobianDual(m.cos_roll);
  out.sin_pitch = JacobianDual(m.sin_pitch);
  out.cos_pitch = JacobianDual(m.cos_pitch);
  return out;
}

std::vector<int> columns_of(StateMap const& map, int body) {
  std::vector<int> columns;
  for (auto const& index : {map.coordinate[at(body)], map.rate[at(body)]})
    for (int i : index)
      if (i >= 0) columns.push_back(i);
  return columns;
}

}  // namespace

JacobianSweeps::JacobianSweeps(Model const& model) : work_(model) {
  plan_groups(model);
  for (int first = 0; first < model.map.nodes; first += seeds) {
    Sweep sweep;
    sweep.first_node = first;
    sweep.node_count = std::min(seeds, model.map.nodes - first);
    for (int i = 0; i < sweep.node_count; ++i)
      sweep.columns.push_back(model.map.coordinates + model.map.rates + first + i);
    sweeps_.push_back(std::move(sweep));
  }
  for (Sweep& sweep : sweeps_) sweep.touched = touched_by(model, sweep, false);
  time_ = touched_by(model, {}, true);
}

/// A wheelset and its rollers share a sweep where they fit: they touch the same contacts.
void JacobianSweeps::plan_groups(Model const& model) {
  std::vector<char> done(model.bodies.size(), 0);
  for (int b = 0; b < static_cast<int>(done.size()); ++b) {
    if (done[at(b)]) continue;
    Sweep sweep;
    std::vector<int> group{b};
    for (auto const& contact : model.contacts)
      if (contact.wheelset == b && contact.roller >= 0) group.push_back(contact.roller);
    for (int member : group) {
      auto const columns = columns_of(model.map, member);
      if (done[at(member)] || sweep.columns.size() + columns.size() > seeds) continue;
      done[at(member)] = 1;
      if (columns.empty()) continue;
      sweep.bodies.push_back(member);
      sweep.columns.insert(sweep.columns.end(), columns.begin(), columns.end());
    }
    if (!sweep.columns.empty()) sweeps_.push_back(std::move(sweep));
  }
}

/// What depends on the seeds of a sweep, or on time.
Selection JacobianSweeps::touched_by(Model const& model, Sweep const& sweep, bool time) {
  Selection touched;
  touched.body.assign(model.bodies.size(), 0);
  for (int b : sweep.bodies) touched.body[at(b)] = 1;
  auto const seeded = [&](int b) { return std::ranges::find(sweep.bodies, b) != sweep.bodies.end(); };
  auto const affect = [&](std::initializer_list<int> bodies) {
    for (int b : bodies)
      if (b >= 0) touched.body[at(b)] = 1;
  };
  // What the track does over time reaches every element between two frames, every body in one, and what rolls on it.
  bool const line_moves = time && model.on_rails && !model.line.empty();
  for (auto const& e : model.elements) {
    bool const node_seeded =
        std::max(e.first_node(), sweep.first_node) < std::min(e.end_node(), sweep.first_node + sweep.node_count);
    bool const own = seeded(e.body_a) || seeded(e.body_b) || node_seeded || line_moves;
    touched.element.push_back(own);
    if (own) affect({e.body_a, e.body_b});
  }
  for (auto const& c : model.contacts) {
    bool const own = seeded(c.wheelset) || seeded(c.roller) || (time && (c.rail || model.displaces_rails()));
    touched.contact.push_back(own);
    if (own) affect({c.wheelset, c.roller});
  }
  if (line_moves) touched.body.assign(model.bodies.size(), 1);
  // Torques are few: they are evaluated in every sweep, for all bodies they act on.
  for (auto const& t : model.axle_torques) affect({t.wheelset, t.reaction});
  for (auto const& t : model.roller_torques) affect({t.roller});
  for (auto const& brake : model.brakes) affect({brake.wheelset, brake.reaction});
  for (auto const& brake : model.track_brakes) affect({brake.body});
  affect({model.resistance.body});
  for (std::size_t i = 0; i < model.couplings.size(); ++i)  // a chain of couplings is at most as long as there are
    for (auto const& [term, inertia, rate] : model.couplings) {
      auto const affected = [&](CouplingTerm const& c) { return c.body >= 0 && touched.body[at(c.body)]; };
      if (affected(term[0]) || affected(term[1])) affect({term[0].body, term[1].body});
    }
  return touched;
}

void JacobianSweeps::seed(Model const& model, Evaluation const& evaluation, Sweep const& sweep,
                          ForceAssembly<JacobianDual> const& forces) {
  int seed = 0;
  for (int b : sweep.bodies) {
    auto& m = work_.motion[at(b)];
    auto const& value = evaluation.work.motion[at(b)];
    for (std::size_t c = 0; c < 6; ++c)
      if (model.map.coordinate[at(b)][c] >= 0) m.q[c] = JacobianDual::variable(value.q[c], seed++);
    for (std::size_t c = 0; c < 6; ++c)
      if (model.map.rate[at(b)][c] >= 0) m.rate[c] = JacobianDual::variable(value.rate[c], seed++);
    update_motion(model.bodies[at(b)], m);
    if (work_.curved) forces.see_from_common(at(b));
  }
  for (int i = 0; i < sweep.node_count; ++i) {
    auto const node = at(sweep.first_node + i);
    work_.node[node] = JacobianDual::variable(evaluation.work.node[node], seed++);
  }
}

void JacobianSweeps::unseed(Evaluation const& evaluation, Sweep const& sweep) {
  for (int b : sweep.bodies) {
    work_.motion[at(b)] = constant(evaluation.work.motion[at(b)]);
    if (work_.curved) work_.common[at(b)] = constant(evaluation.work.common[at(b)]);
  }
  for (int i = 0; i < sweep.node_count; ++i) {
    auto const node = at(sweep.first_node + i);
    work_.node[node] = JacobianDual(evaluation.work.node[node]);
  }
}

void JacobianSweeps::store(Model const& model, Sweep const& sweep, JacobianData& j) const {
  StateMap const& map = model.map;
  auto const columns = sweep.columns.size();
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (!sweep.touched.body[b]) continue;
    for (std::size_t c = 0; c < 6; ++c)
      if (int const row = map.rate[b][c]; row >= 0)
        for (std::size_t k = 0; k < columns; ++k)
          j.a(row, sweep.columns[k]) = work_.acceleration[b][c].d[static_cast<int>(k)];
  }
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    if (!sweep.touched.element[i]) continue;
    for (int node = model.elements[i].first_node(); node < model.elements[i].end_node(); ++node)
      for (std::size_t k = 0; k < columns; ++k)
        j.a(map.coordinates + map.rates + node, sweep.columns[k]) = work_.node_rate[at(node)].d[static_cast<int>(k)];
  }
  for (int account = 0; account < account_count; ++account)
    for (std::size_t k = 0; k < columns; ++k)
      j.g(map.angles + account, sweep.columns[k]) = work_.power[at(account)].d[static_cast<int>(k)];
}

void JacobianSweeps::fill(Model const& model, Inputs const& inputs, Evaluation& evaluation, double t, JacobianData& j,
                          Reader const& reader) {
  StateMap const& map = model.map;
  ForceAssembly<JacobianDual> const forces(model, inputs, evaluation, work_);
  j.a.setZero();
  j.g.setZero();
  for (int i = 0; i < map.coordinates; ++i) j.a(i, map.velocity_column[at(i)]) = 1.0;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    work_.motion[b] = constant(evaluation.work.motion[b]);
    if (evaluation.work.curved) work_.common[b] = constant(evaluation.work.common[b]);
    if (map.angle[b] >= 0) j.g(map.angle[b], map.rate[b][coord_pitch]) = 1.0;
  }
  forces.place_track(JacobianDual(t));
  for (std::size_t i = 0; i < work_.node.size(); ++i) work_.node[i] = JacobianDual(evaluation.work.node[i]);
  for (Sweep const& sweep : sweeps_) {
    seed(model, evaluation, sweep, forces);
    forces.accelerate(JacobianDual(t), &sweep.touched);
    store(model, sweep, j);
    if (reader) reader(work_, sweep.touched, sweep.columns);
    unseed(evaluation, sweep);
  }
  fill_time(model, inputs, forces, t, j, reader);
}

void JacobianSweeps::fill_time(Model const& model, Inputs const& inputs, ForceAssembly<JacobianDual> const& forces,
                               double t, JacobianData& j, Reader const& reader) {
  StateMap const& map = model.map;
  j.f_t.setZero();
  j.g_t.setZero();
  auto const moves = [t](auto const& torque) { return torque.torque.rate(t) != 0.0; };
  bool const moving = model.speed.rate(t) != 0.0 || std::ranges::any_of(model.axle_torques, moves) ||
                      std::ranges::any_of(model.roller_torques, moves) || inputs.frame_moves ||
                      !inputs.axle_torque.empty() || !inputs.roller_torque.empty() || !inputs.cylinder.empty() ||
                      inputs.track_brake.slope != 0.0;
  if (!moving && !work_.curved && !model.displaces_rails()) return;
  forces.place_track(JacobianDual::variable(t, 0));
  if (work_.curved)
    for (std::size_t b = 0; b < model.bodies.size(); ++b) forces.see_from_common(b);
  forces.accelerate(JacobianDual::variable(t, 0), &time_);
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    for (std::size_t c = 0; c < 6; ++c)
      if (time_.body[b] && map.rate[b][c] >= 0) j.f_t[map.rate[b][c]] = work_.acceleration[b][c].d[0];
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    for (int node = model.elements[i].first_node(); node < model.elements[i].end_node(); ++node)
      if (time_.element[i]) j.f_t[map.coordinates + map.rates + node] = work_.node_rate[at(node)].d[0];
  for (int account = 0; account < account_count; ++account) j.g_t[map.angles + account] = work_.power[at(account)].d[0];
  if (reader) reader(work_, time_, {});
}

}  // namespace rollerrig
