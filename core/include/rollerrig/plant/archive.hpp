// plant/archive.hpp - any described struct to bytes and back, by its own list of fields; and that list as a text.
//
//   struct -> [Type: fields()] -> bytes, in the order of the fields -> the same struct, every number within its range
//
// A struct that names its fields needs nothing here; one that cannot (it stands left of fields.hpp) has its list below. Tables that
// several parts share are written once, at their first place, and referred to by number from then on. What templates know of a
// type is a Type; whoever goes through values is compiled once, for all of them.
#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "rollerrig/integrate/options.hpp"
#include "rollerrig/plant/byte_stream.hpp"
#include "rollerrig/simulate/setup.hpp"
#include "rollerrig/system/model.hpp"

namespace rollerrig {

inline constexpr Range table_cells{1.0, 1000.0, "between 1 and 1000"};  ///< of a creep table, along one axis

template <Described V>
constexpr auto fields_of(std::type_identity<V> /*of*/) {
  return V::fields();
}

// Of structs that have no list of their own.
constexpr auto fields_of(std::type_identity<Vec3<double>> /*of*/) {
  using P = Vec3<double>;
  return members(Member{"x", &P::x}, Member{"y", &P::y}, Member{"z", &P::z});
}
constexpr auto fields_of(std::type_identity<PiecewiseLinear> /*of*/) {
  return members(Member{"x", &PiecewiseLinear::x}, Member{"y", &PiecewiseLinear::y});
}
constexpr auto fields_of(std::type_identity<TimeTable> /*of*/) { return members(Member{"points", &TimeTable::points}); }
constexpr auto fields_of(std::type_identity<UniformSpline> /*of*/) {
  using P = UniformSpline;
  return members(Member{"start", &P::start}, Member{"step", &P::step}, Member{"pieces", &P::pieces});
}
constexpr auto fields_of(std::type_identity<PiecewiseCubic> /*of*/) {
  return members(Member{"start", &PiecewiseCubic::start}, Member{"coefficient", &PiecewiseCubic::coefficient});
}
constexpr auto fields_of(std::type_identity<CreepTable> /*of*/) {
  using P = CreepTable;
  return members(Member{"log_aspect_end", &P::log_aspect_end, positive}, Member{"rho_0", &P::rho_0, positive},
                 Member{"aspects", &P::aspects, table_cells}, Member{"cells", &P::cells, table_cells},
                 Member{"coefficients", &P::coefficients});
}

namespace archive {

struct Type;
using TypeOf = Type const& (*)();

struct Part {
  char const* name;
  TypeOf type;
  char const* unit{""};
  Range range{finite_number};
  bool may_be_null{false};
};

/// What is known of the values of a type, which the functions below take by their addresses.
struct Type {
  enum Kind { number, flag, text, list, array, optional, shared, laws, fields };
  struct Content {
    void* first;        ///< element, or the law that it is
    std::size_t count;  ///< of elements; of laws the place of the one that it is
  };
  Kind kind;
  TypeOf element{};  ///< of what has any
  Content (*content)(void* value){};
  void (*resize)(void* value, std::size_t count){};  ///< of laws: begins the one of that place
  std::shared_ptr<void> (*make)(){};                 ///< what is shared
  void (*share)(void* value, std::shared_ptr<void const> const& made){};
  std::span<Part const> parts{};
  void* (*field)(void* value, std::size_t part){};
  void (*check)(void* value){};  ///< the struct's own check()
  char letter{};                 ///< of a number: f, u or i
  std::size_t size{};
  void (*check_range)(void* value, Range const& range, Label label){};  ///< throws std::invalid_argument, range.hpp
};

template <class V>
Type const& type_of();

template <class V>
V& as(void* value) {
  return *static_cast<V*>(value);
}

template <class V>
constexpr Type described(std::type_identity<std::vector<V>> /*of*/) {
  using List = std::vector<V>;
  return {.kind = Type::list,
          .element = type_of<V>,
          .content = [](void* value) -> Type::Content { return {as<List>(value).data(), as<List>(value).size()}; },
          .resize = [](void* value, std::size_t count) { as<List>(value).resize(count); }};
}
template <class V, std::size_t n>
constexpr Type described(std::type_identity<std::array<V, n>> /*of*/) {
  return {
      .kind = Type::array, .element = type_of<V>, .content = [](void* value) -> Type::Content { return {value, n}; }};
}
template <class V>
constexpr Type described(std::type_identity<std::optional<V>> /*of*/) {
  using Optional = std::optional<V>;
  Type type{.kind = Type::optional, .element = type_of<V>};
  type.content = [](void* value) -> Type::Content {
    auto& held = as<Optional>(value);
    return {held ? &*held : nullptr, held ? 1u : 0u};
  };
  type.resize = [](void* value, std::size_t count) {
    as<Optional>(value) = count > 0 ? Optional(std::in_place) : std::nullopt;
  };
  return type;
}
template <class V>
constexpr Type described(std::type_identity<std::shared_ptr<V const>> /*of*/) {
  using Pointer = std::shared_ptr<V const>;
  return {.kind = Type::shared,
          .element = type_of<V>,
          .content = [](void* value) -> Type::Content { return {const_cast<V*>(as<Pointer>(value).get()), 1}; },
          .make = []() -> std::shared_ptr<void> { return std::make_shared<V>(); },
          .share =
              [](void* value, std::shared_ptr<void const> const& made) {
                as<Pointer>(value) = std::static_pointer_cast<V const>(made);
              }};
}

template <class... Laws>
inline constexpr std::array<Part, sizeof...(Laws)> parts_of_laws{Part{Laws::name, type_of<Laws>}...};

template <class... Laws>
constexpr Type described(std::type_identity<std::variant<Laws...>> /*of*/) {
  using Registry = std::variant<Laws...>;
  Type type{.kind = Type::laws, .parts = parts_of_laws<Laws...>};
  type.content = [](void* value) -> Type::Content {
    return {std::visit([](auto& law) -> void* { return &law; }, as<Registry>(value)), as<Registry>(value).index()};
  };
  type.resize = [](void* value, std::size_t place) {
    std::size_t i = 0;
    ((i++ == place ? void(as<Registry>(value).template emplace<Laws>()) : void()), ...);
  };
  return type;
}

template <class V>
inline constexpr auto parts_of_struct = fields_of(std::type_identity<V>{})(
    []<template <class, class> class... Kinds, class... Values>(Kinds<V, Values> const&... field) {
      return std::array<Part, sizeof...(field)>{Part{field.name, type_of<Values>, field.unit, field.range,
                                                     std::is_same_v<Kinds<V, Values>, OptionalMember<V, Values>>}...};
    });

template <class V>
constexpr Type described(std::type_identity<V> /*of*/) {
  if constexpr (std::is_same_v<V, bool>) {
    return {.kind = Type::flag};
  } else if constexpr (std::is_same_v<V, std::string>) {
    return {.kind = Type::text};
  } else if constexpr (PlainNumber<V>) {
    return {.kind = Type::number, .letter = std::is_floating_point_v<V> ? 'f' : std::is_unsigned_v<V> ? 'u' : 'i'};
  } else {
    Type type{.kind = Type::fields, .parts = parts_of_struct<V>};
    type.field = [](void* value, std::size_t part) {
      return fields_of(std::type_identity<V>{})([&](auto const&... field) {
        return std::array<void*, sizeof...(field)>{&(as<V>(value).*field.member)...}[part];
      });
    };
    if constexpr (requires(V& value) { value.check(); }) type.check = [](void* value) { as<V>(value).check(); };
    return type;
  }
}

template <class V>
Type const& type_of() {
  static constexpr Type type = [] {
    Type of = described(std::type_identity<V>{});
    of.size = sizeof(V);
    of.check_range = [](void* value, Range const& range, Label label) {
      check_value(as<V>(value), range, "model file", label);
    };
    return of;
  }();
  return type;
}

extern template Type const& type_of<SampledController>();  // compiled with the model file

void put(ByteWriter& out, Type const& type, void const* value);

/// One value that takes all of the bytes; throws FormatError where it does not, std::invalid_argument for a number out of its range.
void get(std::span<std::byte const> bytes, Type const& type, void* value);

/// A line for each field, with its unit behind a comma, and what it is made of below it. Lists: [ ]; what may be missing: ?; a
/// table that may be shared: @; laws: each by its name.
std::string layout(Type const& type, std::string const& indent = "");

}  // namespace archive
}  // namespace rollerrig
