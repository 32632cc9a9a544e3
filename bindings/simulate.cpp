// bindings/bench.cpp - the test bench: machines and controllers around the plant; see rollerrig.bench.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "convert.hpp"
#include "rollerrig/mechatronics/estimator_response.hpp"
#include "rollerrig/simulate/recorder.hpp"
#include "rollerrig/simulate/sampled_run.hpp"
#include "rollerrig/system/model_builder.hpp"

using namespace nb::literals;
using namespace rollerrig;

namespace {

using Rows = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Times = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

/// A value of the settings; every key must be there: defaults live in Python.
template <class V>
V get(nb::dict const& d, char const* key) {
  return nb::cast<V>(d[key]);
}
nb::dict table(nb::dict const& d, char const* key) { return nb::cast<nb::dict>(d[key]); }

PiecewiseLinear points(nb::dict const& d, char const* key) {
  PiecewiseLinear line;
  for (auto const& row : get<std::vector<std::array<double, 2>>>(d, key))
    line.x.push_back(row[0]), line.y.push_back(row[1]);
  return line;
}

Motor motor(nb::dict const& d) {
  return {points(d, "envelope"), get<double>(d, "bandwidth"), get<double>(d, "damping_ratio")};
}
Sampling sampling(nb::dict const& d) { return {get<int>(d, "every"), get<int>(d, "delay"), get<bool>(d, "external")}; }
Encoder encoder(nb::dict const& d) {
  return {get<double>(d, "counts_per_turn"), get<double>(d, "jitter_counts"), get<int>(d, "window")};
}
ForceSensor force_sensor(nb::dict const& d) {
  return {get<double>(d, "bandwidth"), get<double>(d, "noise"), get<double>(d, "resolution"), get<double>(d, "range")};
}
PneumaticBrake pneumatic(nb::dict const& d) {
  PneumaticBrake b;
  b.application_rate = get<double>(d, "application_rate"), b.release_rate = get<double>(d, "release_rate");
  b.follow_rate = get<double>(d, "follow_rate");
  b.fill_rate = get<double>(d, "fill_rate"), b.vent_rate = get<double>(d, "vent_rate");
  b.ambient = get<double>(d, "ambient_pressure");
  b.volume = get<double>(d, "volume"), b.piston_area = get<double>(d, "piston_area");
  b.spring_force = get<double>(d, "spring_force"), b.friction = points(d, "friction");
  b.friction_radius = get<double>(d, "friction_radius"), b.faces = get<double>(d, "faces");
  b.friction_regularisation_speed = get<double>(d, "friction_regularisation_speed");
  return b;
}
WheelSlideProtection slide_protection(nb::dict const& d) {
  WheelSlideProtection p;
  p.wheel_radius = get<double>(d, "wheel_radius"), p.reference_deceleration = get<double>(d, "reference_deceleration");
  p.filter_time = get<double>(d, "filter_time"), p.vent_slip = get<double>(d, "vent_slip");
  p.vent_slip_speed = get<double>(d, "vent_slip_speed"), p.vent_deceleration = get<double>(d, "vent_deceleration");
  p.fill_slip = get<double>(d, "fill_slip"), p.fill_slip_speed = get<double>(d, "fill_slip_speed");
  p.recovery_acceleration = get<double>(d, "recovery_acceleration"), p.pulse_time = get<double>(d, "pulse_time");
  p.pulse_pause = get<double>(d, "pulse_pause"), p.longest_vent = get<double>(d, "longest_vent");
  p.least_speed = get<double>(d, "least_speed");
  p.release_interval = get<double>(d, "release_interval"), p.longest_release = get<double>(d, "longest_release");
  p.regained_after = get<double>(d, "regained_after"), p.shortest_release = get<double>(d, "shortest_release");
  p.least_deceleration = get<double>(d, "least_deceleration");
  return p;
}
WheelSlipControl wheel_slip_control(nb::dict const& d) {
  WheelSlipControl p;
  p.wheel_radius = get<double>(d, "wheel_radius"), p.reference_acceleration = get<double>(d, "reference_acceleration");
  p.slip = get<double>(d, "slip"), p.slip_speed = get<double>(d, "slip_speed");
  p.acceleration = get<double>(d, "acceleration"), p.filter_time = get<double>(d, "filter_time");
  p.reduction_rate = get<double>(d, "reduction_rate"), p.restoring_rate = get<double>(d, "restoring_rate");
  p.least_factor = get<double>(d, "least_factor"), p.regained_after = get<double>(d, "regained_after");
  p.shortest_release = get<double>(d, "shortest_release");
  p.release_deceleration = get<double>(d, "release_deceleration");
  p.least_acceleration = get<double>(d, "least_acceleration");
  p.release_interval = get<double>(d, "release_interval"), p.longest_release = get<double>(d, "longest_release");
  return p;
}
ContactForceEstimator estimator(nb::dict const& d) {
  ContactForceEstimator e;
  auto const kind = get<std::string>(d, "kind");
  e.kind = kind == "observer" ? EstimatorKind::observer
           : kind == "kalman" ? EstimatorKind::kalman
           : kind == "exact"  ? EstimatorKind::exact
                              : EstimatorKind::filtered_derivative;
  e.bandwidth = get<double>(d, "bandwidth"), e.damping_ratio = get<double>(d, "damping_ratio");
  e.speed_noise = get<double>(d, "speed_noise"), e.force_change = get<double>(d, "force_change");
  e.torque_change = get<double>(d, "torque_change");
  e.roller_inertia = get<double>(d, "roller_inertia"), e.roller_radius = get<double>(d, "roller_radius");
  e.wheelset_inertia = get<double>(d, "wheelset_inertia"), e.wheel_radius = get<double>(d, "wheel_radius");
  return e;
}
RigFeedback feedback(nb::dict const& d) {
  RigFeedback f;
  auto const kind = get<std::string>(d, "kind");
  f.kind = kind == "none"           ? FeedbackKind::none
           : kind == "sliding_mode" ? FeedbackKind::sliding_mode
                                    : FeedbackKind::proportional_integral;
  f.proportional = get<double>(d, "proportional"), f.integral = get<double>(d, "integral");
  f.switching = get<double>(d, "switching"), f.boundary_layer = get<double>(d, "boundary_layer");
  f.largest = get<double>(d, "largest");
  return f;
}
VirtualTrain virtual_train(nb::dict const& d, std::size_t axles) {
  VirtualTrain t;
  t.axles = static_cast<int>(axles);
  t.mass = get<double>(d, "mass"), t.wheelset_inertia = get<double>(d, "wheelset_inertia");
  t.wheel_radius = get<double>(d, "wheel_radius"), t.gravity = get<double>(d, "gravity");
  t.resistance_constant = get<double>(d, "resistance_constant"),
  t.resistance_linear = get<double>(d, "resistance_linear");
  t.resistance_quadratic = get<double>(d, "resistance_quadratic"), t.gradient = get<double>(d, "gradient");
  auto const load = get<std::vector<double>>(d, "static_load");
  auto const transfer = get<std::vector<double>>(d, "load_transfer");
  std::copy_n(load.begin(), axles, t.static_load.begin());
  std::copy_n(transfer.begin(), axles, t.load_transfer.begin());
  return t;
}

/// The virtual rail takes its laws from a contact of the model.
VirtualRail virtual_rail(nb::dict const& d, Model const& model, int contact) {
  VirtualRail rail;
  ContactLaws const& laws = model.contacts.at(static_cast<std::size_t>(contact)).laws;
  rail.creep = laws.creep;
  rail.creepage_regularisation_speed = laws.creepage_regularisation_speed;
  rail.friction = laws.friction;
  rail.friction.map = get<std::shared_ptr<AdhesionMap const>>(d, "adhesion");
  if (rail.friction.map) rail.friction.map->check();
  rail.wheel_load = get<double>(d, "wheel_load"), rail.a = get<double>(d, "a"), rail.b = get<double>(d, "b");
  rail.width = get<double>(d, "width");
  rail.log_aspect = std::log(rail.a / rail.b);
  rail.stiffness = kalker_stiffness(laws.kalker->at(rail.log_aspect), laws.material.shear_modulus, rail.a, rail.b, 1.0);
  return rail;
}

BenchSetup setup_from(nb::dict const& d, Model const& model) {
  BenchSetup s;
  s.step = get<double>(d, "step"), s.duration = get<double>(d, "duration"), s.speed = get<double>(d, "speed");
  s.floor_speed = get<double>(d, "floor_speed");
  for (auto const& item : get<std::vector<nb::dict>>(d, "axles")) {
    BenchAxle a;
    a.wheelset = get<int>(item, "wheelset"), a.axle_torque = get<int>(item, "axle_torque");
    a.brake = get<int>(item, "brake"), a.roller = get<int>(item, "roller");
    a.roller_torque = get<int>(item, "roller_torque"), a.contact = get<std::array<int, 2>>(item, "contacts");
    s.place[s.axles.size()] = get<double>(item, "x");
    s.axles.push_back(a);
    if (s.axles.size() == most_axles) break;
  }
  s.brake_demand = {points(d, "brake_demand")}, s.traction_demand = {points(d, "traction_demand")};
  s.brake = pneumatic(table(d, "brake")), s.motor = motor(table(d, "motor"));
  s.motor_brakes = get<bool>(d, "motor_brakes");
  s.slide_sampling = sampling(table(d, "slide_sampling")), s.slide = slide_protection(table(d, "slide_protection"));
  s.wheel_slip_sampling = sampling(table(d, "wheel_slip_sampling")),
  s.wheel_slip_control = wheel_slip_control(table(d, "wheel_slip_control"));
  s.axle_encoder = encoder(table(d, "axle_encoder")), s.roller_encoder = encoder(table(d, "roller_encoder"));
  s.has_torque_sensor = get<bool>(d, "has_torque_sensor");
  s.torque_sensor = force_sensor(table(d, "torque_sensor")), s.load_sensor = force_sensor(table(d, "load_sensor"));
  s.commanded_torque = get<bool>(d, "commanded_torque"), s.measured_loads = get<bool>(d, "measured_loads");
  s.seed = get<std::uint64_t>(d, "seed");
  s.rig_sampling = sampling(table(d, "rig_sampling")), s.reproduce = get<bool>(d, "reproduce");
  s.train = virtual_train(table(d, "train"), s.axles.size());
  if (s.reproduce) s.rail = virtual_rail(table(d, "rail"), model, s.axles.front().contact[0]);
  s.estimator = estimator(table(d, "estimator")), s.feedback = feedback(table(d, "feedback"));
  s.roller_motor = motor(table(d, "roller_motor"));
  s.slip_limit = get<double>(d, "slip_limit"), s.slip_time = get<double>(d, "slip_time");
  s.travelling_mass = get<double>(d, "travelling_mass"), s.held_mass = get<double>(d, "held_mass");
  s.rail_cell = get<double>(d, "rail_cell");
  s.pure_rolling = get<bool>(d, "pure_rolling");
  return s;
}

/// A model on its bench, with the rows of plant and bench recorded side by side.
class Bench {
 public:
  Bench(std::shared_ptr<Model const> const& model, nb::dict const& settings)
      : dynamics_(model), recorder_(*model), setup_(setup_from(settings, *model)), bench_(dynamics_, setup_) {}

  int start(Column const& x0) {
    if (static_cast<int>(x0.shape(0)) != dynamics_.sizes().states)
      throw nb::value_error("x0 must hold one value per state");
    return static_cast<int>(bench_.start(x0.data()));
  }

  /// @return status, rows filled so far
  std::pair<int, int> advance(double t_stop, int output_every, Times times, Rows plant, Rows bench, int filled) {
    int const capacity = static_cast<int>(times.shape(0));
    Status status;
    {
      nb::gil_scoped_release free;
      status = bench_.advance(t_stop, output_every, [&](double t, double const* x, double const* z) {
        if (filled >= capacity) return;
        auto const row = static_cast<std::size_t>(filled);
        times.data()[filled] = t;
        recorder_.record(dynamics_, t, x, z, plant.data() + row * plant.shape(1), bench_.inputs());
        double* out = bench.data() + row * bench.shape(1);
        bench_.fill_row(out, out + setup_.axles.size() * TestBench::axle_columns().size());
        ++filled;
      });
    }
    return {static_cast<int>(status), filled};
  }

  TestBench& bench() { return bench_; }
  int plant_width() const { return recorder_.width(); }
  int bench_width() const {
    return static_cast<int>(setup_.axles.size() * TestBench::axle_columns().size() + TestBench::train_columns().size());
  }

 private:
  Dynamics dynamics_;
  Recorder recorder_;
  BenchSetup setup_;
  TestBench bench_;
};

nb::list column_list(std::span<BenchColumn const> columns) {
  nb::list list;
  for (auto const& c : columns)
    list.append(nb::make_tuple(std::string(c.name), std::string(c.unit), std::string(c.meaning)));
  return list;
}

}  // namespace

void bind_bench(nb::module_& m) {
  nb::enum_<TestBench::Role>(m, "Role")
      .value("slide_protection", TestBench::Role::slide_protection)
      .value("wheel_slip_control", TestBench::Role::wheel_slip_control)
      .value("rig", TestBench::Role::rig);
  nb::class_<Bench>(m, "Bench", "A model with machines and controllers around it; see rollerrig.bench.")
      .def(nb::init<std::shared_ptr<Model const>, nb::dict const&>(), "model"_a, "settings"_a)
      .def("start", &Bench::start, "x0"_a)
      .def("advance", &Bench::advance, "t_stop"_a, "output_every"_a, "times"_a, "plant"_a, "bench"_a, "filled"_a)
      .def(
          "due", [](Bench& b, TestBench::Role role) { return b.bench().due(role); }, "role"_a)
      .def(
          "measurement", [](Bench& b, TestBench::Role role) { return b.bench().measurement(role); }, "role"_a,
          "Per axle the numbers of measurement_fields.")
      .def(
          "set_command",
          [](Bench& b, TestBench::Role role, std::vector<double> command) {
            command.resize(most_axles, 0.0);
            b.bench().set_command(role, command.data());
          },
          "role"_a, "command"_a)
      .def_prop_ro("time", [](Bench& b) { return b.bench().time(); })
      .def_prop_ro("ended", [](Bench& b) { return b.bench().ended(); })
      .def_prop_ro("protected_rollers", [](Bench& b) { return b.bench().protected_rollers(); })
      .def_prop_ro("failed_contact", [](Bench& b) { return b.bench().failed_contact(); })
      .def_prop_ro("derivative_calls", [](Bench& b) { return b.bench().statistics().derivative_calls; })
      .def_prop_ro("steps", [](Bench& b) { return b.bench().statistics().steps; })
      .def_prop_ro("plant_width", &Bench::plant_width)
      .def_prop_ro("bench_width", &Bench::bench_width);
  m.def(
      "add_brake",
      [](ModelBuilder& builder, int wheelset, int reaction, nb::dict const& brake) {
        return builder.add_brake({wheelset, reaction, pneumatic(brake)});
      },
      "builder"_a, "wheelset"_a, "reaction"_a, "brake"_a,
      "A friction brake between an axle and a body, or -1: the ground.");
  m.def(
      "brake_torque",
      [](nb::dict const& brake, double cylinder_pressure, double axle_speed) {
        return pneumatic(brake).torque(cylinder_pressure, axle_speed);
      },
      "brake"_a, "cylinder_pressure"_a, "axle_speed"_a,
      "Torque of a friction brake on its axle [N m], against its turning.");
  m.def(
      "estimator_response",
      [](nb::dict const& settings, double period) {
        ContactForceEstimator e = estimator(settings);
        if (e.kind == EstimatorKind::kalman) solve_kalman_gain(e, period);
        nb::dict out;
        for (auto [name, what] : {std::pair{"force", Estimated::force}, std::pair{"torque", Estimated::torque}}) {
          auto const found = measure_response(e, what, period);
          out[name] = nb::make_tuple(found.bandwidth, found.delay);
        }
        return out;
      },
      "settings"_a, "period"_a, "Bandwidth [rad/s] and delay [s] of the estimates of force and torque, measured.");
  m.attr("measurement_fields") =
      std::vector<std::string>{"axle_speed",       "roller_speed",  "roller_torque", "estimated_force",
                               "estimated_torque", "virtual_speed", "feed_forward",  "axle_load"};
  m.attr("bench_axle_columns") = column_list(TestBench::axle_columns());
  m.attr("bench_train_columns") = column_list(TestBench::train_columns());
}
