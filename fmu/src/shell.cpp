#include "rollerrig/fmu/shell.hpp"

#include <array>
#include <fstream>
#include <iterator>
#include <vector>

#include "rollerrig/plant/controller_plant.hpp"
#include "rollerrig/plant/plant.hpp"

namespace rollerrig::fmu {
namespace {

struct Instructions {
  char const* name;
  bool compiled, there;
};

#if defined(__x86_64__) && defined(__GNUC__)
#if defined(__AVX2__) && defined(__FMA__)
constexpr bool with_avx2 = true;
#else
constexpr bool with_avx2 = false;
#endif
#ifdef __AVX512F__
constexpr bool with_avx512 = true;
#else
constexpr bool with_avx512 = false;
#endif
#ifdef __AVX__
constexpr bool with_avx = true;
#else
constexpr bool with_avx = false;
#endif
std::array<Instructions, 3> instructions() {
  return {{{"AVX", with_avx, __builtin_cpu_supports("avx") != 0},
           {"AVX2 with FMA", with_avx2, __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")},
           {"AVX-512", with_avx512, __builtin_cpu_supports("avx512f") != 0}}};
}
#else
std::array<Instructions, 0> instructions() { return {}; }
#endif

template <class Choose>
std::string names(Choose choose) {
  std::string all;
  for (Instructions const& one : instructions())
    if (choose(one)) all += (all.empty() ? "" : ", ") + std::string(one.name);
  return all;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

}  // namespace

std::filesystem::path utf8_path(std::string_view text) {
  return {std::u8string(reinterpret_cast<char8_t const*>(text.data()), text.size())};
}

std::string needed_instructions() {
  return names([](Instructions const& i) { return i.compiled; });
}

std::filesystem::path path_of_uri(std::string_view uri) {
  if (!uri.starts_with("file:")) return {};
  uri.remove_prefix(5);
  if (uri.starts_with("//")) {  // an authority: none, or this machine
    uri.remove_prefix(2);
    if (uri.starts_with("localhost")) uri.remove_prefix(9);
  }
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    bool const escaped =
        uri[i] == '%' && i + 2 < uri.size() && hex_digit(uri[i + 1]) >= 0 && hex_digit(uri[i + 2]) >= 0;
    if (escaped) {
      text += static_cast<char>(16 * hex_digit(uri[i + 1]) + hex_digit(uri[i + 2]));
      i += 2;
    } else {
      text += uri[i];
    }
  }
  bool const drive = text.size() > 2 && text[0] == '/' && text[2] == ':';  // /C:/folder
  return utf8_path(drive ? text.substr(1) : text);
}

std::unique_ptr<AnyPlant> open_plant(std::filesystem::path const& resources, std::string_view token) {
  std::string const missing = names([](Instructions const& i) { return i.compiled && !i.there; });
  need(missing.empty(), "this library was built for a processor with " + missing +
                            "; export the FMU with a package that was built with ROLLERRIG_NATIVE=OFF");
  bool const alone = std::filesystem::exists(resources / "controller.part");
  std::string const name = alone ? "controller.part" : "rig.model";
  std::ifstream file(resources / name, std::ios::binary);
  need(file.good(), "cannot open " + name + " among the resources");
  std::vector<char> const text{std::istreambuf_iterator<char>(file), {}};
  auto const bytes = std::as_bytes(std::span(text));
  std::unique_ptr<AnyPlant> plant;
  if (alone)
    plant = std::make_unique<ControllerPlant>(read_part(bytes));
  else
    plant = std::make_unique<Plant>(read_model(bytes));
  need(token == model_token(bytes), "the token of modelDescription.xml is not that of the model among the resources");
  return plant;
}

}  // namespace rollerrig::fmu
