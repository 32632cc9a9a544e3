// bindings/arguments.hpp - functions and methods whose arguments are checked on their way in: the range beside the name.
//
//   Python call -> [every number against its range] -> the core, or ValueError "function: argument must be ..., got ..."
#pragma once
#include <utility>

#include "convert.hpp"
#include "rollerrig/range.hpp"

/// A parameter's name, and the numbers that it may hold; what is no number is passed on.
struct Argument {
  char const* name;
  rollerrig::Range range{rollerrig::finite_number};
};

namespace rollerrig {

/// Every number of a contiguous array.
template <class... Properties>
void check_value(nb::ndarray<Properties...> const& array, Range const& range, std::string_view owner, Label label) {
  for (std::size_t i = 0; i < array.size(); ++i) check_value(array.data()[i], range, owner, label);
}

}  // namespace rollerrig

using rollerrig::check_value;

/// A function of a module or a static one of a class. `f`: a function, or a lambda without captures behind a `+`.
template <class Result, class... Given, class... Named>
void def_function(nb::module_& m, char const* name, char const* doc, Result (*f)(Given...), Named... arguments) {
  static_assert(sizeof...(Given) == sizeof...(Named));
  m.def(
      name,
      [=](Given... given) -> Result {
        (check_value(given, arguments.range, name, arguments.name), ...);
        return f(std::forward<Given>(given)...);
      },
      nb::arg(arguments.name)..., doc);
}

/// A method from a function whose first argument is the object.
template <class C, class... Extra, class Result, class Self, class... Given, class... Named>
void def_method(nb::class_<C, Extra...>& type, char const* name, char const* doc, Result (*f)(Self, Given...),
                Named... arguments) {
  static_assert(sizeof...(Given) == sizeof...(Named));
  type.def(
      name,
      [=](Self self, Given... given) -> Result {
        (check_value(given, arguments.range, name, arguments.name), ...);
        return f(self, std::forward<Given>(given)...);
      },
      nb::arg(arguments.name)..., doc);
}

/// A method of the class itself.
template <class C, class Result, class... Given, class... Named>
void def_method(nb::class_<C>& type, char const* name, char const* doc, Result (C::*f)(Given...), Named... arguments) {
  static_assert(sizeof...(Given) == sizeof...(Named));
  type.def(
      name,
      [=](C& self, Given... given) -> Result {
        (check_value(given, arguments.range, name, arguments.name), ...);
        return (self.*f)(std::forward<Given>(given)...);
      },
      nb::arg(arguments.name)..., doc);
}
