#include "rollerrig/plant/model_file.hpp"

#include <stdexcept>
#include <string_view>

#include "rollerrig/plant/archive.hpp"
#include "rollerrig/simulate/driver.hpp"

template rollerrig::archive::Type const& rollerrig::archive::type_of<rollerrig::SampledController>();

namespace rollerrig {
namespace {

constexpr std::string_view mark = "rollerrig model\n";
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

[[noreturn]] void refuse(std::string const& what) { throw std::invalid_argument("model file: " + what); }

/// The bytes of the model, once everything in front of them is right.
std::span<std::byte const> checked(std::span<std::byte const> bytes) {
  std::size_t const known = std::min(bytes.size(), mark.size());
  if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(known), mark.begin(),
                  [](std::byte byte, char c) { return byte == static_cast<std::byte>(c); }))
    refuse("it is none: it does not begin with \"rollerrig model\"");
  if (bytes.size() < header_size) refuse("cut: it ends after " + std::to_string(bytes.size()) + " bytes");
  ByteReader in(bytes.subspan(mark.size()));
  auto const version = in.number<std::uint32_t>(), zero = in.number<std::uint32_t>();
  auto const layout = in.number<std::uint64_t>(), model = in.number<std::uint64_t>(),
             expected = in.number<std::uint64_t>();
  if (version != model_file_version || zero != 0)
    refuse("of version " + std::to_string(version) + ", this rollerrig reads version " +
           std::to_string(model_file_version) + "; assemble the case again");
  std::uint64_t const left = in.left();
  if (layout > left || model > left - layout)
    refuse("cut, or changed: it has " + std::to_string(bytes.size()) + " bytes and should have more");
  if (layout + model < left) refuse("changed: there are " + std::to_string(left - layout - model) + " bytes too many");
  if (checksum(bytes) != expected) refuse("changed: its checksum is not that of its bytes");
  auto const text = bytes.subspan(header_size, at(layout));
  if (!std::equal(text.begin(), text.end(), model_layout().begin(), model_layout().end(),
                  [](std::byte byte, char c) { return byte == static_cast<std::byte>(c); }))
    refuse("of another version: its layout is not that of this rollerrig; assemble the case again");
  return bytes.subspan(header_size + at(layout));
}

}  // namespace

std::string const& model_layout() {
  static std::string const text = archive::layout(archive::type_of<Content>());
  return text;
}

std::vector<std::byte> write_model(AssembledModel const& a) {
  Content const content{a.name, parts_of(*a.model), a.setup, a.names, a.options, a.start_time, a.start, a.disturbances};
  ByteWriter model;
  archive::put(model, archive::type_of<Content>(), &content);
  ByteWriter out;
  for (char const c : mark) out.number(c);
  out.number(model_file_version);
  out.number(std::uint32_t{0});
  out.count(model_layout().size());
  out.count(model.bytes().size());
  out.number(std::uint64_t{0});
  out.numbers(model_layout().data(), model_layout().size());
  out.numbers(model.bytes().data(), model.bytes().size());
  std::vector<std::byte> bytes = out.take();
  std::uint64_t const crc = checksum(bytes);
  std::memcpy(bytes.data() + checksum_at, &crc, sizeof crc);
  return bytes;
}

AssembledModel read_model(std::span<std::byte const> bytes) {
  Content content;
  auto const stored = checked(bytes);
  try {
    archive::get(stored, archive::type_of<Content>(), &content);
  } catch (FormatError const& error) {
    refuse(error.what());
  }
  AssembledModel read{
      std::move(content.name), model_of(content.model), std::move(content.setup), std::move(content.names),
      content.options,         content.start_time,      std::move(content.start), std::move(content.disturbances)};
  check_assembled(read);
  return read;
}

std::string model_token(std::span<std::byte const> bytes) {
  if (bytes.size() < header_size) refuse("cut: it ends after " + std::to_string(bytes.size()) + " bytes");
  return hexadecimal(bytes.subspan(checksum_at, sizeof(std::uint64_t)));
}

void check_assembled(AssembledModel const& assembled) {
  auto const need = [](bool condition, char const* message) {
    if (!condition) throw std::invalid_argument(message);
  };
  PartNames const& names = assembled.names;
  need(assembled.model != nullptr, "assembled model: there is no model");
  Model const& model = *assembled.model;
  need(names.bodies.size() == model.bodies.size(), "assembled model: names: needed is one per body");
  need(names.elements.size() == model.elements.size(), "assembled model: names: needed is one per element");
  need(names.axles.size() == (assembled.setup ? assembled.setup->axles.size() : 0),
       "assembled model: names: needed is one per axle");
  if (assembled.setup) check_setup(*assembled.setup, model);
  check_value(assembled.start, within_reach, "assembled model", "x0");
  need(static_cast<int>(assembled.start.size()) == model.map.states(), "assembled model: x0: needed is one per state");
  check_disturbances(assembled.disturbances, model);
  integrate::check_options(assembled.options, model.map.states(), true);
  check_settings(assembled.options, assembled.start_time, assembled.setup ? assembled.setup->step : 0.0);
}

}  // namespace rollerrig
