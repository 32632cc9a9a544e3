#include "rollerrig/plant/model_file.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include "rollerrig/plant/archive.hpp"
#include "rollerrig/simulate/driver.hpp"

template rollerrig::archive::Type const& rollerrig::archive::type_of<rollerrig::SampledController>();

namespace rollerrig {
namespace {

constexpr std::size_t checksum_at = 40, header_size = 48;
constexpr Range within_reach{0.0, 1e5, "within 1e5 m, rad, m/s, rad/s", false, false, true};

/// What is written: an AssembledModel with its model in parts.
struct Content {
  std::string name{};
  ModelParts model{};
  std::optional<MechatronicSetup> setup{};
  PartNames names{};
  integrate::Options options{};
  double start_time{};
  std::vector<double> start{};
  std::vector<Disturbance> disturbances{};

  static constexpr auto fields() {
    using P = Content;
    return members(Member{"name", &P::name}, Member{"model", &P::model}, Member{"setup", &P::setup},
                   Member{"names", &P::names}, Member{"options", &P::options},
                   Member{"start_time", &P::start_time, "s", "time at the start"}, Member{"start", &P::start},
                   Member{"disturbances", &P::disturbances});
  }
};

std::uint64_t checksum(std::span<std::byte const> bytes) {
  return crc64(bytes.subspan(header_size), crc64(bytes.first(checksum_at)));
}

/// An FMU of a controller alone carries the checksum of its file's layout, which is longer than the rest of it.
std::string brief(std::string const& layout) {
  std::uint64_t const sum = crc64(std::as_bytes(std::span(layout)));
  return hexadecimal(std::as_bytes(std::span(&sum, 1)));
}

bool same_text(std::span<std::byte const> bytes, std::string_view text) {
  return std::ranges::equal(bytes, std::as_bytes(std::span(text)));
}

/// A kind of file.
struct Kind {
  std::string_view mark;
  std::string name, again;  ///< for messages: what it is, and how to get a new one
  archive::Type const& type;
  std::string layout{archive::layout(type)};

  [[noreturn]] void refuse(std::string const& what) const { throw std::invalid_argument(name + ": " + what); }

  std::vector<std::byte> write(void const* value) const {
    ByteWriter content;
    archive::put(content, type, value);
    ByteWriter out;
    out.numbers(mark.data(), mark.size());
    out.number(model_file_version);
    out.number(std::uint32_t{0});
    out.count(layout.size());
    out.count(content.bytes().size());
    out.number(std::uint64_t{0});
    out.numbers(layout.data(), layout.size());
    out.numbers(content.bytes().data(), content.bytes().size());
    std::vector<std::byte> bytes = out.take();
    std::uint64_t const crc = checksum(bytes);
    std::memcpy(bytes.data() + checksum_at, &crc, sizeof crc);
    return bytes;
  }
  void read(std::span<std::byte const> bytes, void* value) const {
    try {
      archive::get(checked(bytes), type, value);
    } catch (FormatError const& error) {
      refuse(error.what());
    }
  }

 private:
  /// The bytes of the value, once everything in front of them is right.
  std::span<std::byte const> checked(std::span<std::byte const> bytes) const {
    std::size_t const known = std::min(bytes.size(), mark.size());
    if (!same_text(bytes.first(known), mark.substr(0, known)))
      refuse("it is none: it does not begin with \"" + std::string(mark, 0, mark.find('\n')) + "\"");
    if (bytes.size() < header_size) refuse("cut: it ends after " + std::to_string(bytes.size()) + " bytes");
    ByteReader in(bytes.subspan(mark.size()));
    auto const version = in.number<std::uint32_t>(), zero = in.number<std::uint32_t>();
    auto const text = in.number<std::uint64_t>(), content = in.number<std::uint64_t>(),
               expected = in.number<std::uint64_t>();
    if (version != model_file_version || zero != 0)
      refuse("of version " + std::to_string(version) + ", this rollerrig reads version " +
             std::to_string(model_file_version) + "; " + again);
    std::uint64_t const left = in.left();
    if (text > left || content > left - text)
      refuse("cut, or changed: it has " + std::to_string(bytes.size()) + " bytes and should have more");
    if (text + content < left)
      refuse("changed: there are " + std::to_string(left - text - content) + " bytes too many");
    if (checksum(bytes) != expected) refuse("changed: its checksum is not that of its bytes");
    if (!same_text(bytes.subspan(header_size, at(text)), layout))
      refuse("of another version: its layout is not that of this rollerrig; " + again);
    return bytes.subspan(header_size + at(text));
  }
};

Kind const& model_file() {
  static Kind const kind{"rollerrig model\n", "model file", "assemble the case again", archive::type_of<Content>()};
  return kind;
}

Kind const& part_file() {
  archive::Type const& type = archive::type_of<ControllerPart>();
  static Kind const kind{
      {"rollerrig part\n\0", 16}, "controller", "export it again", type, brief(archive::layout(type))};
  return kind;
}

}  // namespace

std::string const& model_layout() { return model_file().layout; }

std::vector<std::byte> write_model(AssembledModel const& a) {
  Content const content{a.name, *a.model, a.setup, a.names, a.options, a.start_time, a.start, a.disturbances};
  return model_file().write(&content);
}

std::vector<std::byte> write_part(ControllerPart const& part) {
  check_part(part);
  return part_file().write(&part);
}

AssembledModel read_model(std::span<std::byte const> bytes) {
  Content content;
  model_file().read(bytes, &content);
  AssembledModel read{
      std::move(content.name), model_of(content.model), std::move(content.setup), std::move(content.names),
      content.options,         content.start_time,      std::move(content.start), std::move(content.disturbances)};
  read.check();
  return read;
}

ControllerPart read_part(std::span<std::byte const> bytes) {
  ControllerPart part;
  part_file().read(bytes, &part);
  check_part(part);
  return part;
}

std::string model_token(std::span<std::byte const> bytes) {
  need(bytes.size() >= header_size, "model file: cut: it ends after " + std::to_string(bytes.size()) + " bytes");
  return hexadecimal(bytes.subspan(checksum_at, sizeof(std::uint64_t)));
}

void AssembledModel::check() const {
  need(model != nullptr, "assembled model: there is no model");
  need(names.bodies.size() == model->bodies.size(), "assembled model: names: needed is one per body");
  need(names.elements.size() == model->elements.size(), "assembled model: names: needed is one per element");
  need(names.axles.size() == (setup ? setup->axles.size() : 0), "assembled model: names: needed is one per axle");
  if (setup) check_setup(*setup, *model);
  check_value(start, within_reach, "assembled model", "x0");
  check_value(options.final_time, finite_number, "assembled model", "final_time");
  need(static_cast<int>(start.size()) == model->map.states(), "assembled model: x0: needed is one per state");
  check_disturbances(disturbances, *model);
  check_settings(options, model->map.states(), start_time, setup ? setup->step : 0.0);
}

void check_part(ControllerPart const& part) {
  std::size_t const axles = part.axles.size();
  need(axles >= 1 && axles <= at(most_axles),
       "controller: axles: from 1 to " + std::to_string(most_axles) + " have names");
  need(part.axle_speed.size() == axles && part.roller_speed.size() == axles,
       "controller: axle_speed and roller_speed need one number per axle");
  check_fields(part, "ControllerPart");
  check_controller(part.controller, axles);
  auto const* rig = std::get_if<RigController>(&part.controller.controller);
  need(rig == nullptr || !std::holds_alternative<ExactForces>(rig->estimator),
       "controller: its estimator takes the forces that really act, which no rig measures");
}

}  // namespace rollerrig
