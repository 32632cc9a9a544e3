// plant/state_archive.hpp - everything that changes in a run to bytes and back, number by number.
//
//   objects with state(archive) -> [StateWriter] -> bytes -> [StateReader] -> the same objects of the same model
//                               -> [StateNumbers] -> real numbers, to be changed one by one
//
// A class that changes in a run lists its members in `state`; what follows from the model is not among them. The bytes are for
// this build and this model alone. The reader goes into objects that have just begun: lists have the lengths that they have there,
// and what is an index, a count, a flag or a law is checked as it is read: FormatError.
#pragma once
#include <array>
#include <cmath>
#include <type_traits>
#include <variant>
#include <vector>

#include "rollerrig/plant/byte_stream.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// What both directions share: how a value is taken apart.
template <class Archive>
class StateArchive {
 public:
  template <class... Values>
  void operator()(Values&... values) {
    (one(values), ...);
  }
  /// A list that is as long as it happens to be in a run, up to `most`.
  template <class V>
  void list(std::vector<V>& values, std::size_t most) {
    std::size_t const count = self().size(values.size());
    need(count <= most);
    if constexpr (Archive::reading) values.resize(count);
    elements(values.data(), count);
  }
  /// An index, a count or a number of an enumeration.
  template <class V>
  void within(V& value, V least, V most) {
    self().numbers(&value, 1);
    need(value >= least && value <= most);
  }
  /// A time, which may be infinite: never.
  void time(double& value) {
    self().raw(&value, 1);
    need(!std::isnan(value));
  }
  /// What holds in every run.
  void need(bool condition) const {
    if (Archive::reading && !condition) throw FormatError("no state of a run");
  }

 private:
  Archive& self() { return static_cast<Archive&>(*this); }

  template <class V>
  void one(V& value) {
    if constexpr (requires { value.state(self()); })
      value.state(self());
    else if constexpr (std::is_same_v<V, bool>)
      value = self().flag(value);
    else if constexpr (std::is_arithmetic_v<V>)
      self().numbers(&value, 1);
    else if constexpr (requires { value.rows(), value.cols(), value.resize(0, 0); }) {
      need(self().size(at(value.size())) == at(value.size()));
      self().numbers(value.data(), at(value.size()));
    } else if constexpr (!std::is_empty_v<V>)
      parts(value);
  }
  template <class V>
  void elements(V* values, std::size_t count) {
    if constexpr (std::is_arithmetic_v<V> && !std::is_same_v<V, bool>)
      self().numbers(values, count);
    else
      for (std::size_t i = 0; i < count; ++i) one(values[i]);
  }
  template <class V>
  void parts(std::vector<V>& values) {
    need(self().size(values.size()) == values.size());
    elements(values.data(), values.size());
  }
  template <class V, std::size_t n>
  void parts(std::array<V, n>& values) {
    elements(values.data(), n);
  }
  template <class V, std::size_t n>
  void parts(V (&values)[n]) {
    elements(values, n);
  }
  /// Of the one law that a run has.
  template <class... Laws>
  void parts(std::variant<Laws...>& value) {
    need(self().size(value.index()) == value.index());
    std::visit([&](auto& law) { one(law); }, value);
  }
};

class StateWriter : public StateArchive<StateWriter> {
 public:
  static constexpr bool reading = false;
  ByteWriter out;

  std::size_t size(std::size_t value) {
    out.number(static_cast<std::uint64_t>(value));
    return value;
  }
  bool flag(bool value) {
    out.flag(value);
    return value;
  }
  template <class V>
  void numbers(V const* values, std::size_t count) {
    out.numbers(values, count);
  }
  void raw(double const* values, std::size_t count) { out.numbers(values, count); }
};

class StateReader : public StateArchive<StateReader> {
 public:
  static constexpr bool reading = true;
  ByteReader in;

  explicit StateReader(std::span<std::byte const> bytes) : in{bytes} {}

  std::size_t size(std::size_t /*value*/) { return at(in.number<std::uint64_t>()); }
  bool flag(bool /*value*/) { return in.flag(); }
  template <class V>
  void numbers(V* values, std::size_t count) {
    in.numbers(values, count);
    if constexpr (std::is_floating_point_v<V>)
      for (std::size_t i = 0; i < count; ++i) all_finite_ = all_finite_ && std::isfinite(values[i]);
  }
  void raw(double* values, std::size_t count) { in.numbers(values, count); }

  /// Nothing is left; what has not ended is finite: only the last step of a run may be anything else.
  void end(bool run_is_over) const { need(in.left() == 0 && (all_finite_ || run_is_over)); }

 private:
  bool all_finite_{true};
};

/// The real numbers of a state, by where they stand: for differences about it.
class StateNumbers : public StateArchive<StateNumbers> {
 public:
  static constexpr bool reading = false;
  std::vector<double*> places;

  std::size_t size(std::size_t value) { return value; }
  bool flag(bool value) { return value; }
  template <class V>
  void numbers(V* values, std::size_t count) {
    if constexpr (std::is_same_v<V, double>)
      for (std::size_t i = 0; i < count; ++i) places.push_back(values + i);
  }
  void raw(double* values, std::size_t count) { numbers(values, count); }
};

}  // namespace rollerrig
