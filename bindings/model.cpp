// bindings/model.cpp - descriptions of a model's parts, and the constant model that is made of them.
#include "rollerrig/system/model.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/variant.h>

#include "arguments.hpp"
#include "fields.hpp"
#include "rollerrig/system/equilibrium.hpp"

using namespace nb::literals;
using namespace rollerrig;

namespace {

using PieceRows = nb::ndarray<double const, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;

void bind_curves(nb::module_& m) {
  nb::class_<UniformSpline>(m, "UniformSpline", "A curve in cubic pieces of one length.")
      .def(
          "__init__",
          [](UniformSpline* self, double start, double step, PieceRows const& pieces) {
            UniformSpline spline{start, step, {}};
            for (std::size_t i = 0; i < pieces.shape(0); ++i)
              spline.pieces.push_back({pieces(i, 0), pieces(i, 1), pieces(i, 2), pieces(i, 3)});
            check_value(spline, finite_number, "UniformSpline", "curve");
            new (self) UniformSpline(std::move(spline));
          },
          "start"_a, "step"_a, "pieces"_a)
      .def_ro("start", &UniformSpline::start)
      .def_ro("step", &UniformSpline::step)
      .def_prop_ro(
          "pieces",
          [](UniformSpline const& spline) {
            std::vector<double> rows;
            for (auto const& piece : spline.pieces) rows.insert(rows.end(), piece.begin(), piece.end());
            return owned_array<nb::shape<-1, 4>>(std::move(rows), {spline.pieces.size(), 4});
          },
          nb::rv_policy::move);
  bind_struct<RailLayout>(m, "RailLayout", "Where one rail was laid; curves: rows of start and coefficients.");
  bind_struct<RailHeads>(m, "RailHeads", "Heads of one side that change along the line, or round its rollers.");
  bind_struct<Line>(m, "Line", "Curvature, cant and place of the rails along the line.");
  bind_struct<Irregularity>(m, "Irregularity", "Displacements of the rails over a period.");
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
  bind_struct<ModelParts>(m, "ModelParts", "What a model is made of, in the order of its indices.");
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
  bind_curves(m);
  bind_descriptions(m);
  bind_statics(m);
  nb::class_<Model>(m, "Model", "Constant data of one assembled system; see rollerrig.assembly.model.")
      .def_ro("gravity", &Model::gravity)
      .def("with_speed", &with_speed, "speed"_a, "The model at another running speed over time.");
  m.def("model_of", &model_of, "parts"_a, "A model of these parts; ValueError names what cannot be built.");
  bind_start(m);
}
