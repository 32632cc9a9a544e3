// system/jacobian_sweeps.hpp - the exact Jacobian of the dynamics: forward sweeps in dual numbers over groups of bodies.
//
//   evaluation in double -> [per group: seed its states, evaluate what they touch] -> columns of df/dx, dg/dx, df/dt, dg/dt
#pragma once
#include <functional>
#include <span>

#include "rollerrig/integrate/differential_equation.hpp"
#include "rollerrig/system/force_assembly.hpp"

namespace rollerrig {

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

}  // namespace rollerrig
