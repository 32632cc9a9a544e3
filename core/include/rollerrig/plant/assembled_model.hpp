// plant/assembled_model.hpp - a case with nothing left to be worked out: what a run needs, and the names of its parts.
//
//   model, machines and controllers, starting state, settings of the integrator -> [assembled model] -> Plant
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rollerrig/integrate/options.hpp"
#include "rollerrig/simulate/setup.hpp"
#include "rollerrig/system/model.hpp"
#include "rollerrig/system/starting_state.hpp"

namespace rollerrig {

/// In the order of the model's indices.
struct PartNames {
  std::vector<std::string> bodies{}, elements{};
  std::vector<std::string> axles{};  ///< of the setup; empty without one

  static constexpr auto fields() {
    using P = PartNames;
    return members(Member{"bodies", &P::bodies}, Member{"elements", &P::elements}, Member{"axles", &P::axles});
  }
};

struct AssembledModel {
  std::string name{};  ///< of the case
  std::shared_ptr<Model const> model{};
  std::optional<MechatronicSetup> setup{};
  PartNames names{};
  integrate::Options options{};
  double start_time{};                      ///< [s]
  std::vector<double> start{};              ///< state there, system/starting_state.hpp
  std::vector<Disturbance> disturbances{};  ///< of it
};

/// Throws std::invalid_argument for what cannot be run, or lacks a name.
void check_assembled(AssembledModel const& assembled);

}  // namespace rollerrig
