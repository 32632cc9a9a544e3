#include "rollerrig/simulate/linear_model.hpp"

#include <array>
#include <vector>

#include "rollerrig/integrate/amplification.hpp"
#include "rollerrig/simulate/driver.hpp"
#include "rollerrig/simulate/recorded_rows.hpp"

namespace rollerrig {
namespace {

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
                   [&](auto row, int k, double value) { c(row, columns[static_cast<std::size_t>(k)]) = value; });
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
    HeldInput& held = *all[static_cast<std::size_t>(i)];
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

}  // namespace rollerrig
