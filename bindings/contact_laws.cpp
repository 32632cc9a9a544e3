// bindings/contact_laws.cpp - the laws of a contact and their parameters, each law a class; and laws on their own.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <optional>

#include "arguments.hpp"
#include "fields.hpp"
#include "rollerrig/contact/creep/rolling_reference.hpp"
#include "rollerrig/contact/patch.hpp"

using namespace nb::literals;
using namespace rollerrig;

namespace {

constexpr Range aspect_range{1e-2, 1e2, "between 0.01 and 100"};  ///< a/b that the series and grids are made for
constexpr Range fineness_range{0.1, 4.0, "between 0.1 and 4"};    ///< memory grows with its fourth power
constexpr Range row_elements{2.0, 200.0, "between 2 and 200"};
constexpr std::size_t most_rows = 200;
constexpr Range table_cells{1.0, 1000.0, "between 1 and 1000"};

std::array<double, 5> hertz_ellipse(double load, double d1, double d2, double shear_modulus, double poisson_ratio) {
  auto const h = hertz_contact(Material{shear_modulus, poisson_ratio}, d1, d2);
  double const approach = std::pow(load / h.stiffness, 2.0 / 3.0);
  double const a = h.a_per_root * std::sqrt(approach);
  double const b = h.b_per_root * std::sqrt(approach);
  return {a, b, approach, 1.5 * load / (pi * a * b), h.stiffness};
}

std::array<double, 4> kalker(double a_over_b, double poisson_ratio) {
  auto const c = KalkerTable(poisson_ratio).at(std::log(a_over_b));
  return {c.c11, c.c22, c.c23, c.c33};
}

/// One patch, rolling in a direction: what a creep law is asked besides creepage.
CreepQuery<double> query_of(double a, double b, double adhesion, double shear_modulus, double poisson_ratio,
                            double direction) {
  double const log_aspect = std::log(a / b);
  auto const f = kalker_stiffness(KalkerTable(poisson_ratio).at(log_aspect), shear_modulus, a, b, direction);
  return {{0.0, 0.0, 0.0}, f, adhesion, a, b, log_aspect, direction};
}

KalkerStiffness<double> stiffness(double a, double b, double shear_modulus, double poisson_ratio) {
  return query_of(a, b, 1.0, shear_modulus, poisson_ratio, 1.0).stiffness;
}

/// On an ellipse of a b = 1 with mu N = G = 1: reduced units.
std::array<double, 3> creepage_units(double a_over_b, double poisson_ratio) {
  double const a = std::sqrt(a_over_b);
  auto const demand = demand_per_creepage(query_of(a, 1.0 / a, 1.0, 1.0, poisson_ratio, 1.0));
  return {1.0 / demand[0], 1.0 / demand[1], 1.0 / demand[2]};
}

using Rows3 = nb::ndarray<double const, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Floats = nb::ndarray<float const, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

std::shared_ptr<CreepTable> creep_table(double log_aspect_end, double rho_0, int aspects,
                                        std::array<int, 3> const& cells, Floats const& coefficients) {
  check_value(log_aspect_end, positive, "CreepTable", "log_aspect_end");
  check_value(rho_0, positive, "CreepTable", "rho_0");
  check_value(aspects, table_cells, "CreepTable", "aspects");
  check_value(cells, table_cells, "CreepTable", "cells");
  check_value(coefficients, finite_number, "CreepTable", "coefficients");
  auto table = std::make_shared<CreepTable>(CreepTable{log_aspect_end, rho_0, aspects, cells, {}});
  table->coefficients.assign(coefficients.data(), coefficients.data() + coefficients.shape(0));
  table->check();
  return table;
}

auto friction_over_slip(FrictionLaw const& law, Column const& slip) {
  std::size_t const n = slip.shape(0);
  std::vector<double> out(n);
  for (std::size_t i = 0; i < n; ++i) out[i] = friction_at(law, slip(i));
  return owned_array<nb::ndim<1>>(std::move(out), {n});
}

auto rail_friction(AdhesionMap const& map, Column const& at) {
  std::size_t const n = at.shape(0);
  std::vector<double> out(n);
  for (std::size_t i = 0; i < n; ++i) out[i] = map(at(i), 0.0, 0.0).friction;
  return owned_array<nb::ndim<1>>(std::move(out), {n});
}

auto creep_forces(Rows3 const& creepage, double a, double b, double load, double friction, double shear_modulus,
                  double poisson_ratio, CreepLaw const& law, double direction,
                  std::optional<std::array<double, 2>> const& reduction) {
  char const* const own = "creep_forces";
  check_value(creepage, finite_number, own, "creepage");
  check_value(a, positive, own, "a");
  check_value(b, positive, own, "b");
  check_value(load, positive, own, "load");
  check_value(friction, positive, own, "friction");
  check_value(shear_modulus, positive, own, "shear_modulus");
  check_value(poisson_ratio, poissons_ratio, own, "poisson_ratio");
  check_value(direction, finite_number, own, "direction");
  check_value(reduction, fraction, own, "reduction");
  auto query = query_of(a, b, friction * load, shear_modulus, poisson_ratio, direction);
  std::size_t const n = creepage.shape(0);
  std::vector<double> out(4 * n);
  for (std::size_t i = 0; i < n; ++i) {
    query.creepage = {creepage(i, 0), creepage(i, 1), creepage(i, 2)};
    auto const force = reduction
                           ? creep_force(law, query, RailSurface<double>{friction, (*reduction)[0], (*reduction)[1]})
                           : creep_force(law, query);
    out[4 * i] = force.longitudinal;
    out[4 * i + 1] = force.lateral;
    out[4 * i + 2] = force.spin_moment;
    out[4 * i + 3] = force.saturation;
  }
  return owned_array<nb::shape<-1, 4>>(std::move(out), {n, 4});
}

using PatchRows = nb::ndarray<double const, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;

RollingReference on_rows(PatchRows const& rows, double spacing, double poisson_ratio, int elements) {
  char const* const owner = "RollingReference.on_rows";
  check_value(spacing, positive, owner, "spacing");
  check_value(poisson_ratio, poissons_ratio, owner, "poisson_ratio");
  check_value(elements, row_elements, owner, "elements");
  if (rows.shape(0) == 0 || rows.shape(0) > most_rows)
    throw std::invalid_argument("RollingReference.on_rows: argument must have 1 to 200 rows, got " +
                                std::to_string(rows.shape(0)));
  std::vector<PatchRow> list;
  for (std::size_t i = 0; i < rows.shape(0); ++i) {
    check_value(rows(i, 0), finite_number, owner, "rows");
    check_value(rows(i, 1), finite_number, owner, "rows");
    check_value(rows(i, 2), positive, owner, "rows");
    check_value(rows(i, 3), positive, owner, "rows");
    list.push_back({rows(i, 0), rows(i, 1), rows(i, 2), rows(i, 3)});
  }
  return {list, spacing, poisson_ratio, elements};
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

/// Per row: force along and across, moment about the row's x = 0, converged.
auto bent_solution(RollingReference& reference, Rows3 const& creepage) {
  check_value(creepage, finite_number, "RollingReference.solve_rows", "creepage");
  std::size_t const n = reference.rows();
  if (creepage.shape(0) != n)
    throw std::invalid_argument("RollingReference.solve_rows: creepage must have a row for each of the patch's " +
                                std::to_string(n) + " rows, got " + std::to_string(creepage.shape(0)));
  std::vector<ReducedCreepage> rows;
  for (std::size_t i = 0; i < n; ++i) rows.push_back({creepage(i, 0), creepage(i, 1), creepage(i, 2)});
  double const converged = reference.solve(rows).converged ? 1.0 : 0.0;
  std::vector<double> out;
  for (auto const& row : reference.forces_of_rows())
    out.insert(out.end(), {row.longitudinal, row.lateral, row.moment, converged});
  return owned_array<nb::shape<-1, 4>>(std::move(out), {n, 4});
}

}  // namespace

void bind_contact_laws(nb::module_& m) {
  nb::class_<CreepTable>(m, "CreepTable", "The exact theory as a smooth function; see rollerrig.contact_analysis.")
      .def_static("of", &creep_table, "log_aspect_end"_a, "rho_0"_a, "aspects"_a, "cells"_a, "coefficients"_a)
      .def_ro("aspects", &CreepTable::aspects);
  bind_laws<CreepLaw>(m, "creep_laws");
  bind_laws<NormalLaw>(m, "normal_laws");
  bind_laws<FrictionLaw>(m, "friction_laws");
  bind_struct<RailCondition>(m, "RailCondition", "Friction over slip velocity, and k_A, k_S of the creep curve.");
  bind_struct<RailAdhesion>(m, "RailAdhesion", "A rail that recovers by the energy dissipated on it.");
  bind_struct<AdhesionMap>(m, "AdhesionMap", "Pieces along the rail [m] or over time [s], and where they begin.");
  bind_struct<Friction>(m, "Friction", "One law, or a map in its place.");
  bind_struct<KalkerStiffness<double>>(m, "KalkerStiffness", "f_ij of eq. (22).");
  bind_struct<Material>(m, "Material", "Elastic constants of both bodies.");
  bind_struct<NormalDamping>(m, "NormalDamping", "Damper of eq. (12).");
  bind_struct<RollerEffects>(m, "RollerEffects", "Which of a roller's differences from a rail count.");
  bind_struct<ContactLaws>(m, "ContactLaws", "What a contact is made of.");

  Argument const shear{"shear_modulus", positive}, poisson{"poisson_ratio", poissons_ratio};
  Argument const a{"a", positive}, b{"b", positive}, aspect{"a_over_b", aspect_range};
  def_function(m, "hertz_ellipse",
               "Semi-axes a, b [m], approach [m], peak pressure [Pa] and stiffness [N/m^1.5]; eqs (13)-(19).",
               &hertz_ellipse, Argument{"load", positive}, Argument{"d1", positive}, Argument{"d2", positive}, shear,
               poisson);
  def_function(m, "kalker_coefficients", "C11, C22, C23, C33.", &kalker, aspect, poisson);
  def_function(m, "kalker_stiffness",
               "f11, f22 [N], f23 [N m], f33 [N m^2] of an ellipse with semi-axes a, b [m]; eq. (22).", &stiffness, a,
               b, shear, poisson);
  def_function(m, "creepage_units", "Reduced creepages xi, eta, chi that each demand about mu N of the linear theory.",
               &creepage_units, aspect, poisson);
  def_function(m, "friction_at", "Friction coefficient per slip velocity [m/s], (A1).", &friction_over_slip,
               Argument{"law"}, Argument{"slip"});
  def_function(m, "rail_friction",
               "Friction at no slip of a rail that nothing has cleaned, per place [m] or time [s] of its map.",
               &rail_friction, Argument{"map"}, Argument{"at"});
  m.def("creep_forces", &creep_forces, "creepage"_a, "a"_a, "b"_a, "load"_a, "friction"_a, "shear_modulus"_a,
        "poisson_ratio"_a, "law"_a, "direction"_a = 1.0, "reduction"_a = nb::none(),
        "T_x, T_y [N], M_sp [N m] on the wheel and the saturation, per row of creepage; on a rail with a reduction "
        "k_A, k_S.");
  auto reference =
      nb::class_<RollingReference>(m, "RollingReference", "Exact rolling contact; reduced units. For an ellipse.");
  reference
      .def(
          "__init__",
          [](RollingReference* self, double a_over_b, double poisson_ratio, double fineness) {
            check_value(a_over_b, aspect_range, "RollingReference", "a_over_b");
            check_value(poisson_ratio, poissons_ratio, "RollingReference", "poisson_ratio");
            check_value(fineness, fineness_range, "RollingReference", "fineness");
            new (self) RollingReference(a_over_b, poisson_ratio, RollingGrid::for_ellipse(a_over_b, fineness));
          },
          "a_over_b"_a, "poisson_ratio"_a, "fineness"_a)
      .def_static(
          "on_rows", &on_rows, "rows"_a, "spacing"_a, "poisson_ratio"_a, "elements"_a,
          "For a patch given by rows: y and x of the middle, half-length [c], load, rising y at equal spacing.");
  def_method(
      reference, "solve",
      "Force along, across, moment, fraction of the patch that sticks, steps, converged; per row of xi, eta, chi.",
      +[](RollingReference& self, Rows3 const& creepage) { return rolling_solutions(self, creepage); },
      Argument{"creepage"});
  reference.def("solve_rows", &bent_solution, "creepage"_a,
                "Force along, across, moment about its own x = 0, converged, per row; each with its own xi, eta, chi.");
}
