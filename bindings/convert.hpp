// bindings/convert.hpp - arrays and vectors between NumPy and the core.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <array>
#include <memory>
#include <vector>

#include "rollerrig/math/piecewise_linear.hpp"
#include "rollerrig/math/vector.hpp"

namespace nb = nanobind;

using Triple = std::array<double, 3>;
using Rows2 = std::vector<std::array<double, 2>>;
using Column = nb::ndarray<double const, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

inline rollerrig::Vec3<double> vec3(Triple const& a) { return {a[0], a[1], a[2]}; }
inline Triple triple(rollerrig::Vec3<double> const& v) { return {v.x, v.y, v.z}; }

inline rollerrig::PiecewiseLinear piecewise(Rows2 const& rows) {
  rollerrig::PiecewiseLinear table;
  for (auto const& row : rows) table.x.push_back(row[0]), table.y.push_back(row[1]);
  return table;
}

/// A NumPy array that owns its memory.
template <class... Shape>
auto owned_array(std::vector<double>&& values, std::initializer_list<std::size_t> shape) {
  auto* data = new std::vector<double>(std::move(values));
  nb::capsule owner(data, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  return nb::ndarray<nb::numpy, double, Shape...>(data->data(), shape, owner);
}
