// scalar.hpp - what the physics may ask of a number.
//
// Every formula below this folder is a template on T and uses only + - * /, comparison, sqrt, sin, ... found by
// argument-dependent lookup, and select(). The same source line then serves double and Dual<N> (exact Jacobians).
//
// Rule: a formula has no `if` on a T: write select(condition, yes, no). Searches (roots, bracketing) run in double;
// one last Newton step in T carries the derivatives (implicit function theorem).
#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>

namespace rollerrig {

/// Both branches are evaluated: keep them finite.
template <class T>
constexpr T select(bool condition, T const& yes, T const& no) {
  return condition ? yes : no;
}

template <class T>
concept Scalar = requires(T a, T b) {
  { a + b } -> std::convertible_to<T>;
  { a * b } -> std::convertible_to<T>;
  { a / b } -> std::convertible_to<T>;
  { select(a < b, a, b) } -> std::same_as<T>;
  T(1.0);
};

/// The plain number inside a scalar, for searches and decisions.
constexpr double value_of(double x) { return x; }

/// A number of a list, or an enumerator, as what [] takes.
template <class I>
constexpr std::size_t at(I i) {
  return static_cast<std::size_t>(i);
}

constexpr double pi = 3.14159265358979323846;

template <Scalar T>
T square(T const& x) {
  return x * x;
}

}  // namespace rollerrig
