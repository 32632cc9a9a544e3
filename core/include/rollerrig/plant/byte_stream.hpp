// plant/byte_stream.hpp - numbers and texts to bytes and back: little endian, of fixed size, checked against the end.
//
//   values -> [ByteWriter] -> bytes -> [ByteReader] -> the same values, or FormatError that says where
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace rollerrig {

static_assert(std::endian::native == std::endian::little,
              "files are little endian: swap bytes here for another machine");

struct FormatError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

template <class V>
concept PlainNumber = (std::is_arithmetic_v<V> && !std::is_same_v<V, bool>) || std::is_enum_v<V>;

class ByteWriter {
 public:
  template <PlainNumber V>
  void number(V value) {
    append(&value, sizeof value);
  }
  template <PlainNumber V>
  void numbers(V const* values, std::size_t count) {
    append(values, count * sizeof(V));
  }
  void flag(bool value) { number(static_cast<std::uint8_t>(value)); }
  void count(std::size_t value) { number(static_cast<std::uint64_t>(value)); }
  void text(std::string_view value) {
    count(value.size());
    append(value.data(), value.size());
  }
  std::vector<std::byte> const& bytes() const { return bytes_; }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void append(void const* data, std::size_t size) {
    if (size == 0) return;
    auto const* from = static_cast<std::byte const*>(data);
    bytes_.insert(bytes_.end(), from, from + size);
  }
  std::vector<std::byte> bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(std::span<std::byte const> bytes) : bytes_{bytes} {}

  template <PlainNumber V>
  V number() {
    V value;
    numbers(&value, 1);
    return value;
  }
  template <PlainNumber V>
  void numbers(V* values, std::size_t count) {
    if (count > left() / sizeof(V)) throw FormatError("it ends too early");
    if (count > 0) std::memcpy(values, bytes_.data() + position_, count * sizeof(V));
    position_ += count * sizeof(V);
  }
  bool flag() {
    auto const value = number<std::uint8_t>();
    if (value > 1) throw FormatError("a yes or no is " + std::to_string(value));
    return value == 1;
  }
  /// Of things of at least one byte each: never more than there is room for.
  std::size_t count() {
    auto const value = number<std::uint64_t>();
    if (value > left()) throw FormatError("it ends too early");
    return static_cast<std::size_t>(value);
  }
  std::string text() {
    std::string value(count(), ' ');
    numbers(value.data(), value.size());
    return value;
  }
  std::size_t left() const { return bytes_.size() - position_; }

 private:
  std::span<std::byte const> bytes_;
  std::size_t position_{0};
};

/// CRC-64/XZ: ECMA-182, reflected; of bytes behind others whose checksum is `before`.
std::uint64_t crc64(std::span<std::byte const> bytes, std::uint64_t before = 0);

/// The state of a plant as bytes for plants of the same identity: that, the checksum of both, the state.
std::vector<std::byte> sealed(std::uint64_t identity, std::span<std::byte const> state);
/// Such a state; none: cut, changed, or of another plant. A state is never empty.
std::span<std::byte const> unsealed(std::uint64_t identity, std::span<std::byte const> bytes);

/// Two digits per byte.
std::string hexadecimal(std::span<std::byte const> bytes);

}  // namespace rollerrig
