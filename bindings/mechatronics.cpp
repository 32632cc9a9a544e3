// bindings/mechatronics.cpp - sensors, controllers and actuators: a class for each struct, from its own list of parameters.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/variant.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "arguments.hpp"
#include "fields.hpp"
#include "rollerrig/simulate/setup.hpp"
#include "rollerrig/system/model.hpp"

using namespace nb::literals;
using namespace rollerrig;

namespace {

using Samples = nb::ndarray<double const, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

/// Force and torque that an estimator finds from samples of one axle.
auto estimate(AnyEstimator const& estimator, AssumedParameters const& assumed, double period, Samples const& samples) {
  std::vector<double> found;
  auto const axle = [&](std::size_t i) { return AxleSample{samples(i, 0), samples(i, 1), samples(i, 2)}; };
  auto const run = [&](auto const& law) {
    auto state = law.start(assumed, period, axle(0));
    for (std::size_t i = 0; i < samples.shape(0); ++i) {
      auto const now = law.step(state, assumed, axle(i), period);
      found.insert(found.end(), {now.force, now.torque});
    }
  };
  if (samples.shape(0) > 0) std::visit(run, estimator);
  return owned_array<nb::shape<-1, 2>>(std::move(found), {samples.shape(0), 2});
}

void bind_actuators(nb::module_& m) {
  bind_struct<Motor>(m, "Motor", "A drive from torque command to torque.");
  def_function(m, "reflected_inertia", "Of a geared rotor on the axle that it drives [kg m^2].", &reflected_inertia,
               Argument{"rotor_inertia"}, Argument{"gear_ratio"});
  bind_struct<CylinderPipe>(m, "CylinderPipe", "Pipes from a relay valve to the dump valves of its axles.");
  bind_laws<AnyAir>(m, "airs", "Air");
  bind_struct<ControlValve>(m, "ControlValve", "A brake's control valve and the volume of a cylinder behind it.");
  bind_struct<Pneumatics>(m, "Pneumatics", "From brake demand and dump valves' commands to cylinder pressures.");
  def_function(m, "torque_lag", "How late a drive's torque is behind what its controller wants, for slow changes [s].",
               &torque_lag, Argument{"motor"}, Argument{"period", positive}, Argument{"delay", not_negative},
               Argument{"gain", not_negative});
  bind_laws<AnyElectrodynamicBrake>(m, "electrodynamic_brakes", "Brake");
  auto machine = bind_struct<ElectrodynamicBrake>(m, "ElectrodynamicBrake", "Traction motors that brake.");
  def_method(
      machine, "largest", "Largest torque [N m] of the characteristic at an axle speed [rad/s].",
      +[](ElectrodynamicBrake const& self, double speed) { return self.largest(speed); }, Argument{"axle_speed"});
  auto brake =
      bind_struct<FrictionBrake>(m, "FrictionBrake", "From cylinder pressure to the torque of an axle's brake.");
  def_method(
      brake, "torque", "Torque on the axle [N m], against its turning.",
      +[](FrictionBrake const& self, double pressure, double speed) { return self.torque(pressure, speed); },
      Argument{"cylinder_pressure"}, Argument{"axle_speed"});
  bind_laws<AnyTrackBrake>(m, "track_brakes", "TrackBrake");
  auto on_rail = bind_struct<TrackBrake>(m, "TrackBrake", "Brakes that act on the rail, and when they are on.");
  def_method(
      on_rail, "force", "Of one bogie in full excitation, against running [N], at a speed over the rail [m/s].",
      +[](TrackBrake const& self, double speed) { return self.force(speed); }, Argument{"speed"});
  bind_struct<BodyTrackBrake>(m, "BodyTrackBrake", "A track brake on the body that carries its magnets.");
  bind_laws<AnySandingStart>(m, "sanding_starts", "Sanding");
  bind_struct<Sanding>(m, "Sanding", "When sand flows in front of which wheels, and how much.");
  bind_struct<AxleBrake>(m, "AxleBrake", "A friction brake between an axle and a body, or -1: the ground.");
  bind_laws<AnySpeedSensor>(m, "speed_sensors");
  bind_struct<ForceSensor>(m, "ForceSensor", "Transducer of a force or a torque.");
  bind_struct<Sensors>(m, "Sensors", "What controllers see of speeds, torques and loads.");
  bind_struct<Actuators>(m, "Actuators", "Brake, traction motor and roller drive of each axle.");
}

void bind_controllers(nb::module_& m) {
  bind_struct<AssumedParameters>(m, "AssumedParameters", "Wheel and roller as a controller assumes them.");
  bind_laws<AnyEstimator>(m, "estimators", "Estimator");
  bind_laws<AnyAxleTorque>(m, "axle_torque_laws", "AxleTorque");
  bind_laws<AnyFeedback>(m, "feedbacks", "Feedback");
  bind_laws<AnyDriveCommand>(m, "drive_commands", "DriveCommand");
  def_function(
      m, "estimator_response", "Bandwidth [rad/s] and delay [s] of the estimates of force and of torque, measured.",
      +[](AnyEstimator const& estimator, AssumedParameters const& assumed, double period) {
        auto const of = [&](Estimated what) {
          auto const found = measure_response(estimator, assumed, what, period);
          return std::pair{found.bandwidth, found.delay};
        };
        return std::pair{of(Estimated::force), of(Estimated::torque)};
      },
      Argument{"estimator"}, Argument{"assumed"}, Argument{"period", positive});
  def_function(m, "estimate",
               "Force [N] and torque [N m] as estimated, shape (sample, 2), of one axle: speeds of roller and wheel, "
               "mean torque "
               "of the drive since the last sample, shape (sample, 3).",
               &estimate, Argument{"estimator"}, Argument{"assumed"}, Argument{"period", positive},
               Argument{"samples"});
  m.def(
      "feedback_gains",
      [](ProportionalIntegral const& feedback, AssumedParameters const& assumed) {
        auto const gains = feedback.gains(assumed);
        return std::pair{gains.proportional, gains.integral};
      },
      "feedback"_a, "assumed"_a,
      "Proportional [N m s/rad] and integral gain [N m/rad], (D6) where they are not given.");
  bind_struct<VirtualTrain>(m, "VirtualTrain", "The train that the rig's controller integrates.");
  nb::class_<EquivalentPatch>(m, "EquivalentPatch", "One ellipse for all patches of a wheel; see equivalent_patch().")
      .def_ro("load", &EquivalentPatch::load)
      .def_ro("a", &EquivalentPatch::a)
      .def_ro("b", &EquivalentPatch::b)
      .def_ro("width", &EquivalentPatch::width);
  def_function(
      m, "equivalent_patch",
      "The ellipse with the area of all patches of a wheel together and their mean shape, from their semi-axes [m].",
      +[](double load, std::vector<double> const& a, std::vector<double> const& b) {
        double area = 0.0;  // an absent patch has none
        for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) area += a[i] * b[i];
        if (a.size() != b.size() || !(area > 0.0))
          throw nb::value_error("equivalent_patch: a, b must be semi-axes of as many patches, one of them not empty");
        return equivalent_patch(load, a, b);
      },
      Argument{"load", positive}, Argument{"a", not_negative}, Argument{"b", not_negative});
  bind_struct<VirtualRail>(m, "VirtualRail", "The degraded rail under the virtual train.");
  bind_laws<AnySlideProtection>(m, "slide_protections", "Protection");
  bind_struct<SlipSearch>(m, "SlipSearch", "Finds by trial the slip at which an axle transmits most.");
  bind_laws<AnyController>(m, "controllers");
}

/// Name of each controller -> its command.
template <class... Laws>
void bind_commands(nb::module_& m, std::variant<Laws...> const* /*registry*/) {
  nb::class_<CommandField>(m, "CommandField", "What an actuator takes from a controller, one number per axle.")
      .def_prop_ro("name", [](CommandField const& f) { return std::string(f.name); })
      .def_prop_ro("allowed", [](CommandField const& f) { return std::string(f.allowed); })
      .def_ro("lowest", &CommandField::lowest)
      .def_ro("highest", &CommandField::highest)
      .def_ro("whole", &CommandField::whole);
  nb::dict found;
  ((found[Laws::name] = nb::cast(field_of(Laws::command))), ...);
  m.attr("commands") = found;
}

}  // namespace

void bind_mechatronics(nb::module_& m) {
  bind_actuators(m);
  bind_controllers(m);
  bind_struct<Sampling>(m, "Sampling", "When a controller is asked, and how long its answer takes, in steps.");
  bind_struct<SampledController>(m, "SampledController", "A controller and when it is asked.");
  bind_struct<AxleParts>(m, "AxleParts", "Indices of an axle's parts in the model; -1: absent.");
  bind_struct<RollerProtection>(m, "RollerProtection", "Ends a test before real sliding damages the rollers.");
  bind_struct<TravellingFrame>(m, "TravellingFrame", "Masses of a train on track.");
  bind_struct<SimulatedAxles>(m, "SimulatedAxles", "Axles of the train that are not in the model.");
  bind_struct<MechatronicSetup>(m, "MechatronicSetup", "Sensors, controllers and actuators around a vehicle.");
  bind_commands(m, static_cast<AnyController const*>(nullptr));
  m.attr("most_axles") = most_axles;
  m.attr("rail_cells") = RailCells::cells;
}
