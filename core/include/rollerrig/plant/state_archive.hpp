// plant/state_archive.hpp - everything that changes in a run to bytes and back, number by number.
//
//   objects with state(archive) -> [StateWriter] -> bytes -> [StateReader] -> the same objects of the same model
//
// A class that changes in a run lists its members in `state`; what can be copied byte by byte needs no list. The bytes are for this
// build and this model alone; whoever keeps them adds a checksum (plant.cpp).
#pragma once
#include <array>
#include <optional>
#include <type_traits>
#include <variant>
#include <vector>

#include "rollerrig/plant/byte_stream.hpp"

namespace rollerrig {

/// What both directions share: how a value is taken apart.
template <class Archive>
class StateArchive {
 public:
  template <class... Values>
  void operator()(Values&... values) {
    (one(values), ...);
  }

 private:
  Archive& self() { return static_cast<Archive&>(*this); }

  template <class V>
  static constexpr bool listed = requires(V& value, Archive& archive) { value.state(archive); };
  template <class V>
  static constexpr bool plain = !listed<V> && std::is_trivially_copyable_v<V>;

  template <class V>
  void one(V& value) {
    static_assert(!std::is_pointer_v<V>);
    if constexpr (listed<V>) {
      value.state(self());
    } else if constexpr (plain<V>) {
      self().raw(&value, sizeof(V));
    } else if constexpr (requires { value.rows(), value.cols(), value.resize(0, 0); }) {
      matrix(value);
    } else {
      parts(value);
    }
  }
  template <class M>
  void matrix(M& value) {
    auto const rows = self().size(static_cast<std::size_t>(value.rows()));
    auto const columns = self().size(static_cast<std::size_t>(value.cols()));
    if constexpr (Archive::reading) value.resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
    self().raw(value.data(), rows * columns * sizeof(*value.data()));
  }
  template <class V>
  void parts(std::vector<V>& values) {
    std::size_t const count = self().size(values.size());
    if constexpr (Archive::reading && std::is_default_constructible_v<V>) values.resize(count);
    if (values.size() != count) throw FormatError("the state of another model");
    if constexpr (plain<V>)
      self().raw(values.data(), count * sizeof(V));
    else
      for (V& value : values) one(value);
  }
  template <class V, std::size_t n>
  void parts(std::array<V, n>& values) {
    for (V& value : values) one(value);
  }
  template <class V, std::size_t n>
  void parts(V (&values)[n]) {
    for (V& value : values) one(value);
  }
  /// Of the one law that a run has.
  template <class... Laws>
  void parts(std::variant<Laws...>& value) {
    if (self().size(value.index()) != value.index()) throw FormatError("the state of another law");
    std::visit([&](auto& law) { one(law); }, value);
  }
};

class StateWriter : public StateArchive<StateWriter> {
 public:
  static constexpr bool reading = false;
  ByteWriter out;

  std::size_t size(std::size_t value) {
    out.count(value);
    return value;
  }
  void raw(void const* data, std::size_t size) { out.numbers(static_cast<std::byte const*>(data), size); }
};

class StateReader : public StateArchive<StateReader> {
 public:
  static constexpr bool reading = true;
  ByteReader in;

  explicit StateReader(std::span<std::byte const> bytes) : in{bytes} {}

  std::size_t size(std::size_t /*value*/) { return in.count(); }
  void raw(void* data, std::size_t size) { in.numbers(static_cast<std::byte*>(data), size); }
};

}  // namespace rollerrig
