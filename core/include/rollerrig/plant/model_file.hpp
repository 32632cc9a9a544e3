// plant/model_file.hpp - an assembled model as bytes: one file that stands on its own. docs/model_file.md.
//
//   AssembledModel -> [write_model] -> bytes -> [read_model] -> the same AssembledModel, or a refusal by name
//
//   bytes  0  "rollerrig model\n"
//         16  version of what follows, u32; 0, u32
//         24  length of the layout, u64; length of the model, u64
//         40  CRC-64 of everything but these eight bytes, u64
//         48  layout: a text, a line for each field; then the model
//
// The layout is that of the core that wrote the file: another core reads only what has the same.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
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

/// A case with nothing left to be worked out: what a run needs, and the names of its parts.
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

constexpr std::uint32_t model_file_version = 1;

/// A line for each field of a model, in the order in which they are written.
std::string const& model_layout();

/// The same model, the same bytes.
std::vector<std::byte> write_model(AssembledModel const& assembled);

/// Throws std::invalid_argument that says what is wrong: no model, cut, changed, of another version, or a number out of its range.
AssembledModel read_model(std::span<std::byte const> bytes);

/// The checksum of a model file as text: what names its model. Throws std::invalid_argument for bytes that are too few.
std::string model_token(std::span<std::byte const> bytes);

}  // namespace rollerrig
