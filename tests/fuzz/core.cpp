// fuzz/core.cpp - what the core reads as bytes, under libFuzzer: model files, saved states, controllers of FMUs.
//
//   bytes behind the checksums -> checksums made right -> refused, or a run of a few steps that the sanitizers watch
//
// One file, three programs: fuzz_model, fuzz_state, fuzz_controller. The sound file that each begins with is named by
// ROLLERRIG_FUZZ_FILE (scripts/fuzz writes it): a model file, for fuzz_controller a controller's.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

#include "rollerrig/plant/byte_stream.hpp"
#include "rollerrig/plant/controller_plant.hpp"
#include "rollerrig/plant/model_file.hpp"
#include "rollerrig/plant/plant.hpp"

namespace {

using namespace rollerrig;
using Bytes = std::vector<std::byte>;

constexpr double infinity = std::numeric_limits<double>::infinity();

Bytes const& sound_file() {
  static Bytes const bytes = [] {
    char const* const path = std::getenv("ROLLERRIG_FUZZ_FILE");
    std::ifstream file(path != nullptr ? path : "", std::ios::binary);
    std::vector<char> const text(std::istreambuf_iterator<char>(file), {});
    if (text.empty()) std::abort();  // no file: nothing would be tried
    Bytes read(text.size());
    std::memcpy(read.data(), text.data(), text.size());
    return read;
  }();
  return bytes;
}

/// The head of a sound file and a body of one's own; the checksum is a number at `checksum_at`.
Bytes behind_head(std::size_t head, std::span<std::byte const> body) {
  Bytes bytes(sound_file().begin(), sound_file().begin() + static_cast<std::ptrdiff_t>(head));
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

void write_number(Bytes& bytes, std::size_t at, std::uint64_t number) {
  std::memcpy(bytes.data() + at, &number, sizeof number);
}

void run_on(auto& plant, double time) {
  if (plant.advance(plant.time() + time) != Status::ok) return;
  for (std::size_t i = 0; i < plant.variables().size(); ++i) static_cast<void>(plant.get(static_cast<int>(i)));
  static_cast<void>(plant.save());
}

[[maybe_unused]] void model(std::span<std::byte const> body) {
  constexpr std::size_t length_at = 32, checksum_at = 40, header = 48;
  Bytes bytes = behind_head(header + model_layout().size(), body);
  write_number(bytes, length_at, body.size());
  auto const whole = std::span(std::as_const(bytes));
  write_number(bytes, checksum_at, crc64(whole.subspan(header), crc64(whole.first(checksum_at))));
  Plant plant(read_model(bytes));
  if (plant.start(infinity) == Status::ok) run_on(plant, 0.002);
}

[[maybe_unused]] void state(std::span<std::byte const> body) {
  static Plant plant(read_model(sound_file()));
  static Bytes const sound = [] {
    plant.start(infinity);
    plant.advance(0.01);
    return plant.save();
  }();
  constexpr std::size_t checksum_at = 8, header = 16;
  Bytes bytes(sound.begin(), sound.begin() + header);
  bytes.insert(bytes.end(), body.begin(), body.end());
  std::uint64_t identity{};
  std::memcpy(&identity, bytes.data(), sizeof identity);
  write_number(bytes, checksum_at, crc64(std::span(std::as_const(bytes)).subspan(header), identity));
  double const before = plant.time();
  if (plant.restore(bytes)) return run_on(plant, 0.002);
  if (plant.time() != before) std::abort();  // a refusal changes nothing
}

[[maybe_unused]] void controller(std::span<std::byte const> body) {
  constexpr std::size_t checksum_at = 16, layout_at = 24, header = 32;
  Bytes bytes = behind_head(header, body);
  write_number(bytes, checksum_at, crc64(std::span(std::as_const(bytes)).subspan(layout_at)));
  ControllerPlant plant(read_part(bytes));
  if (plant.start(infinity) == Status::ok) run_on(plant, 10.0 * plant.period());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size) {
  auto const body = std::as_bytes(std::span(data, size));
  try {
#if defined(FUZZ_model)
    model(body);
#elif defined(FUZZ_state)
    state(body);
#else
    controller(body);
#endif
  } catch (std::invalid_argument const& refused) {
    if (refused.what()[0] == '\0') std::abort();
  }
  return 0;
}
