// bindings/contact.cpp - contact geometry and laws on their own, for `contact` and for verification.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "convert.hpp"
#include "rig/system/press.hpp"

using namespace nb::literals;
using namespace rig;

namespace {

/// Owns nothing of the model but keeps it alive through nanobind's keep_alive.
struct Press {
  WheelsetPress press;
  Press(Model const& m, int left, int right)
      : press(m.contacts.at(static_cast<std::size_t>(left)), m.contacts.at(static_cast<std::size_t>(right))) {}
};

nb::dict as_dict(PressedPatch const& p) {
  nb::dict d;
  d["side"] = p.right ? "right" : "left";
  d["wheel_s"] = p.wheel_s;
  d["rail_y"] = p.rail_y;
  d["angle"] = p.angle;
  d["a"] = p.a;
  d["b"] = p.b;
  d["approach"] = p.approach;
  d["normal"] = p.normal;
  d["share"] = p.share;
  d["peak_pressure"] = p.peak_pressure;
  d["width"] = p.width;
  d["area"] = p.area;
  d["point"] = triple(p.point);
  d["direction"] = triple(p.direction);
  d["wheel_radius"] = p.wheel_radius;
  d["limited"] = p.limited;
  return d;
}

nb::list as_list(std::vector<PressedPatch> const& patches) {
  nb::list list;
  for (auto const& p : patches) list.append(as_dict(p));
  return list;
}

std::array<double, 5> hertz_ellipse(double load, double d1, double d2, double shear_modulus, double poisson_ratio) {
  static HertzTable const table;
  Material const material{shear_modulus, poisson_ratio};
  auto const h = hertz_contact(table, material, d1, d2);
  double const approach = std::pow(load / h.stiffness, 2.0 / 3.0);
  double const a = h.a_per_root * std::sqrt(approach);
  double const b = h.b_per_root * std::sqrt(approach);
  return {a, b, approach, 1.5 * load / (pi * a * b), h.stiffness};
}

std::array<double, 4> kalker(double a_over_b, double poisson_ratio) {
  auto const c = KalkerTable(poisson_ratio).at(std::log(a_over_b));
  return {c.c11, c.c22, c.c23, c.c33};
}

std::array<double, 4> creep(std::array<double, 3> const& creepage, double a, double b, double load, double friction,
                            double shear_modulus, double poisson_ratio, std::string const& law, bool saturate) {
  auto const c = KalkerTable(poisson_ratio).at(std::log(a / b));
  auto const f = kalker_stiffness(c, shear_modulus, a, b, 1.0);
  CreepLaw const creep_law{law == "kalker_linear" ? CreepLawKind::kalker_linear : CreepLawKind::kalker_saturated,
                           saturate};
  auto const force =
      creep_force(creep_law, Creepage<double>{creepage[0], creepage[1], creepage[2]}, f, friction * load);
  return {force.longitudinal, force.lateral, force.spin_moment, force.saturation};
}

}  // namespace

void bind_contact(nb::module_& m) {
  nb::class_<Press>(m, "WheelsetPress", "A wheelset on its rollers or rails, quasi-static; SI, b frame.")
      .def(nb::init<Model const&, int, int>(), "model"_a, "left"_a, "right"_a, nb::keep_alive<1, 2>())
      .def(
          "press",
          [](Press& self, double x, double y, double yaw, double roll, double load, bool free_to_roll) {
            auto const r = self.press.press({x, y, 0.0, roll, yaw}, load, free_to_roll);
            nb::dict d;
            d["converged"] = r.converged;
            d["z"] = r.position.z;
            d["roll"] = r.position.roll;
            d["vertical"] = r.vertical;
            d["roll_moment"] = r.roll_moment;
            d["patches"] = as_list(r.patches);
            return d;
          },
          "x"_a, "y"_a, "yaw"_a, "roll"_a, "load"_a, "free_to_roll"_a)
      .def(
          "touch_height",
          [](Press& self, double x, double y, double yaw, double roll, bool right) {
            return self.press.touch_height({x, y, 0.0, roll, yaw}, right);
          },
          "x"_a, "y"_a, "yaw"_a, "roll"_a, "right"_a)
      .def(
          "patches",
          [](Press& self, double x, double y, double z, double yaw, double roll, bool right) {
            return as_list(self.press.patches({x, y, z, roll, yaw}, right));
          },
          "x"_a, "y"_a, "z"_a, "yaw"_a, "roll"_a, "right"_a)
      .def(
          "minima",
          [](Press& self, double x, double y, double z, double yaw, double roll, bool right, double reach) {
            return as_list(self.press.minima({x, y, z, roll, yaw}, right, reach));
          },
          "x"_a, "y"_a, "z"_a, "yaw"_a, "roll"_a, "right"_a, "reach"_a);
  m.def("hertz_ellipse", &hertz_ellipse, "load"_a, "d1"_a, "d2"_a, "shear_modulus"_a, "poisson_ratio"_a,
        "Semi-axes a, b [m], approach [m], peak pressure [Pa] and stiffness [N/m^1.5]; eqs (13)-(19).");
  m.def("kalker_coefficients", &kalker, "a_over_b"_a, "poisson_ratio"_a, "C11, C22, C23, C33.");
  m.def("creep_force", &creep, "creepage"_a, "a"_a, "b"_a, "load"_a, "friction"_a, "shear_modulus"_a, "poisson_ratio"_a,
        "law"_a, "saturate_spin_moment"_a, "T_x, T_y [N], M_sp [N m] on the wheel, and the saturation; eqs (20)-(24).");
}
