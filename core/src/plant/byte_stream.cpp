#include "rollerrig/plant/byte_stream.hpp"

#include <array>

namespace rollerrig {
namespace {

using Tables = std::array<std::array<std::uint64_t, 256>, 8>;

/// Of a byte, and of one with k zero bytes behind it: eight bytes are taken at a time.
constexpr Tables crc_tables() {
  Tables tables{};
  for (std::uint64_t i = 0; i < 256; ++i) {
    std::uint64_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0xC96C5795D7870F42ULL : 0ULL);
    tables[0][i] = value;
  }
  for (std::size_t k = 1; k < tables.size(); ++k)
    for (std::size_t i = 0; i < 256; ++i) tables[k][i] = (tables[k - 1][i] >> 8) ^ tables[0][tables[k - 1][i] & 0xFF];
  return tables;
}

}  // namespace

std::uint64_t crc64(std::span<std::byte const> bytes, std::uint64_t before) {
  static constexpr Tables tables = crc_tables();
  std::uint64_t crc = ~before;
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    std::uint64_t word;
    std::memcpy(&word, bytes.data() + i, sizeof word);
    word ^= crc;
    crc = 0;
    for (std::size_t k = 0; k < 8; ++k) crc ^= tables[7 - k][(word >> (8 * k)) & 0xFF];
  }
  for (; i < bytes.size(); ++i) crc = tables[0][(crc ^ std::to_integer<std::uint64_t>(bytes[i])) & 0xFF] ^ (crc >> 8);
  return ~crc;
}

std::vector<std::byte> sealed(std::uint64_t identity, std::span<std::byte const> state) {
  ByteWriter out;
  out.number(identity);
  out.number(crc64(state, identity));
  out.numbers(state.data(), state.size());
  return out.take();
}

std::span<std::byte const> unsealed(std::uint64_t identity, std::span<std::byte const> bytes) {
  constexpr std::size_t head = 2 * sizeof(std::uint64_t);
  if (bytes.size() < head) return {};
  ByteReader in(bytes);
  auto const owner = in.number<std::uint64_t>(), expected = in.number<std::uint64_t>();
  auto const state = bytes.subspan(head);
  return owner == identity && crc64(state, identity) == expected ? state : std::span<std::byte const>{};
}

std::string hexadecimal(std::span<std::byte const> bytes) {
  std::string text;
  for (std::byte const byte : bytes)
    for (int const shift : {4, 0}) text += "0123456789abcdef"[(std::to_integer<int>(byte) >> shift) & 15];
  return text;
}

}  // namespace rollerrig
