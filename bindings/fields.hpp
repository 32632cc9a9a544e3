// bindings/fields.hpp - a Python class for any struct that names its fields, and for every law of a registry.
#pragma once
#include <cctype>
#include <string>
#include <string_view>
#include <type_traits>

#include "convert.hpp"

/// Binds a struct by its own list of fields; the class has their names and units as `fields`.
template <rollerrig::Described S>
nb::class_<S> bind_struct(nb::module_& m, char const* name, char const* doc) {
  return S::fields()([&](auto... fields) {
    auto type = bind_description<S>(m, name, doc, fields...);
    nb::dict units;
    ((units[fields.name] = fields.unit), ...);
    type.attr("fields") = units;
    return type;
  });
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
