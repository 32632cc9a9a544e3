// bindings/fields.hpp - a Python class for any struct that names its fields, and for every law of a registry.
#pragma once
#include <cctype>
#include <string>
#include <string_view>
#include <type_traits>

#include "convert.hpp"

template <template <class, class> class Kind, class Record, class Value>
auto keyword(Kind<Record, Value> const& field) {
  if constexpr (std::is_same_v<Kind<Record, Value>, rollerrig::OptionalMember<Record, Value>>)
    return nb::arg(field.name).none();
  else
    return nb::arg(field.name);
}

/// mass that these axles carry and brake, M [kg]
inline std::string docstring(std::string meaning, std::string_view unit) {
  return unit.empty() ? meaning : meaning.append(" [").append(unit).append("]");
}

/// Whatever kind of field: one compiled copy for all of a class that hold the same type.
template <class Record, class Value>
void bind_field(nb::class_<Record>& type, nb::dict& units, char const* name, Value Record::* member,
                char const* meaning, char const* unit) {
  type.def_ro(name, member, docstring(meaning, unit).c_str());
  units[name] = unit;
}

/// Binds a struct by its own list of fields: Python gives every one of them by name, each within its range and together as the
/// struct's own check() asks, and may read it: defaults live in Python. Nothing of it can be written, so that what was checked stays
/// so. The class has their names and units as `fields`.
template <rollerrig::Described S>
nb::class_<S> bind_struct(nb::module_& m, char const* name, char const* doc) {
  nb::class_<S> type(m, name, doc);
  nb::dict units;
  S::fields()([&]<template <class, class> class... Members, class... Values>(Members<S, Values> const&... field) {
    auto const make = [owner = std::string(name)](S* self, Values... values) {
      S::fields()([&](auto const&... own) {
        (check_value(values, own.range, owner, own.label()), ...);
        S made{};
        ((made.*own.member = std::move(values)), ...);
        if constexpr (requires { made.check(); }) made.check();
        new (self) S(std::move(made));
      });
    };
    if constexpr (sizeof...(field) == 0)
      type.def("__init__", make);
    else
      type.def("__init__", make, nb::kw_only(), keyword(field)...);
    (bind_field(type, units, field.name, field.member, field.meaning, field.unit), ...);
  });
  type.attr("fields") = units;
  return type;
}

/// The numbers of a struct that the core counts in, by name.
template <rollerrig::Described S>
nb::dict dict_of(S const& s) {
  nb::dict d;
  S::fields()([&](auto const&... field) { ((d[field.name] = s.*field.member), ...); });
  return d;
}

/// kalker_saturated -> KalkerSaturated; with a family behind it where names alone say too little
inline std::string class_name(std::string_view name, std::string_view family) {
  std::string out;
  bool start = true;
  for (char const c : name) {
    if (c != '_') out += start ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    start = c == '_';
  }
  return out.append(family);
}

/// Binds every law of a registry, and the registry itself: name in a configuration -> class, which ends in `family`.
template <class Registry>
void bind_laws(nb::module_& m, char const* registry, std::string_view family = "") {
  nb::dict classes;
  [&]<class... Laws>(std::type_identity<std::variant<Laws...>>) {
    ((classes[Laws::name] = bind_struct<Laws>(m, class_name(Laws::name, family).c_str(), Laws::name)), ...);
  }(std::type_identity<Registry>{});
  m.attr(registry) = classes;
}
