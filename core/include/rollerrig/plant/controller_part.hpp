// plant/controller_part.hpp - one controller of a case alone, as bytes: what stands in an FMU of it.
//
//   ControllerPart -> [write_part] -> bytes -> [read_part] -> the same ControllerPart, or a refusal by name
//
//   bytes  0  "rollerrig part\n", a zero
//         16  CRC-64 of everything behind it, u64
//         24  CRC-64 of the layout, u64: another core reads only what has the same; then the part
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "rollerrig/mechatronics/controllers.hpp"

namespace rollerrig {

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

/// The same part, the same bytes.
std::vector<std::byte> write_part(ControllerPart const& part);

/// Throws std::invalid_argument that says what is wrong: no part, cut, changed, of another version.
ControllerPart read_part(std::span<std::byte const> bytes);

/// The checksum as text: what names the part. Throws std::invalid_argument for bytes that are too few.
std::string part_token(std::span<std::byte const> bytes);

}  // namespace rollerrig
