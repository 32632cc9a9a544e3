// system/jacobian_sweeps.hpp - the exact Jacobian of the dynamics: forward sweeps in dual numbers over groups of bodies.
//
//   evaluation in double -> [per group: seed its states, evaluate what they touch] -> columns of df/dx, dg/dx, df/dt, dg/dt
#pragma once
#include "rollerrig/integrate/differential_equation.hpp"
#include "rollerrig/system/force_assembly.hpp"

namespace rollerrig {

class JacobianSweeps {
 public:
  explicit JacobianSweeps(Model const& model);

  /// @param evaluation  of the model at time t, in double
  void fill(Model const& model, Inputs const& inputs, Evaluation& evaluation, double t, JacobianData& j);

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
                 JacobianData& j);

  Workspace<JacobianDual> work_;
  std::vector<Sweep> sweeps_;
  Selection time_;
};

}  // namespace rollerrig
