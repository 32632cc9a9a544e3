#include "rollerrig/plant/controller_part.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

#include "rollerrig/plant/archive.hpp"
#include "rollerrig/simulate/setup.hpp"

namespace rollerrig {
namespace {

constexpr std::string_view mark{"rollerrig part\n\0", 16};
constexpr std::size_t checksum_at = 16, layout_at = 24, header_size = 32;

[[noreturn]] void refuse(std::string const& what) { throw std::invalid_argument("controller: " + what); }

std::uint64_t layout() {
  static std::string const text = archive::layout(archive::type_of<ControllerPart>());
  return crc64(std::as_bytes(std::span(text)));
}

std::uint64_t number_at(std::span<std::byte const> bytes, std::size_t place) {
  std::uint64_t number = 0;
  std::memcpy(&number, bytes.data() + place, sizeof number);
  return number;
}

}  // namespace

void check_part(ControllerPart const& part) {
  std::size_t const axles = part.axles.size();
  if (axles < 1 || axles > at(most_axles)) refuse("axles: from 1 to " + std::to_string(most_axles) + " have names");
  if (part.axle_speed.size() != axles || part.roller_speed.size() != axles)
    refuse("axle_speed and roller_speed need one number per axle");
  check_fields(part, "ControllerPart");
  check_controller(part.controller, axles);
  if (auto const* rig = std::get_if<RigController>(&part.controller.controller))
    if (std::holds_alternative<ExactForces>(rig->estimator))
      refuse("its estimator takes the forces that really act, which no rig measures");
}

std::vector<std::byte> write_part(ControllerPart const& part) {
  check_part(part);
  ByteWriter content;
  archive::put(content, archive::type_of<ControllerPart>(), &part);
  ByteWriter out;
  for (char const c : mark) out.number(c);
  out.number(std::uint64_t{0});
  out.number(layout());
  out.numbers(content.bytes().data(), content.bytes().size());
  std::vector<std::byte> bytes = out.take();
  std::uint64_t const crc = crc64(std::span(std::as_const(bytes)).subspan(layout_at));
  std::memcpy(bytes.data() + checksum_at, &crc, sizeof crc);
  return bytes;
}

ControllerPart read_part(std::span<std::byte const> bytes) {
  bool const marked = bytes.size() >= header_size &&
                      std::equal(mark.begin(), mark.end(), bytes.begin(),
                                 [](char c, std::byte byte) { return byte == static_cast<std::byte>(c); });
  if (!marked) refuse("these bytes are none: they do not begin with \"rollerrig part\"");
  if (crc64(bytes.subspan(layout_at)) != number_at(bytes, checksum_at))
    refuse("cut, or changed: its checksum is not that of its bytes");
  if (number_at(bytes, layout_at) != layout())
    refuse("of another version: its layout is not that of this rollerrig; export it again");
  ControllerPart part;
  try {
    archive::get(bytes.subspan(header_size), archive::type_of<ControllerPart>(), &part);
  } catch (FormatError const& error) {
    refuse(error.what());
  }
  check_part(part);
  return part;
}

std::string part_token(std::span<std::byte const> bytes) {
  if (bytes.size() < header_size) refuse("cut: it ends after " + std::to_string(bytes.size()) + " bytes");
  return hexadecimal(bytes.subspan(checksum_at, sizeof(std::uint64_t)));
}

}  // namespace rollerrig
