// bindings/contact.cpp - contact geometry and laws on their own, for `contact` and for verification.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <ctime>

#include "convert.hpp"
#include "creep_law.hpp"
#include "rollerrig/contact/creep/rolling_reference.hpp"
#include "rollerrig/system/static_wheelset_contact.hpp"

using namespace nb::literals;
using namespace rollerrig;

namespace {

/// Keeps the model alive that the contacts are part of.
struct Press {
  std::shared_ptr<Model const> model;
  WheelsetPress press;
  Press(std::shared_ptr<Model const> shared, int left, int right)
      : model(std::move(shared)),
        press(model->contacts.at(static_cast<std::size_t>(left)), model->contacts.at(static_cast<std::size_t>(right))) {
  }
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
  d["point"] = p.point;
  d["direction"] = p.direction;
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

using Rows3 = nb::ndarray<double const, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Floats = nb::ndarray<float const, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

CreepTable creep_table(double log_aspect_end, double rho_0, int aspects, std::array<int, 3> const& cells,
                       Floats const& coefficients) {
  if (!(log_aspect_end > 0.0) || !(rho_0 > 0.0) || aspects < 1 || *std::min_element(cells.begin(), cells.end()) < 1)
    throw nb::value_error("a creep table needs positive sizes");
  CreepTable table{log_aspect_end, rho_0, aspects, cells, {}};
  if (coefficients.shape(0) != table.size())
    throw nb::value_error("the creep table has not as many coefficients as its shape asks for");
  table.coefficients.assign(coefficients.data(), coefficients.data() + coefficients.shape(0));
  return table;
}

auto creep_forces(Rows3 const& creepage, double a, double b, double load, double friction, double shear_modulus,
                  double poisson_ratio, NamedCreepLaw const& law, double direction) {
  double const log_aspect = std::log(a / b);
  auto const f = kalker_stiffness(KalkerTable(poisson_ratio).at(log_aspect), shear_modulus, a, b, direction);
  std::size_t const n = creepage.shape(0);
  std::vector<double> out(4 * n);
  for (std::size_t i = 0; i < n; ++i) {
    auto const force = creep_force(
        law.law,
        CreepQuery<double>{
            {creepage(i, 0), creepage(i, 1), creepage(i, 2)}, f, friction * load, a, b, log_aspect, direction});
    out[4 * i] = force.longitudinal;
    out[4 * i + 1] = force.lateral;
    out[4 * i + 2] = force.spin_moment;
    out[4 * i + 3] = force.saturation;
  }
  return owned_array<nb::shape<-1, 4>>(std::move(out), {n, 4});
}

auto rolling_solutions(RollingReference& reference, Rows3 const& creepage) {
  std::size_t const n = creepage.shape(0);
  std::vector<double> out(6 * n);
  for (std::size_t i = 0; i < n; ++i) {
    auto const s = reference.solve({creepage(i, 0), creepage(i, 1), creepage(i, 2)});
    double const row[] = {s.longitudinal,         s.lateral, s.spin_moment, s.adhesion, static_cast<double>(s.steps),
                          s.converged ? 1.0 : 0.0};
    std::copy(std::begin(row), std::end(row), &out[6 * i]);
  }
  return owned_array<nb::shape<-1, 6>>(std::move(out), {n, 6});
}

}  // namespace

void bind_contact(nb::module_& m) {
  nb::class_<Press>(m, "WheelsetPress", "A wheelset on its rollers or rails, quasi-static; SI, b frame.")
      .def(nb::init<std::shared_ptr<Model const>, int, int>(), "model"_a, "left"_a, "right"_a)
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
          "seconds_per_contact",
          [](Press& self, double x, double y, double z, double yaw, double roll, bool right, int repeats) {
            std::clock_t const start = std::clock();  // of this process: others on the machine do not count
            for (int i = 0; i < repeats; ++i) self.press.patches({x, y, z, roll, yaw}, right);
            return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / repeats;
          },
          "x"_a, "y"_a, "z"_a, "yaw"_a, "roll"_a, "right"_a, "repeats"_a)
      .def(
          "minima",
          [](Press& self, double x, double y, double z, double yaw, double roll, bool right, double reach) {
            return as_list(self.press.minima({x, y, z, roll, yaw}, right, reach));
          },
          "x"_a, "y"_a, "z"_a, "yaw"_a, "roll"_a, "right"_a, "reach"_a);
  m.def("hertz_ellipse", &hertz_ellipse, "load"_a, "d1"_a, "d2"_a, "shear_modulus"_a, "poisson_ratio"_a,
        "Semi-axes a, b [m], approach [m], peak pressure [Pa] and stiffness [N/m^1.5]; eqs (13)-(19).");
  m.def("kalker_coefficients", &kalker, "a_over_b"_a, "poisson_ratio"_a, "C11, C22, C23, C33.");
  nb::class_<CreepTable>(m, "CreepTable", "The exact theory as a smooth function; see rollerrig.creep.")
      .def_static(
          "of",
          [](double log_aspect_end, double rho_0, int aspects, std::array<int, 3> const& cells,
             Floats const& coefficients) {
            return std::make_shared<CreepTable>(creep_table(log_aspect_end, rho_0, aspects, cells, coefficients));
          },
          "log_aspect_end"_a, "rho_0"_a, "aspects"_a, "cells"_a, "coefficients"_a)
      .def_ro("aspects", &CreepTable::aspects);
  nb::class_<NamedCreepLaw>(m, "CreepLaw", "A creep law and its parameters; see rollerrig.creep.")
      .def(nb::init<std::string const&, bool, std::array<double, 3> const&, std::array<double, 2> const&,
                    std::shared_ptr<CreepTable>>(),
           "name"_a, "saturate_spin_moment"_a, "stiffness_reduction"_a, "polach"_a, "table"_a.none());
  m.def("creep_forces", &creep_forces, "creepage"_a, "a"_a, "b"_a, "load"_a, "friction"_a, "shear_modulus"_a,
        "poisson_ratio"_a, "law"_a, "direction"_a = 1.0,
        "T_x, T_y [N], M_sp [N m] on the wheel and the saturation, per row of creepage.");
  nb::class_<RollingReference>(m, "RollingReference", "Exact rolling contact on an elliptic patch; reduced units.")
      .def(
          "__init__",
          [](RollingReference* self, double a_over_b, double poisson_ratio, double fineness) {
            new (self) RollingReference(a_over_b, poisson_ratio, RollingGrid::for_ellipse(a_over_b, fineness));
          },
          "a_over_b"_a, "poisson_ratio"_a, "fineness"_a)
      .def("solve", &rolling_solutions, "creepage"_a,
           "Force along, across, moment, fraction of the patch that sticks, steps, converged; per row of xi, eta, chi.")
      .def("kalker_coefficients", &RollingReference::kalker_coefficients, "C11, C22, C23, C33 of this grid.");
}
