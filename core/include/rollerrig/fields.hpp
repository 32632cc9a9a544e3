// fields.hpp - names for the data members of a struct, so that bindings and tests need no second list of them.
//
//   struct with fields() -> [one loop in the bindings] -> class of the same members, in the same words
//
// A law that a configuration can ask for has a name as well; a std::variant over such laws is their registry:
//
//     struct MyLaw {
//       static constexpr char const* name = "my_law";
//       double gain{1.0};  ///< [-]
//       static constexpr auto fields() { return std::tuple{Member{"gain", &MyLaw::gain}}; }
//     };
#pragma once
#include <concepts>
#include <tuple>
#include <variant>

#include "rollerrig/range.hpp"

namespace rollerrig {

/// A data member, its name and the numbers that it may hold.
template <class Struct, class Value>
struct Member {
  char const* name;
  Value Struct::* member;
  Range range{finite_number};
};

/// The same of a pointer that may be null.
template <class Struct, class Value>
struct OptionalMember {
  char const* name;
  Value Struct::* member;
  Range range{finite_number};
};

/// A struct that names its fields, in the order of its members.
template <class S>
concept Described = requires { S::fields(); };

/// Every field of a struct against its range; throws std::invalid_argument with the owner's and the field's name.
template <Described S>
void check_fields(S const& s, std::string_view owner) {
  std::apply([&](auto const&... field) { (check_value(s.*field.member, field.range, owner, field.name), ...); },
             S::fields());
}

/// One of several laws, with the name that a configuration knows it by.
template <class L>
concept NamedLaw = Described<L> && requires {
  { L::name } -> std::convertible_to<char const*>;
};

/// Registry of laws: a closed set, chosen from at run time by a switch, not by virtual calls.
template <NamedLaw... Laws>
using OneOf = std::variant<Laws...>;

}  // namespace rollerrig
