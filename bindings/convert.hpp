// bindings/convert.hpp - arrays, vectors, tables and records between Python and the core.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/integrate/options.hpp"
#include "rollerrig/math/curves.hpp"
#include "rollerrig/math/vector.hpp"

namespace nb = nanobind;

using Column = nb::ndarray<double const, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Matrix = nb::ndarray<double const, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

namespace nanobind::detail {

/// A value that Python sees as `Plain`: `to` and `from` translate.
template <class Inner, class Plain, Inner (*from)(Plain const&), Plain (*to)(Inner const&)>
struct translated_caster {
  NB_TYPE_CASTER(Inner, make_caster<Plain>::Name)

  bool from_python(handle source, uint8_t flags, cleanup_list* cleanup) noexcept {
    make_caster<Plain> plain;
    if (!plain.from_python(source, flags, cleanup)) return false;
    value = from(plain.operator cast_t<Plain&>());
    return true;
  }
  static handle from_cpp(Inner const& source, rv_policy policy, cleanup_list* cleanup) noexcept {
    return make_caster<Plain>::from_cpp(to(source), policy, cleanup);
  }
};

using Triple = std::array<double, 3>;
using Rows2 = std::vector<std::array<double, 2>>;
using Rows5 = std::vector<std::array<double, 5>>;

inline rollerrig::Vec3<double> vector_from(Triple const& a) { return {a[0], a[1], a[2]}; }
inline Triple triple_from(rollerrig::Vec3<double> const& v) { return {v.x, v.y, v.z}; }

inline rollerrig::PiecewiseLinear table_from(Rows2 const& rows) {
  rollerrig::PiecewiseLinear table;
  for (auto const& row : rows) table.x.push_back(row[0]), table.y.push_back(row[1]);
  return table;
}
inline Rows2 rows_from(rollerrig::PiecewiseLinear const& table) {
  Rows2 rows;
  for (std::size_t i = 0; i < table.x.size(); ++i) rows.push_back({table.x[i], table.y[i]});
  return rows;
}
inline rollerrig::PiecewiseCubic curve_from(Rows5 const& rows) {
  rollerrig::PiecewiseCubic curve;
  for (auto const& [start, c0, c1, c2, c3] : rows)
    curve.start.push_back(start), curve.coefficient.push_back({c0, c1, c2, c3});
  return curve;
}
inline Rows5 rows_from_curve(rollerrig::PiecewiseCubic const& curve) {
  Rows5 rows;
  for (std::size_t i = 0; i < curve.start.size(); ++i) {
    auto const& c = curve.coefficient[i];
    rows.push_back({curve.start[i], c[0], c[1], c[2], c[3]});
  }
  return rows;
}
inline rollerrig::TimeTable time_table_from(Rows2 const& rows) { return {table_from(rows)}; }
inline Rows2 rows_from_time_table(rollerrig::TimeTable const& table) { return rows_from(table.points); }

inline constexpr char const* method_names[] = {"rk4", "exponential_rk4", "exponential_adams", "dormand_prince",
                                               "rodas4"};  ///< of integrate::Method
inline rollerrig::integrate::Method method_named(std::string const& name) {
  auto const found = std::find(std::begin(method_names), std::end(method_names), name);
  return static_cast<rollerrig::integrate::Method>(found - std::begin(method_names));  // another one: Options::check()
}
inline std::string name_of_method(rollerrig::integrate::Method const& method) {
  return method_names[static_cast<std::size_t>(method)];
}

template <>
struct type_caster<rollerrig::integrate::Method>
    : translated_caster<rollerrig::integrate::Method, std::string, method_named, name_of_method> {};
template <>
struct type_caster<rollerrig::Vec3<double>>
    : translated_caster<rollerrig::Vec3<double>, Triple, vector_from, triple_from> {};
template <>
struct type_caster<rollerrig::PiecewiseLinear>
    : translated_caster<rollerrig::PiecewiseLinear, Rows2, table_from, rows_from> {};
template <>
struct type_caster<rollerrig::PiecewiseCubic>
    : translated_caster<rollerrig::PiecewiseCubic, Rows5, curve_from, rows_from_curve> {};
template <>
struct type_caster<rollerrig::TimeTable>
    : translated_caster<rollerrig::TimeTable, Rows2, time_table_from, rows_from_time_table> {};

}  // namespace nanobind::detail

using rollerrig::Member;

/// Binds a struct that the core returns: its fields by name, to be read.
template <class Record, class... Values>
nb::class_<Record> bind_result(nb::module_& m, char const* name, char const* doc, Member<Record, Values>... fields) {
  nb::class_<Record> type(m, name, doc);
  (type.def_ro(fields.name, fields.member), ...);
  return type;
}

/// A NumPy array that owns its memory.
template <class... Shape>
auto owned_array(std::vector<double>&& values, std::initializer_list<std::size_t> shape) {
  auto* data = new std::vector<double>(std::move(values));
  nb::capsule owner(data, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  return nb::ndarray<nb::numpy, double, Shape...>(data->data(), shape, owner);
}
