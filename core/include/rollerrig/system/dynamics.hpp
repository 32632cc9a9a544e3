// system/dynamics.hpp - x' = f(t, x, inputs), its Jacobian and its stiff modes: the one place where bodies and contacts meet.
//
//   Model (constant, shared), t, x, inputs -> [dynamics] -> integrate, equilibrium, linearisation, record
//
// One evaluation: unpack the bodies' motion; suspension; contact geometry and contact forces per wheel; actuators; Newton and
// Euler. Everything that changes is in here: each run has its own, and two runs of one model know nothing of each other.
#pragma once
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "rollerrig/system/contact_monitor.hpp"
#include "rollerrig/system/stiff_creep_modes.hpp"

namespace rollerrig {

/// The exact Jacobian: forward sweeps in dual numbers over groups of bodies. Of each group its states are seeded, and what they touch
/// is evaluated: columns of df/dx, dg/dx, df/dt, dg/dt.
class JacobianSweeps {
 public:
  /// What a sweep leaves to be read: derivatives by its seeds, of the parts that it touches.
  ///
  /// columns: state index of each seed; empty: the one seed is time
  using Reader =
      std::function<void(Workspace<JacobianDual> const& work, Selection const& touched, std::span<int const> columns)>;

  explicit JacobianSweeps(Model const& model);

  /// @param evaluation  of the model at time t, in double
  /// @param reader      called after each sweep, if there is one; without it time is swept only where something depends on it
  void fill(Model const& model, Inputs const& inputs, Evaluation& evaluation, double t, JacobianData& j,
            Reader const& reader = {});

 private:
  struct Sweep {
    std::vector<int> bodies;   ///< whose coordinates and rates are seeded
    std::vector<int> columns;  ///< state index of each seed
    int first_node{0}, node_count{0};
    Selection touched;
  };

  void plan_groups(Model const& model);
  static Selection touched_by(Model const& model, Sweep const& sweep, bool time);
  void seed(Model const& model, Evaluation const& evaluation, Sweep const& sweep,
            ForceAssembly<JacobianDual> const& forces);
  void unseed(Evaluation const& evaluation, Sweep const& sweep);
  void store(Model const& model, Sweep const& sweep, JacobianData& j) const;
  void fill_time(Model const& model, Inputs const& inputs, ForceAssembly<JacobianDual> const& forces, double t,
                 JacobianData& j, Reader const& reader);

  Workspace<JacobianDual> work_;
  std::vector<Sweep> sweeps_;
  Selection time_;
};

class Dynamics {
 public:
  explicit Dynamics(std::shared_ptr<Model const> model);
  Dynamics(Dynamics const&) = delete;
  Dynamics& operator=(Dynamics const&) = delete;

  // What an integrator asks for. Without inputs nothing acts but the tables of the model.
  Sizes sizes() const { return {map().states(), map().angles + account_count}; }
  int kinematic_states() const { return map().coordinates; }
  int velocity_column(int i) const { return map().velocity_column[at(i)]; }
  Status derivative(double t, double const* x, double* x_dot, double* z_dot, Inputs const& inputs = {});
  /// @param reader  shown what else depends on the states, after each sweep
  Status jacobian(double t, double const* x, JacobianData& j, Inputs const& inputs = {},
                  JacobianSweeps::Reader const& reader = {});
  Status accept(double t, double const* x, Inputs const& inputs = {});
  /// Inner nodes of elements, and slips against creep.
  StiffModes stiff_modes() const { return stiff_creep_modes_.room(); }
  bool renew_stiff_modes(StiffModes const& now, StiffModes& next) {
    return stiff_creep_modes_.renew(*model_, evaluation_, now, next);
  }

  /// Evaluates the model and leaves motion, forces and patches to be read; not again where it did so last.
  void evaluate(double t, double const* x, Inputs const& inputs = {});

  /// Whether that is what it evaluated last.
  bool evaluated_at(double t, double const* x, Inputs const& inputs) const;

  Model const& model() const { return *model_; }
  StateMap const& map() const { return model_->map; }
  Evaluation const& evaluation() const { return evaluation_; }
  Workspace<double> const& work() const { return evaluation_.work; }
  int patch_count(int contact) const { return evaluation_.patch_count(contact); }
  /// b components; of a right wheel in its mirror image.
  Patch<double> const& patch(int contact, int k) const { return evaluation_.patch(contact, k); }

  void reset_run() { monitor_.reset(); }
  ContactCounters const& counters() const { return monitor_.counters(); }
  std::vector<ContactLoss> contact_losses() const { return monitor_.losses(); }
  int failed_contact() const { return monitor_.failed_contact(); }

  /// Everything that changes in a run, for plant/state_archive.hpp; what was evaluated last is evaluated again.
  template <class Archive>
  void state(Archive& archive) {
    bool known = !std::isnan(evaluated_time_);
    archive(monitor_, known);
    if (!known) return;
    double t = evaluated_time_;
    std::vector<double> x = evaluated_;
    Inputs inputs = evaluated_inputs_;
    archive(t, x);
    list_inputs(archive, inputs);
    if constexpr (Archive::reading) evaluate(t, x.data(), inputs);
  }
  void list_inputs(auto& archive, Inputs& inputs) const {
    inputs.state(archive, model_->axle_torques.size(), model_->roller_torques.size(), model_->brakes.size(),
                 model_->contacts.size());
  }

 private:
  void unpack(double const* x);

  std::shared_ptr<Model const> model_;
  Evaluation evaluation_;
  JacobianSweeps jacobian_sweeps_;
  StiffCreepModes stiff_creep_modes_;
  ContactMonitor monitor_;
  double evaluated_time_{std::numeric_limits<double>::quiet_NaN()};  ///< what evaluation_ belongs to
  std::vector<double> evaluated_;
  Inputs evaluated_inputs_;
};

/// A model under inputs, as an integrator sees it. The inputs may change between steps.
class DrivenDynamics {
 public:
  DrivenDynamics(Dynamics& dynamics, Inputs const& inputs) : dynamics_{&dynamics}, inputs_{&inputs} {}

  Sizes sizes() const { return dynamics_->sizes(); }
  int kinematic_states() const { return dynamics_->kinematic_states(); }
  int velocity_column(int i) const { return dynamics_->velocity_column(i); }
  Status derivative(double t, double const* x, double* x_dot, double* z_dot) {
    return dynamics_->derivative(t, x, x_dot, z_dot, *inputs_);
  }
  Status jacobian(double t, double const* x, JacobianData& j) { return dynamics_->jacobian(t, x, j, *inputs_); }
  Status accept(double t, double const* x) { return dynamics_->accept(t, x, *inputs_); }
  StiffModes stiff_modes() const { return dynamics_->stiff_modes(); }
  bool renew_stiff_modes(StiffModes const& now, StiffModes& next) { return dynamics_->renew_stiff_modes(now, next); }

 private:
  Dynamics* dynamics_;
  Inputs const* inputs_;
};

}  // namespace rollerrig
