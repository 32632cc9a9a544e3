// plant/model_file.hpp - an assembled model, or one controller of a case alone, as bytes: a file that stands on its own.
// docs/model_file.md.
//
//   AssembledModel, ControllerPart -> [write] -> bytes -> [read] -> the same, or a refusal by name
//
//   bytes  0  "rollerrig model\n", or "rollerrig part\n" and a zero
//         16  version of what follows, u32; 0, u32
//         24  length of the layout, u64; length of the model, u64
//         40  CRC-64 of everything but these eight bytes, u64
//         48  layout: a text, a line for each field, of a part the checksum of that text; then the model, or the part
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
#include "rollerrig/system/equilibrium.hpp"
#include "rollerrig/system/model.hpp"

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
  std::vector<double> start{};              ///< state there, system/equilibrium.hpp
  std::vector<Disturbance> disturbances{};  ///< of it

  static constexpr auto fields() {
    using P = AssembledModel;
    return members(
        Member{"name", &P::name}, Member{"model", &P::model}, Member{"setup", &P::setup}, Member{"names", &P::names},
        Member{"options", &P::options}, Member{"t0", &P::start_time, "s", "time at the start"},
        Member{"x0", &P::start, "m, rad, m/s, rad/s", "state at the start"}, Member{"disturbances", &P::disturbances});
  }
  /// Throws std::invalid_argument for what cannot be run, or lacks a name.
  void check() const;
};

/// What stands in an FMU of a controller alone.
struct ControllerPart {
  std::string name{};  ///< of the case
  double step{};
  SampledController controller{};  ///< its delay belongs to the case, and is not part of it
  std::vector<std::string> axles{};
  double train_speed{};
  std::vector<double> axle_speed{}, roller_speed{};

  static constexpr auto fields() {
    using P = ControllerPart;
    return members(Member{"name", &P::name}, Member{"step", &P::step, "s", "sampling step of the case", positive},
                   Member{"controller", &P::controller}, Member{"axles", &P::axles},
                   Member{"train_speed", &P::train_speed, "m/s", "train speed at the start"},
                   Member{"axle_speed", &P::axle_speed, "rad/s", "speed of each axle at the start"},
                   Member{"roller_speed", &P::roller_speed, "rad/s", "speed of each roller axle at the start"});
  }
};

/// Throws std::invalid_argument: numbers of axles that do not fit, or an estimator that takes what no rig measures.
void check_part(ControllerPart const& part);

constexpr std::uint32_t model_file_version = 1;

/// A line for each field of a model, in the order in which they are written.
std::string const& model_layout();

/// The same model, the same bytes.
std::vector<std::byte> write_model(AssembledModel const& assembled);
std::vector<std::byte> write_part(ControllerPart const& part);

/// Throws std::invalid_argument that says what is wrong: no model, cut, changed, of another version, or a number out of its range.
AssembledModel read_model(std::span<std::byte const> bytes);
ControllerPart read_part(std::span<std::byte const> bytes);

/// The checksum of such a file as text: what names its model or part. Throws std::invalid_argument for bytes that are too few.
std::string model_token(std::span<std::byte const> bytes);

}  // namespace rollerrig
