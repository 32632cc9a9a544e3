// bindings/model.cpp - the model is assembled from Python, piece by piece.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "convert.hpp"
#include "creep_law.hpp"
#include "rollerrig/system/equilibrium.hpp"
#include "rollerrig/system/model.hpp"

using namespace nb::literals;
using namespace rollerrig;

namespace {

using PieceRows = nb::ndarray<double const, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;
using BreakRows = nb::ndarray<double const, nb::shape<-1, 5>, nb::c_contig, nb::device::cpu>;

template <class Sequence>
auto& element_at(Sequence& sequence, int i) {
  if (i < 0 || i >= static_cast<int>(sequence.size())) throw nb::index_error("no such item in the model");
  return sequence[static_cast<std::size_t>(i)];
}

UniformSpline uniform_spline(double start, double step, PieceRows const& pieces) {
  UniformSpline spline{start, step, {}};
  for (std::size_t i = 0; i < pieces.shape(0); ++i)
    spline.pieces.push_back({pieces(i, 0), pieces(i, 1), pieces(i, 2), pieces(i, 3)});
  return spline;
}

int add_profile(Model& m, double start, double step, PieceRows const& pieces) {
  m.profiles.push_back(uniform_spline(start, step, pieces));
  return static_cast<int>(m.profiles.size()) - 1;
}

PiecewiseCubic piecewise_cubic(BreakRows const& rows) {
  PiecewiseCubic curve;
  for (std::size_t i = 0; i < rows.shape(0); ++i) {
    curve.start.push_back(rows(i, 0));
    curve.coefficient.push_back({rows(i, 1), rows(i, 2), rows(i, 3), rows(i, 4)});
  }
  if (!std::ranges::is_sorted(curve.start, std::less_equal<>{})) throw nb::value_error("breaks must increase");
  return curve;
}

void set_line(Model& m, BreakRows const& curvature, BreakRows const& cant, double cant_base) {
  m.line = {piecewise_cubic(curvature), piecewise_cubic(cant), cant_base};
}

void set_irregularity(Model& m, double period, double step, PieceRows const& left_y, PieceRows const& left_z,
                      PieceRows const& right_y, PieceRows const& right_z, double fade_in, bool steered) {
  for (auto const* rows : {&left_y, &left_z, &right_y, &right_z})
    if (std::abs(step * static_cast<double>(rows->shape(0)) - period) > 1e-9 * period)
      throw nb::value_error("each curve must have period / step pieces");
  auto const spline = [step](PieceRows const& rows) { return uniform_spline(0.0, step, rows); };
  m.irregularity = {period, spline(left_y), spline(left_z), spline(right_y), spline(right_z), fade_in, steered};
}

int add_body(Model& m, double mass, Triple const& inertia, Triple const& position, bool axisymmetric,
             std::array<bool, 6> const& locked, double driven_inverse_radius, bool carried) {
  m.bodies.push_back({mass, vec3(inertia), vec3(position), axisymmetric, locked, driven_inverse_radius > 0.0, carried});
  m.driven_inverse_radius.push_back(driven_inverse_radius);
  return static_cast<int>(m.bodies.size()) - 1;
}

int add_element(Model& m, int a, int b, Triple const& point_on_b, bool carries_load, bool clamped) {
  ForceElement e;
  e.body_a = a, e.body_b = b, e.r_b = vec3(point_on_b), e.carries_load = carries_load, e.clamped = clamped;
  m.elements.push_back(e);
  return static_cast<int>(m.elements.size()) - 1;
}

void set_law(Model& m, int element, int direction, double preload, double stiffness, Rows2 const& table, double damping,
             Rows2 const& damping_table, double series_damping, double series_stiffness) {
  auto& e = element_at(m.elements, element);
  element_at(e.law, direction) = {preload,        stiffness,       piecewise(table), damping, piecewise(damping_table),
                                  series_damping, series_stiffness};
  int node = 0;
  for (auto& each : m.elements)
    for (std::size_t c = 0; c < 6; ++c) each.node[c] = each.law[c].has_state() ? node++ : -1;
}

int add_contact(Model& m, int wheelset, int roller, bool rail, double along, bool right, int wheel_profile,
                int rail_profile, double wheel_radius, double tape_circle_y, double rail_origin_y,
                double inverse_radius, Triple const& wheelset_from_crown, Triple const& crown_in_roller,
                double shear_modulus, double poisson_ratio, Triple const& friction, std::string const& normal,
                NamedCreepLaw const& creep, double normal_damping, double creepage_regularisation_speed,
                double merging_criterion, std::array<bool, 4> const& roller_effects, double damping_onset,
                double size) {
  if (roller == ground && !rail) throw nb::value_error("a contact without a roller is on a rail");
  if (!m.hertz) m.hertz = std::make_shared<HertzTable const>();
  m.kalker_tables.emplace_back(poisson_ratio);
  WheelContact c;
  c.wheelset = wheelset, c.roller = roller, c.rail = rail, c.along = along, c.right = right;
  c.wheelset_from_crown = vec3(wheelset_from_crown), c.crown_in_roller = vec3(crown_in_roller);
  c.pair = {&element_at(m.profiles, wheel_profile),
            &element_at(m.profiles, rail_profile),
            wheel_radius,
            tape_circle_y,
            rail_origin_y,
            inverse_radius,
            {roller_effects[0], roller_effects[1], roller_effects[2], roller_effects[3]},
            size};
  c.laws.roller = c.pair.effects;
  c.laws.material = {shear_modulus, poisson_ratio};
  c.laws.hertz = m.hertz.get();
  c.laws.kalker = &m.kalker_tables.back();
  if (normal == "strips") {
    if (!m.strip_kernel) m.strip_kernel = std::make_shared<StripKernel const>();
    c.laws.normal = NormalContactKind::strips;
    c.laws.strip_kernel = m.strip_kernel.get();
    c.laws.wheel_arc = &m.wheel_arcs.emplace_back(*c.pair.wheel);
  } else if (normal != "hertz") {
    throw nb::value_error("unknown normal contact; known: hertz, strips");
  }
  c.laws.damping = {normal_damping, damping_onset};
  c.laws.creep = creep.law;
  if (creep.table) m.creep_tables.push_back(creep.table);
  c.laws.friction = {friction[0], friction[1], friction[2]};
  c.laws.creepage_regularisation_speed = creepage_regularisation_speed;
  c.laws.merging_criterion = merging_criterion;
  m.contacts.push_back(c);
  return static_cast<int>(m.contacts.size()) - 1;
}

int add_adhesion_map(Model& m, std::vector<std::array<double, 11>> const& pieces, std::vector<double> const& from,
                     double blend, bool over_time) {
  AdhesionMap map;
  map.piece.clear();
  for (auto const& p : pieces)
    map.piece.push_back({{{p[0], p[1], p[2]}, p[3], p[4]}, {{p[5], p[6], p[7]}, p[8], p[9]}, p[10]});
  map.from = from, map.blend = blend, map.over_time = over_time;
  if (map.piece.size() != from.size() + 1) throw nb::value_error("one border less than pieces");
  m.adhesion_maps.push_back(std::move(map));
  return static_cast<int>(m.adhesion_maps.size()) - 1;
}

std::tuple<std::vector<double>, double> preloads(Model const& m) {
  double worst = 0.0;
  auto values = static_preloads(m.bodies, m.elements, m.gravity, worst);
  return {std::move(values), worst};
}

}  // namespace

void bind_model(nb::module_& m) {
  nb::class_<Model>(m, "Model", "Constant data of one assembled system; see rollerrig.assembly.")
      .def(nb::init<>())
      .def("add_profile", &add_profile, "start"_a, "step"_a, "pieces"_a)
      .def("add_body", &add_body, "mass"_a, "inertia"_a, "position"_a, "axisymmetric"_a, "locked"_a,
           "driven_inverse_radius"_a, "carried"_a)
      .def("set_line", &set_line, "curvature"_a, "cant"_a, "cant_base"_a)
      .def("set_irregularity", &set_irregularity, "period"_a, "step"_a, "left_y"_a, "left_z"_a, "right_y"_a,
           "right_z"_a, "fade_in"_a, "steered"_a)
      .def("add_element", &add_element, "body_a"_a, "body_b"_a, "point_on_b"_a, "carries_load"_a, "clamped"_a)
      .def("set_law", &set_law, "element"_a, "direction"_a, "preload"_a, "stiffness"_a, "table"_a, "damping"_a,
           "damping_table"_a, "series_damping"_a, "series_stiffness"_a)
      .def("add_contact", &add_contact, "wheelset"_a, "roller"_a, "rail"_a, "along"_a, "right"_a, "wheel_profile"_a,
           "rail_profile"_a, "wheel_radius"_a, "tape_circle_y"_a, "rail_origin_y"_a, "inverse_radius"_a,
           "wheelset_from_crown"_a, "crown_in_roller"_a, "shear_modulus"_a, "poisson_ratio"_a, "friction"_a, "normal"_a,
           "creep"_a, "normal_damping"_a, "creepage_regularisation_speed"_a, "merging_criterion"_a, "roller_effects"_a,
           "damping_onset"_a, "size"_a)
      .def(
          "add_axle_torque",
          [](Model& model, int wheelset, int reaction, Rows2 const& table) {
            model.axle_torques.push_back({wheelset, reaction, {piecewise(table)}});
          },
          "wheelset"_a, "reaction"_a, "table"_a)
      .def(
          "add_roller_torque",
          [](Model& model, int roller, Rows2 const& table) {
            model.roller_torques.push_back({roller, {piecewise(table)}});
          },
          "roller"_a, "table"_a)
      .def(
          "set_speed", [](Model& model, Rows2 const& table) { model.speed = {piecewise(table)}; }, "table"_a)
      .def("static_preloads", &preloads, "Vertical preload per element [N], and the worst remaining imbalance.")
      .def("add_adhesion_map", &add_adhesion_map, "pieces"_a, "from_"_a, "blend"_a, "over_time"_a,
           "Rows of pieces: mu0, A, B, k_A, k_S degraded, the same recovered, tau.")
      .def(
          "set_friction_map",
          [](Model& model, int contact, int map) {
            element_at(model.contacts, contact).laws.friction.map = &element_at(model.adhesion_maps, map);
          },
          "contact"_a, "map"_a)
      .def(
          "set_resistance",
          [](Model& model, int body, double constant, double linear, double quadratic, double gradient) {
            model.resistance = {body, constant, linear, quadratic, gradient};
          },
          "body"_a, "constant"_a, "linear"_a, "quadratic"_a, "gradient"_a)
      .def_rw("gravity", &Model::gravity)
      .def_rw("contact_loss_limit", &Model::contact_loss_limit);
}
