// fields.hpp - the data members of a struct: name, unit, meaning and range of each, stated once.
//
//   struct with fields() -> [one loop] -> class in Python, parameters of an FMU, model file, messages
//
// A law that a configuration can ask for has a name as well; a std::variant over such laws is their registry:
//
//     struct MyLaw {
//       static constexpr char const* name = "my_law";
//       double gain{1.0};
//       static constexpr auto fields() { return members(Member{"gain", &MyLaw::gain, "1", "gain on the error"}); }
//     };
#pragma once
#include <concepts>
#include <utility>
#include <variant>

#include "rollerrig/range.hpp"

namespace rollerrig {

/// A data member: of a number the unit, "1" for none, and the meaning, a noun with what it stands for in the formulas.
template <class Struct, class Value>
struct Member {
  char const* name;
  Value Struct::* member;
  char const* unit;  ///< of a table over something: of its values; empty: of no single number
  char const* meaning;
  Range range;

  constexpr Member(char const* own, Value Struct::* at, Range within = finite_number)
      : Member(own, at, "", "", within) {}
  constexpr Member(char const* own, Value Struct::* at, char const* in, char const* means, Range within = finite_number)
      : name{own}, member{at}, unit{in}, meaning{means}, range{within} {}

  constexpr Label label() const { return {name, unit}; }
  constexpr bool complete() const {
    bool const number = std::same_as<Value, double> || std::same_as<Value, std::optional<double>>;
    return !number || (*unit != '\0' && *meaning != '\0');
  }
};

/// The same of a pointer that may be null.
template <class Struct, class Value>
struct OptionalMember {
  char const* name;
  Value Struct::* member;
  char const* unit{""};
  char const* meaning{""};
  Range range{finite_number};

  constexpr Label label() const { return {name, unit}; }
  constexpr bool complete() const { return true; }
};
template <class Struct, class Value, class... Rest>  // Clang before 17 deduces no aggregates
OptionalMember(char const*, Value Struct::*, Rest...) -> OptionalMember<Struct, Value>;

/// The fields of a struct in the order of its members, to be called with a function that takes all of them. (A std::tuple of
/// them took 9 of the 23 s in which a compiler reads all laws.)
template <class... Members>
constexpr auto members(Members... all) {
  return [=](auto&& visit) -> decltype(auto) { return visit(all...); };
}

template <class S>
concept Described = requires { S::fields(); };

/// Whether each number of a struct, not of the structs in it, has a unit and a meaning.
template <Described S>
constexpr bool every_number_has_a_unit = S::fields()([](auto const&... field) { return (field.complete() && ...); });

/// Every field of a struct against its range; throws std::invalid_argument with the owner's and the field's name.
template <Described S>
void check_fields(S const& s, std::string_view owner) {
  S::fields()([&](auto const&... field) { (check_value(s.*field.member, field.range, owner, field.label()), ...); });
}

/// One of several laws, with the name that a configuration knows it by.
template <class L>
concept NamedLaw = Described<L> && requires {
  { L::name } -> std::convertible_to<char const*>;
};

/// Registry of laws: a closed set, chosen from at run time by a switch, not by virtual calls.
template <NamedLaw... Laws>
using OneOf = std::variant<Laws...>;

// What changes in a run of whichever law a registry holds.
//
// A sampled law is a constant struct with its parameters and a nested struct State; fields.hpp says how its name and its
// parameters are known to configuration and bindings.

namespace registry {
template <class Registry>
struct States;
template <class... Laws>
struct States<std::variant<Laws...>> {
  using Type = std::variant<typename Laws::State...>;
};
}  // namespace registry

/// The state of whichever law a registry holds.
template <class Registry>
using StateOf = typename registry::States<Registry>::Type;

/// Of a law whose state begins with nothing.
template <class Registry>
StateOf<Registry> first_state(Registry const& law) {
  return std::visit([]<class Law>(Law const&) { return StateOf<Registry>{typename Law::State{}}; }, law);
}

/// f(law, its state): the state must have been made by that law.
template <class Function, class Registry>
decltype(auto) visit_with_state(Function&& f, Registry const& law, StateOf<Registry>& state) {
  return std::visit(
      [&]<class Law>(Law const& one) -> decltype(auto) { return f(one, std::get<typename Law::State>(state)); }, law);
}

}  // namespace rollerrig
