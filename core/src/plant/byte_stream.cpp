#include "rollerrig/plant/byte_stream.hpp"

#include <array>

namespace rollerrig {
namespace {

constexpr std::array<std::uint64_t, 256> crc_table() {
  std::array<std::uint64_t, 256> table{};
  for (std::uint64_t i = 0; i < table.size(); ++i) {
    std::uint64_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0xC96C5795D7870F42ULL : 0ULL);
    table[i] = value;
  }
  return table;
}

}  // namespace

std::uint64_t crc64(std::span<std::byte const> bytes) {
  static constexpr auto table = crc_table();
  std::uint64_t crc = ~0ULL;
  for (std::byte const byte : bytes) crc = table[(crc ^ std::to_integer<std::uint64_t>(byte)) & 0xFF] ^ (crc >> 8);
  return ~crc;
}

}  // namespace rollerrig
