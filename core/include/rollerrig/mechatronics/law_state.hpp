// mechatronics/law_state.hpp - what changes in a run of whichever law a registry holds.
//
// A sampled law is a constant struct with its parameters and a nested struct State; fields.hpp says how its name and its
// parameters are known to configuration and bindings.
#pragma once
#include <utility>
#include <variant>

namespace rollerrig {

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

/// f(law, its state): the state must have been made by that law.
template <class Function, class Registry>
decltype(auto) visit_with_state(Function&& f, Registry const& law, StateOf<Registry>& state) {
  return std::visit(
      [&]<class Law>(Law const& one) -> decltype(auto) { return f(one, std::get<typename Law::State>(state)); }, law);
}

}  // namespace rollerrig
