// plant/parameters.hpp - numbers of an assembled model that a tool may change: before a start, or between steps.
//
//   AssembledModel -> [ModelParameters] -> named numbers -> another AssembledModel, in equilibrium again
//
// Masses, inertias, linear springs and dampers, friction, adhesion, the rollers' radius and what the rig's controller assumes are
// fixed in a run. What slide protection, slip control and the laws of the rig's controller go by may change at every sample.
#pragma once
#include <memory>
#include <vector>

#include "rollerrig/plant/variable.hpp"

namespace rollerrig {

class ModelParameters {
 public:
  explicit ModelParameters(AssembledModel const& assembled);
  ModelParameters(ModelParameters const&) = delete;
  ModelParameters& operator=(ModelParameters const&) = delete;

  std::vector<Variable> const& variables() const { return variables_; }
  void set(std::size_t index, double value);
  double get(std::size_t index) const { return *place_[index].front(); }

  AssembledModel const& given() const { return given_; }
  /// Controllers with the present numbers.
  std::vector<SampledController> const& controllers() const {
    return setup_->controllers;
  }  // of a model that has a setup
  /// The model with the present numbers, started from the equilibrium that it then has: what disturbed the start is kept. The one
  /// that was given where no fixed number differs. Throws std::invalid_argument where there is no model or no equilibrium.
  AssembledModel assembled() const;

 private:
  struct Walk;

  AssembledModel const given_;
  ModelParts parts_;
  std::optional<MechatronicSetup> setup_;
  std::vector<std::shared_ptr<AdhesionMap>> maps_;
  std::vector<Variable> variables_;
  std::vector<std::vector<double*>> place_;  ///< per variable: all numbers that it stands for
  std::vector<double> first_;                ///< per variable, as given
};

}  // namespace rollerrig
