// plant/archive.hpp - any described struct to bytes and back, by its own list of fields; and that list as a text.
//
//   struct -> [Archive: fields()] -> bytes, in the order of the fields -> the same struct, every number within its range
//
// A struct that names its fields needs nothing here; one that cannot (it stands left of fields.hpp) has its list below. Tables that
// several parts share are written once, at their first place, and referred to by number from then on.
#pragma once
#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "rollerrig/integrate/options.hpp"
#include "rollerrig/plant/byte_stream.hpp"
#include "rollerrig/simulate/setup.hpp"
#include "rollerrig/system/model_parts.hpp"

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
constexpr auto fields_of(std::type_identity<RailLayout> /*of*/) {
  return members(Member{"y", &RailLayout::y}, Member{"z", &RailLayout::z}, Member{"roll", &RailLayout::roll});
}
constexpr auto fields_of(std::type_identity<RailHeads> /*of*/) {
  using P = RailHeads;
  return members(Member{"profiles", &P::profiles, an_index}, Member{"place", &P::place},
                 Member{"period", &P::period, not_negative});
}
constexpr auto fields_of(std::type_identity<Line> /*of*/) {
  using P = Line;
  return members(Member{"curvature", &P::curvature}, Member{"cant", &P::cant}, Member{"cant_base", &P::cant_base},
                 Member{"left", &P::left}, Member{"right", &P::right});
}
constexpr auto fields_of(std::type_identity<Irregularity> /*of*/) {
  using P = Irregularity;
  return members(Member{"period", &P::period}, Member{"left_y", &P::left_y}, Member{"left_z", &P::left_z},
                 Member{"right_y", &P::right_y}, Member{"right_z", &P::right_z}, Member{"fade_in", &P::fade_in},
                 Member{"steered", &P::steered});
}
constexpr auto fields_of(std::type_identity<KalkerStiffness<double>> /*of*/) {
  using P = KalkerStiffness<double>;
  return members(Member{"f11", &P::f11}, Member{"f22", &P::f22}, Member{"f23", &P::f23}, Member{"f33", &P::f33});
}
constexpr auto fields_of(std::type_identity<CreepTable> /*of*/) {
  using P = CreepTable;
  return members(Member{"log_aspect_end", &P::log_aspect_end, positive}, Member{"rho_0", &P::rho_0, positive},
                 Member{"aspects", &P::aspects, table_cells}, Member{"cells", &P::cells, table_cells},
                 Member{"coefficients", &P::coefficients});
}
constexpr auto fields_of(std::type_identity<VirtualRail> /*of*/) {
  using P = VirtualRail;
  return members(Member{"creep", &P::creep}, Member{"friction", &P::friction},
                 Member{"wheel_load", &P::wheel_load, positive}, Member{"a", &P::a, positive},
                 Member{"b", &P::b, positive}, Member{"width", &P::width, positive}, Member{"cell", &P::cell, positive},
                 Member{"wheel_memory", &P::wheel_memory, not_negative}, Member{"sand_kept", &P::sand_kept, fraction},
                 Member{"log_aspect", &P::log_aspect}, Member{"stiffness", &P::stiffness},
                 Member{"creepage_regularisation_speed", &P::creepage_regularisation_speed, not_negative});
}
constexpr auto fields_of(std::type_identity<integrate::Options> /*of*/) {
  using P = integrate::Options;
  return members(Member{"method", &P::method}, Member{"step", &P::step, not_negative},
                 Member{"relative_tolerance", &P::relative_tolerance, positive},
                 Member{"absolute_tolerance", &P::absolute_tolerance, positive},
                 Member{"initial_step", &P::initial_step, not_negative},
                 Member{"maximum_step", &P::maximum_step, positive_or_infinite},
                 Member{"final_time", &P::final_time, positive_or_infinite},
                 Member{"output_step", &P::output_step, not_negative}, Member{"breakpoints", &P::breakpoints},
                 Member{"max_steps", &P::max_steps, Range{1.0, 1e15, "1 to 1e15"}});
}

namespace archive {

template <class V>
constexpr auto fields() {
  return fields_of(std::type_identity<V>{});
}

/// One number for each type.
template <class V>
inline constexpr char type_mark{};

/// Tables that have been met, in the order of their first places.
struct Shared {
  std::map<void const*, std::uint64_t> written;
  std::vector<std::pair<char const*, std::shared_ptr<void const>>> read;  ///< and what each is
};

// ---------------------------------------------------------------------------------------------------- to bytes

template <class V>
void put(ByteWriter& out, Shared& shared, V const& value);

template <class V>
void put(ByteWriter& out, Shared& shared, std::vector<V> const& values) {
  out.count(values.size());
  if constexpr (PlainNumber<V>)
    out.numbers(values.data(), values.size());
  else
    for (auto const& value : values) put(out, shared, value);
}
template <class V, std::size_t n>
void put(ByteWriter& out, Shared& shared, std::array<V, n> const& values) {
  for (V const& value : values) put(out, shared, value);
}
template <class V>
void put(ByteWriter& out, Shared& shared, std::optional<V> const& value) {
  out.flag(value.has_value());
  if (value) put(out, shared, *value);
}
template <class... Laws>
void put(ByteWriter& out, Shared& shared, std::variant<Laws...> const& value) {
  std::visit(
      [&](auto const& law) {
        out.text(law.name);
        put(out, shared, law);
      },
      value);
}
/// 0: none; else its number from 1, and behind a new number the table itself.
template <class V>
void put(ByteWriter& out, Shared& shared, std::shared_ptr<V const> const& value) {
  if (value == nullptr) return out.count(0);
  auto const [place, fresh] = shared.written.try_emplace(value.get(), shared.written.size() + 1);
  out.number(place->second);
  if (fresh) put(out, shared, *value);
}
template <class V>
void put(ByteWriter& out, Shared& shared, V const& value) {
  if constexpr (std::is_same_v<V, bool>)
    out.flag(value);
  else if constexpr (PlainNumber<V>)
    out.number(value);
  else if constexpr (std::is_same_v<V, std::string>)
    out.text(value);
  else
    fields<V>()([&](auto const&... field) { (put(out, shared, value.*field.member), ...); });
}

// ---------------------------------------------------------------------------------------------------- from bytes

template <class V>
void get(ByteReader& in, Shared& shared, V& value);

template <class V>
void get(ByteReader& in, Shared& shared, std::vector<V>& values) {
  std::size_t const count = in.count();
  if constexpr (PlainNumber<V>) {
    if (count > in.left() / sizeof(V)) throw FormatError("it ends too early");
    values.resize(count);
    in.numbers(values.data(), count);
  } else {
    values.clear();
    for (std::size_t i = 0; i < count; ++i) get(in, shared, values.emplace_back());
  }
}
template <class V, std::size_t n>
void get(ByteReader& in, Shared& shared, std::array<V, n>& values) {
  for (V& value : values) get(in, shared, value);
}
template <class V>
void get(ByteReader& in, Shared& shared, std::optional<V>& value) {
  value.reset();
  if (in.flag()) get(in, shared, value.emplace());
}
template <class... Laws>
void get(ByteReader& in, Shared& shared, std::variant<Laws...>& value) {
  std::string const name = in.text();
  auto const read = [&]<class Law>(std::type_identity<Law>) {
    if (name != Law::name) return false;
    get(in, shared, value.template emplace<Law>());
    return true;
  };
  if (!(read(std::type_identity<Laws>{}) || ...)) throw FormatError("it names the law " + name.substr(0, 40));
}
template <class V>
void get(ByteReader& in, Shared& shared, std::shared_ptr<V const>& value) {
  value = nullptr;
  auto const number = in.number<std::uint64_t>();
  if (number == 0) return;
  if (number > shared.read.size() + 1) throw FormatError("a shared table is missing");
  if (number <= shared.read.size()) {
    auto const& [mark, table] = shared.read[static_cast<std::size_t>(number) - 1];
    if (mark != &type_mark<V>) throw FormatError("a shared table is one of another kind");
    value = std::static_pointer_cast<V const>(table);
    return;
  }
  auto made = std::make_shared<V>();
  shared.read.emplace_back(&type_mark<V>, made);
  get(in, shared, *made);
  value = std::move(made);
}
/// What the range says, and that no table is missing.
template <class Struct, class Field>
void check_field(Struct const& owner, Member<Struct, Field> const& field) {
  check_value(owner.*field.member, field.range, "model file", field.label());
  if constexpr (requires { (owner.*field.member) == nullptr; })
    if ((owner.*field.member) == nullptr) throw FormatError(std::string("model file: there is no ") + field.name);
}
template <class Struct, class Field>
void check_field(Struct const& /*owner*/, OptionalMember<Struct, Field> const& /*field*/) {}

template <class V>
void get(ByteReader& in, Shared& shared, V& value) {
  if constexpr (std::is_same_v<V, bool>) {
    value = in.flag();
  } else if constexpr (PlainNumber<V>) {
    value = in.number<V>();
  } else if constexpr (std::is_same_v<V, std::string>) {
    value = in.text();
  } else {
    auto const read = [&](auto const& field) {
      get(in, shared, value.*field.member);
      check_field(value, field);
    };
    fields<V>()([&](auto const&... field) { (read(field), ...); });
    if constexpr (requires { value.check(); }) value.check();
  }
}

/// One value that takes all of the bytes; throws FormatError where it does not.
template <class V>
void get_all(std::span<std::byte const> bytes, V& value) {
  ByteReader in(bytes);
  Shared shared;
  get(in, shared, value);
  if (in.left() > 0) throw FormatError("there are bytes behind its end");
}

// ---------------------------------------------------------------------------------------------------- as a text

/// A line for each field, with its unit behind a comma, and what it is made of below it. Lists: [ ]; what may be missing: ?; a
/// table that may be shared: @; laws: each by its name.
template <class V>
struct Layout {
  static std::string word() {
    if constexpr (std::is_same_v<V, bool>)
      return "bool";
    else if constexpr (std::is_same_v<V, std::string>)
      return "text";
    else if constexpr (PlainNumber<V>)
      return std::string(std::is_floating_point_v<V> ? "f"
                         : std::is_unsigned_v<V>     ? "u"
                                                     : "i")
          .append(std::to_string(8 * sizeof(V)));
    else
      return "";
  }
  static std::string below(std::string const& indent) {
    if constexpr (PlainNumber<V> || std::is_same_v<V, bool> || std::is_same_v<V, std::string>) {
      return "";
    } else {
      auto const line = [&]<class Field>(Field const& field) {
        using Value = std::remove_cvref_t<decltype(std::declval<V&>().*field.member)>;
        std::string const kind = Layout<Value>::word();
        return indent + field.name + std::string(kind.empty() ? "" : " ") + kind + (*field.unit == '\0' ? "" : ", ") +
               field.unit + "\n" + Layout<Value>::below(indent + "  ");
      };
      return fields<V>()([&](auto const&... field) { return (std::string() + ... + line(field)); });
    }
  }
};
template <class V>
struct Layout<std::vector<V>> {
  static std::string word() { return std::string("[").append(Layout<V>::word()) + "]"; }
  static std::string below(std::string const& indent) { return Layout<V>::below(indent); }
};
template <class V, std::size_t n>
struct Layout<std::array<V, n>> {
  static std::string word() { return Layout<V>::word() + " x " + std::to_string(n); }
  static std::string below(std::string const& indent) { return Layout<V>::below(indent); }
};
template <class V>
struct Layout<std::optional<V>> {
  static std::string word() { return Layout<V>::word() + "?"; }
  static std::string below(std::string const& indent) { return Layout<V>::below(indent); }
};
template <class V>
struct Layout<std::shared_ptr<V const>> {
  static std::string word() { return "@"; }
  static std::string below(std::string const& indent) { return Layout<V>::below(indent); }
};
template <class... Laws>
struct Layout<std::variant<Laws...>> {
  static std::string word() { return "law"; }
  static std::string below(std::string const& indent) {
    return (std::string() + ... + (indent + "= " + Laws::name + "\n" + Layout<Laws>::below(indent + "  ")));
  }
};

}  // namespace archive
}  // namespace rollerrig
