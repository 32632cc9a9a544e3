// The exact Jacobian of the system: forward sweeps over groups of bodies.
#include <algorithm>

#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {
namespace {

constexpr int seeds = 16;  // of JacobianDual

std::size_t at(int i) { return static_cast<std::size_t>(i); }

BodyMotion<JacobianDual> constant(BodyMotion<double> const& m) {
  BodyMotion<JacobianDual> out;
  for (std::size_t c = 0; c < 6; ++c) {
    out.q[c] = JacobianDual(m.q[c]);
    out.rate[c] = JacobianDual(m.rate[c]);
  }
  auto const up = [](Vec3<double> const& v) { return lift<JacobianDual>(v); };
  out.R = {up(m.R.ex), up(m.R.ey), up(m.R.ez)};
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

}  // namespace

void Dynamics::plan_sweeps() {
  Model const& model = *model_;
  std::size_t const n = model.bodies.size();
  auto const columns_of = [&](int b) {
    std::vector<int> columns;
    for (std::size_t c = 0; c < 6; ++c)
      if (map_.coordinate[at(b)][c] >= 0) columns.push_back(map_.coordinate[at(b)][c]);
    for (std::size_t c = 0; c < 6; ++c)
      if (map_.rate[at(b)][c] >= 0) columns.push_back(map_.rate[at(b)][c]);
    return columns;
  };

  // A wheelset and its rollers share a sweep where they fit: they touch the same contacts.
  sweeps_.clear();
  time_sweep_ = {};
  std::vector<char> done(n, 0);
  for (int b = 0; b < static_cast<int>(n); ++b) {
    if (done[at(b)]) continue;
    Sweep sweep;
    std::vector<int> group{b};
    for (auto const& contact : model.contacts)
      if (contact.wheelset == b && contact.roller >= 0) group.push_back(contact.roller);
    for (int member : group) {
      auto const columns = columns_of(member);
      if (done[at(member)] || sweep.columns.size() + columns.size() > seeds) continue;
      done[at(member)] = 1;
      if (columns.empty()) continue;
      sweep.bodies.push_back(member);
      sweep.columns.insert(sweep.columns.end(), columns.begin(), columns.end());
    }
    if (!sweep.columns.empty()) sweeps_.push_back(std::move(sweep));
  }
  for (int first = 0; first < map_.nodes; first += seeds) {
    Sweep sweep;
    sweep.first_node = first;
    sweep.node_count = std::min(seeds, map_.nodes - first);
    for (int i = 0; i < sweep.node_count; ++i) sweep.columns.push_back(map_.coordinates + map_.rates + first + i);
    sweeps_.push_back(std::move(sweep));
  }

  auto const mark = [&](Sweep& sweep, bool time) {
    sweep.touched_body.assign(n, 0);
    sweep.affected_body.assign(n, 0);
    for (int b : sweep.bodies) sweep.touched_body[at(b)] = sweep.affected_body[at(b)] = 1;
    auto const seeded = [&](int b) { return b >= 0 && sweep.touched_body[at(b)]; };
    auto const affect = [&](int b) {
      if (b >= 0) sweep.affected_body[at(b)] = 1;
    };
    // What the track does over time reaches every element between two frames, every body it carries, and what rolls on it.
    bool const line_moves = time && on_rails_ && !model.line.empty();
    for (auto const& e : model.elements) {
      bool touched = seeded(e.body_a) || seeded(e.body_b) || line_moves;
      for (int node : e.node)
        touched = touched || (node >= sweep.first_node && node < sweep.first_node + sweep.node_count);
      sweep.touched_element.push_back(touched);
      if (touched) affect(e.body_a), affect(e.body_b);
    }
    for (auto const& c : model.contacts) {
      bool const touched = seeded(c.wheelset) || seeded(c.roller) || (time && (c.rail || !model.irregularity.empty()));
      sweep.touched_contact.push_back(touched);
      if (touched) affect(c.wheelset), affect(c.roller);
    }
    for (int b = 0; line_moves && b < static_cast<int>(n); ++b) affect(b);
    // Torques are few: they are evaluated in every sweep, for all bodies they act on.
    for (auto const& t : model.axle_torques) affect(t.wheelset), affect(t.reaction);
    for (auto const& t : model.roller_torques) affect(t.roller);
    for (auto const& brake : model.brakes) affect(brake.wheelset), affect(brake.reaction);
    affect(model.resistance.body);
    for (std::size_t i = 0; i < model.couplings.size(); ++i)  // a chain of couplings is at most as long as there are
      for (auto const& [term, inertia, rate] : model.couplings) {
        auto const affected = [&](CouplingTerm const& c) { return c.body >= 0 && sweep.affected_body[at(c.body)]; };
        if (affected(term[0]) || affected(term[1])) affect(term[0].body), affect(term[1].body);
      }
  };
  for (Sweep& sweep : sweeps_) mark(sweep, false);
  mark(time_sweep_, true);
}

void Dynamics::store_sweep(Sweep const& sweep, JacobianData& j) const {
  auto const columns = sweep.columns.size();
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    if (!sweep.affected_body[b]) continue;
    for (std::size_t c = 0; c < 6; ++c)
      if (int const row = map_.rate[b][c]; row >= 0)
        for (std::size_t k = 0; k < columns; ++k)
          j.a(row, sweep.columns[k]) = dual_.acceleration[b][c].d[static_cast<int>(k)];
  }
  for (std::size_t i = 0; i < model_->elements.size(); ++i) {
    if (!sweep.touched_element[i]) continue;
    for (int node : model_->elements[i].node)
      for (std::size_t k = 0; node >= 0 && k < columns; ++k)
        j.a(map_.coordinates + map_.rates + node, sweep.columns[k]) = dual_.node_rate[at(node)].d[static_cast<int>(k)];
  }
  for (int account = 0; account < account_count; ++account)
    for (std::size_t k = 0; k < columns; ++k)
      j.g(map_.angles + account, sweep.columns[k]) = dual_.power[at(account)].d[static_cast<int>(k)];
}

Status Dynamics::jacobian(double t, double const* x, JacobianData& j) {
  evaluate(t, x);
  j.a.setZero();
  j.g.setZero();
  for (int i = 0; i < map_.coordinates; ++i) j.a(i, map_.velocity_column[at(i)]) = 1.0;
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    dual_.motion[b] = constant(work_.motion[b]);
    if (work_.curved) dual_.common[b] = constant(work_.common[b]);
    if (map_.angle[b] >= 0) j.g(map_.angle[b], map_.rate[b][coord_pitch]) = 1.0;
  }
  place(dual_, JacobianDual(t));
  for (std::size_t i = 0; i < work_.node.size(); ++i) dual_.node[i] = JacobianDual(work_.node[i]);

  for (Sweep const& sweep : sweeps_) {
    int seed = 0;
    for (int b : sweep.bodies) {
      auto& m = dual_.motion[at(b)];
      for (std::size_t c = 0; c < 6; ++c)
        if (map_.coordinate[at(b)][c] >= 0) m.q[c] = JacobianDual::variable(work_.motion[at(b)].q[c], seed++);
      for (std::size_t c = 0; c < 6; ++c)
        if (map_.rate[at(b)][c] >= 0) m.rate[c] = JacobianDual::variable(work_.motion[at(b)].rate[c], seed++);
      update_motion(model_->bodies[at(b)], m);
      if (work_.curved) see_from_common(dual_, b);
    }
    for (int i = 0; i < sweep.node_count; ++i) {
      auto const node = at(sweep.first_node + i);
      dual_.node[node] = JacobianDual::variable(work_.node[node], seed++);
    }
    evaluate_forces(dual_, JacobianDual(t), &sweep);
    store_sweep(sweep, j);
    for (int b : sweep.bodies) {
      dual_.motion[at(b)] = constant(work_.motion[at(b)]);
      if (work_.curved) dual_.common[at(b)] = constant(work_.common[at(b)]);
    }
    for (int i = 0; i < sweep.node_count; ++i) {
      auto const node = at(sweep.first_node + i);
      dual_.node[node] = JacobianDual(work_.node[node]);
    }
  }
  time_derivative(t, j);
  return Status::ok;
}

void Dynamics::time_derivative(double t, JacobianData& j) {
  j.f_t.setZero();
  j.g_t.setZero();
  auto const moves = [t](auto const& torque) { return torque.torque.rate(t) != 0.0; };
  bool const moving = model_->speed.rate(t) != 0.0 || std::ranges::any_of(model_->axle_torques, moves) ||
                      std::ranges::any_of(model_->roller_torques, moves) || inputs.travels ||
                      !inputs.axle_torque.empty() || !inputs.roller_torque.empty() || !inputs.cylinder.empty();
  bool const track_passes = work_.curved || !model_->irregularity.empty();
  if (!moving && !track_passes) return;
  place(dual_, JacobianDual::variable(t, 0));
  if (dual_.curved)
    for (int b = 0; b < static_cast<int>(model_->bodies.size()); ++b) see_from_common(dual_, b);
  evaluate_forces(dual_, JacobianDual::variable(t, 0), &time_sweep_);
  for (std::size_t b = 0; b < model_->bodies.size(); ++b)
    for (std::size_t c = 0; c < 6; ++c)
      if (time_sweep_.affected_body[b] && map_.rate[b][c] >= 0) j.f_t[map_.rate[b][c]] = dual_.acceleration[b][c].d[0];
  for (std::size_t i = 0; i < model_->elements.size(); ++i)
    for (int node : model_->elements[i].node)
      if (node >= 0 && time_sweep_.touched_element[i])
        j.f_t[map_.coordinates + map_.rates + node] = dual_.node_rate[at(node)].d[0];
  for (int account = 0; account < account_count; ++account)
    j.g_t[map_.angles + account] = dual_.power[at(account)].d[0];
}

}  // namespace rollerrig
