#include "rollerrig/simulate/linear_model.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "rollerrig/integrate/amplification.hpp"
#include "rollerrig/math/lu.hpp"
#include "rollerrig/simulate/driver.hpp"
#include "rollerrig/simulate/recorded_rows.hpp"

namespace rollerrig {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Derivatives of a row of outputs by the seeds of one sweep.
class OutputSweep {
 public:
  explicit OutputSweep(Model const& model)
      : model_{model}, rows_(model.bodies.size() * body_columns + model.contacts.size() * wheel_columns) {}

  auto rows() const { return static_cast<Eigen::Index>(rows_.size()); }

  /// What the sweep does not touch has no derivative: `put(row, seed, value)` is not called for it.
  template <class Put>
  void read(Workspace<JacobianDual> const& work, Selection const& touched, int seeds, Put put) {
    auto const store = [&](std::size_t first, std::size_t count) {
      for (std::size_t i = first; i < first + count; ++i)
        for (int k = 0; k < seeds; ++k) put(static_cast<Eigen::Index>(i), k, rows_[i].d[k]);
    };
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      if (!touched.body[b]) continue;
      body_row(model_, work, b, rows_.data() + b * body_columns);
      store(b * body_columns, body_columns);
    }
    for (std::size_t w = 0; w < model_.contacts.size(); ++w) {
      if (!touched.contact[w]) continue;
      std::size_t const first = model_.bodies.size() * body_columns + w * wheel_columns;
      wheel_row(model_, work, w, rows_.data() + first);
      store(first, wheel_columns);
    }
  }

 private:
  Model const& model_;
  std::vector<JacobianDual> rows_;
};

}  // namespace

LinearModel linear_model(Dynamics& dynamics, double t, double const* x, Inputs inputs) {
  Model const& model = dynamics.model();
  inputs.axle_torque.resize(model.axle_torques.size());
  inputs.roller_torque.resize(model.roller_torques.size());
  inputs.cylinder.resize(model.brakes.size());
  std::vector<HeldInput*> all;
  for (auto* held : {&inputs.axle_torque, &inputs.roller_torque, &inputs.cylinder})
    for (HeldInput& one : *held) all.push_back(&one);
  for (HeldInput* one : all) *one = {t, one->at(t), 0.0};

  OutputSweep outputs(model);
  JacobianData j(dynamics.sizes());
  MatrixXd c = MatrixXd::Zero(outputs.rows(), j.a.cols());
  VectorXd by_time;
  auto const read = [&](Workspace<JacobianDual> const& work, Selection const& touched, std::span<int const> columns) {
    if (columns.empty())
      outputs.read(work, touched, 1, [&](auto row, int, double value) { by_time[row] = value; });
    else
      outputs.read(work, touched, static_cast<int>(columns.size()),
                   [&](auto row, int k, double value) { c(row, columns[at(k)]) = value; });
  };
  auto const sweep = [&] {
    by_time = VectorXd::Zero(outputs.rows());
    dynamics.jacobian(t, x, j, inputs, read);
  };
  sweep();
  auto const inputs_count = static_cast<Eigen::Index>(all.size());
  LinearModel linear{j.a, MatrixXd(j.a.rows(), inputs_count), c, MatrixXd(c.rows(), inputs_count)};
  VectorXd const f_t = j.f_t, y_t = by_time;
  for (Eigen::Index i = 0; i < inputs_count; ++i) {
    HeldInput& held = *all[at(i)];
    held.slope = 1.0;
    sweep();
    linear.b.col(i) = j.f_t - f_t;
    linear.d.col(i) = by_time - y_t;
    held.slope = 0.0;
  }
  return linear;
}

LinearModel linear_model(Driver& driver, double t, double const* x, std::span<double const> pressure,
                         std::span<double const> roller_torque) {
  Inputs inputs;
  if (driver.system() != nullptr) driver.system()->prepare(driver.plant().model(), inputs);
  auto const hold = [t](std::vector<HeldInput>& held, std::span<double const> values) {
    if (values.empty()) return;
    held.clear();
    for (double const value : values) held.push_back({t, value, 0.0});
  };
  hold(inputs.cylinder, pressure);
  hold(inputs.roller_torque, roller_torque);
  return linear_model(driver.plant(), t, x, std::move(inputs));
}

MatrixXd step_amplification(Dynamics& dynamics, integrate::Method method, double step, double t, double const* x) {
  JacobianData j(dynamics.sizes());
  dynamics.jacobian(t, x, j);
  integrate::LinearSystem system{j.a, dynamics.stiff_modes(), dynamics.sizes().quadratures};
  dynamics.renew_stiff_modes({}, system.modes);
  return integrate::amplification(system, method, step);
}

namespace {

constexpr int load_steps = 4;          ///< by which the pressures grow: creep is bent
constexpr int most_iterations = 20;    ///< at each
constexpr double accuracy = 1e-8;      ///< of all rates of the states [m/s, m/s^2, rad/s, rad/s^2]
constexpr double torque_scale = 1e4;   ///< of a roller's torque beside a state of about 1 [N m]
constexpr double longest_step = 10.0;  ///< of what is searched, so scaled: beyond, wheels slide

class Search {
 public:
  Search(Dynamics& dynamics, double t, std::vector<double> x)
      : dynamics_{dynamics}, t_{t}, x_{std::move(x)}, torque_(dynamics.model().roller_torques.size(), 0.0) {
    std::vector<bool> held(x_.size(), false);
    for (RollerTorque const& one : dynamics.model().roller_torques)
      if (int const rate = dynamics.map().rate[at(one.roller)][coord_pitch]; rate >= 0) held[at(rate)] = true;
    for (std::size_t i = 0; i < x_.size(); ++i)
      if (!held[i]) free_.push_back(static_cast<Index>(i));
  }

  bool run(std::span<double const> pressure) {
    for (int k = 1; k <= load_steps; ++k) {
      inputs_.cylinder.clear();
      for (double p : pressure) inputs_.cylinder.push_back({t_, p * k / load_steps, 0.0});
      if (!solve()) return false;
    }
    return true;
  }

  std::vector<double> const& x() const { return x_; }
  std::vector<double> const& torque() const { return torque_; }

 private:
  bool solve() {
    std::vector<double> z(at(dynamics_.sizes().quadratures));
    VectorXd rate(static_cast<Index>(x_.size()));
    for (int i = 0; i < most_iterations; ++i) {
      inputs_.roller_torque.clear();
      for (double torque : torque_) inputs_.roller_torque.push_back({t_, torque, 0.0});
      if (dynamics_.derivative(t_, x_.data(), rate.data(), z.data(), inputs_) != Status::ok || !rate.allFinite())
        return false;
      if (rate.cwiseAbs().maxCoeff() < accuracy) return true;
      if (!step(rate)) return false;
    }
    return false;
  }

  /// The least change that takes the rates away, to first order: what is free to stay anywhere stays.
  bool step(VectorXd const& rate) {
    auto const linear = linear_model(dynamics_, t_, x_.data(), inputs_);
    auto const states = static_cast<Index>(free_.size()), torques = static_cast<Index>(torque_.size());
    auto const first = static_cast<Index>(dynamics_.model().axle_torques.size());
    MatrixXd by(rate.size(), states + torques);
    for (Index k = 0; k < states; ++k) by.col(k) = linear.a.col(free_[at(k)]);
    for (Index k = 0; k < torques; ++k) by.col(states + k) = torque_scale * linear.b.col(first + k);
    VectorXd const change = LeastNorm(by).solve(-rate);
    if (!change.allFinite() || change.cwiseAbs().maxCoeff() > longest_step) return false;
    for (Index k = 0; k < states; ++k) x_[at(free_[at(k)])] += change[k];
    for (Index k = 0; k < torques; ++k) torque_[at(k)] += torque_scale * change[states + k];
    return true;
  }

  Dynamics& dynamics_;
  double t_;
  std::vector<double> x_, torque_;
  std::vector<Index> free_;  ///< states that are searched
  Inputs inputs_;
};

}  // namespace

HeldSpeed hold_speed(Dynamics& dynamics, double t, double const* x, std::span<double const> pressure) {
  Search search(dynamics, t, {x, x + dynamics.sizes().states});
  bool const found = search.run(pressure);
  return {search.x(), search.torque(), found};
}

}  // namespace rollerrig
