// bindings/model.cpp - descriptions of a model's parts, and the builder that makes a constant model of them.
#include "rollerrig/system/model.hpp"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/variant.h>

#include "arguments.hpp"
#include "fields.hpp"
#include "rollerrig/system/model_builder.hpp"
#include "rollerrig/system/starting_state.hpp"
#include "rollerrig/system/statics.hpp"

using namespace nb::literals;
using namespace rollerrig;

namespace {

using PieceRows = nb::ndarray<double const, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;
using BreakRows = nb::ndarray<double const, nb::shape<-1, 5>, nb::c_contig, nb::device::cpu>;

UniformSpline uniform_spline(double start, double step, PieceRows const& pieces) {
  UniformSpline spline{start, step, {}};
  for (std::size_t i = 0; i < pieces.shape(0); ++i)
    spline.pieces.push_back({pieces(i, 0), pieces(i, 1), pieces(i, 2), pieces(i, 3)});
  return spline;
}

PiecewiseCubic piecewise_cubic(BreakRows const& rows) {
  PiecewiseCubic curve;
  for (std::size_t i = 0; i < rows.shape(0); ++i) {
    curve.start.push_back(rows(i, 0));
    curve.coefficient.push_back({rows(i, 1), rows(i, 2), rows(i, 3), rows(i, 4)});
  }
  return curve;
}

void bind_descriptions(nb::module_& m) {
  bind_struct<Body>(m, "Body", "A rigid body; SI.");
  bind_laws<ForceLaw>(m, "force_laws", "ForceLaw");
  bind_struct<DirectionLaw>(m, "DirectionLaw", "Force of an element in one direction; SI.");
  bind_struct<ForceElement>(m, "ForceElement", "Springs and dampers between two bodies, -1: the ground.");
  bind_struct<ContactDescription>(m, "ContactDescription", "One wheel on one roller or rail; SI.");
  bind_struct<AxleTorque>(m, "AxleTorque", "Torque about an axle: of a traction motor, or one that a test prescribes.");
  bind_struct<RollerTorque>(m, "RollerTorque", "Torque on a roller about its axle.");
  bind_struct<RunningResistance>(m, "RunningResistance", "Davis' formula on one body, and the gradient.");
}

void bind_statics(nb::module_& m) {
  bind_struct<StandingBody>(m, "StandingBody", "A body of a vehicle at rest.");
  bind_struct<LoadSpring>(m, "LoadSpring", "An element that carries load in the design position.");
  bind_result(m, "StaticLoads", "How a vehicle stands.", Member{"preload", &StaticLoads::preload},
              Member{"on_body", &StaticLoads::on_body}, Member{"imbalance", &StaticLoads::imbalance});
  def_function(m, "static_loads", "Preloads and axle loads of a vehicle at rest.", &static_loads, Argument{"bodies"},
               Argument{"springs"}, Argument{"gravity"});
}

nb::dict start_of(std::shared_ptr<Model const> const& model, double t, std::vector<Disturbance> const& disturbances) {
  constexpr char const* found[] = {"ok", "no_equilibrium", "no_support"};
  StartingState start = starting_state(model, t, disturbances);
  std::size_t const states = start.x.size();
  nb::dict d;
  d["found"] = found[start.found];
  d["body"] = start.body;
  d["residual"] = start.residual;
  d["rest"] = owned_array<nb::ndim<1>>(std::move(start.rest), {states});
  d["x"] = owned_array<nb::ndim<1>>(std::move(start.x), {states});
  return d;
}

void bind_start(nb::module_& m) {
  bind_struct<Disturbance>(m, "Disturbance", "A coordinate that a run starts off its equilibrium.");
  def_function(m, "coasting_model", "The model whose equilibrium a run starts from.", &coasting_model,
               Argument{"model"});
  def_function(m, "starting_state",
               "Equilibrium at the model's speed at a time, undisturbed (rest) and with disturbances (x); found: ok, "
               "no_equilibrium, or no_support of a disturbed body.",
               &start_of, Argument{"model"}, Argument{"t"}, Argument{"disturbances"});
}

}  // namespace

void bind_model(nb::module_& m) {
  bind_descriptions(m);
  bind_statics(m);
  nb::class_<Model>(m, "Model", "Constant data of one assembled system; see rollerrig.assembly.model.")
      .def_ro("gravity", &Model::gravity)
      .def("with_speed", &with_speed, "speed"_a, "The model at another running speed over time.");
  bind_start(m);
  nb::class_<ModelBuilder>(m, "ModelBuilder", "Makes a model; each add_... returns an index.")
      .def(nb::init<double>(), "gravity"_a)
      .def("add_body", &ModelBuilder::add_body, "body"_a)
      .def("add_element", &ModelBuilder::add_element, "element"_a)
      .def(
          "add_profile",
          [](ModelBuilder& builder, double start, double step, PieceRows const& pieces) {
            return builder.add_profile(uniform_spline(start, step, pieces));
          },
          "start"_a, "step"_a, "pieces"_a)
      .def("add_contact", &ModelBuilder::add_contact, "contact"_a)
      .def("add_brake", &ModelBuilder::add_brake, "brake"_a)
      .def("add_track_brake", &ModelBuilder::add_track_brake, "brake"_a)
      .def("add_axle_torque", &ModelBuilder::add_axle_torque, "torque"_a)
      .def("add_roller_torque", &ModelBuilder::add_roller_torque, "torque"_a)
      .def("add_rolling_constraint", &ModelBuilder::add_rolling_constraint, "wheelset"_a)
      .def("set_adhesion", &ModelBuilder::set_adhesion, "contact"_a, "map"_a)
      .def("set_resistance", &ModelBuilder::set_resistance, "resistance"_a)
      .def("set_gravity", &ModelBuilder::set_gravity, "gravity"_a)
      .def("set_speed", &ModelBuilder::set_speed, "speed"_a)
      .def(
          "set_line",
          [](ModelBuilder& builder, BreakRows const& curvature, BreakRows const& cant, double cant_base) {
            builder.set_line({piecewise_cubic(curvature), piecewise_cubic(cant), cant_base});
          },
          "curvature"_a, "cant"_a, "cant_base"_a)
      .def(
          "set_rails",
          [](ModelBuilder& builder, BreakRows const& left_y, BreakRows const& left_z, BreakRows const& left_roll,
             BreakRows const& right_y, BreakRows const& right_z, BreakRows const& right_roll) {
            auto const rail = [](BreakRows const& y, BreakRows const& z, BreakRows const& roll) {
              return RailLayout{piecewise_cubic(y), piecewise_cubic(z), piecewise_cubic(roll)};
            };
            builder.set_rails(rail(left_y, left_z, left_roll), rail(right_y, right_z, right_roll));
          },
          "left_y"_a, "left_z"_a, "left_roll"_a, "right_y"_a, "right_z"_a, "right_roll"_a)
      .def(
          "set_heads",
          [](ModelBuilder& builder, std::vector<int> const& left, BreakRows const& left_place,
             std::vector<int> const& right, BreakRows const& right_place, double period) {
            builder.set_heads({left, piecewise_cubic(left_place), period},
                              {right, piecewise_cubic(right_place), period});
          },
          "left"_a, "left_place"_a, "right"_a, "right_place"_a, "period"_a)
      .def(
          "set_irregularity",
          [](ModelBuilder& builder, double period, double step, PieceRows const& left_y, PieceRows const& left_z,
             PieceRows const& right_y, PieceRows const& right_z, double fade_in, bool steered) {
            auto const spline = [step](PieceRows const& rows) { return uniform_spline(0.0, step, rows); };
            builder.set_irregularity(
                {period, spline(left_y), spline(left_z), spline(right_y), spline(right_z), fade_in, steered});
          },
          "period"_a, "step"_a, "left_y"_a, "left_z"_a, "right_y"_a, "right_z"_a, "fade_in"_a, "steered"_a)
      .def("finish", &ModelBuilder::finish);
}
