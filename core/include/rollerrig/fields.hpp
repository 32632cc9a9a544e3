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

namespace rollerrig {

/// A data member and its name.
template <class Struct, class Value>
struct Member {
  char const* name;
  Value Struct::* member;
};

/// The same of a pointer that may be null.
template <class Struct, class Value>
struct OptionalMember {
  char const* name;
  Value Struct::* member;
};

/// A struct that names its fields, in the order of its members.
template <class S>
concept Described = requires { S::fields(); };

/// One of several laws, with the name that a configuration knows it by.
template <class L>
concept NamedLaw = Described<L> && requires {
  { L::name } -> std::convertible_to<char const*>;
};

/// Registry of laws: a closed set, chosen from at run time by a switch, not by virtual calls.
template <NamedLaw... Laws>
using OneOf = std::variant<Laws...>;

}  // namespace rollerrig
