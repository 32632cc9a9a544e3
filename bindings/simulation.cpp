// bindings/simulation.cpp - one simulation: dynamics, integrator and recorder behind one object.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

#include "arguments.hpp"
#include "fields.hpp"
#include "rollerrig/simulate/driver.hpp"
#include "rollerrig/simulate/linear_model.hpp"
#include "rollerrig/simulate/recorder.hpp"
#include "rollerrig/simulate/run_table.hpp"
#include "rollerrig/simulate/tangent_run.hpp"
#include "rollerrig/system/equilibrium.hpp"

using namespace nb::literals;
using namespace rollerrig;
using integrate::Options;

namespace {

/// None, or one for each.
void check_count(std::vector<double> const& numbers, std::size_t count, char const* what) {
  if (!numbers.empty() && numbers.size() != count)
    throw nb::value_error((std::string(what) + " needs " + std::to_string(count) + " numbers, or none").c_str());
}

using Table = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Vector = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

std::vector<double> row_major(Eigen::MatrixXd const& m) {
  std::vector<double> values(static_cast<std::size_t>(m.size()));
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(values.data(), m.rows(),
                                                                                     m.cols()) = m;
  return values;
}
auto table(Eigen::MatrixXd const& m) {
  return owned_array<nb::ndim<2>>(row_major(m),
                                  {static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols())});
}

/// A simulation serves one thread at a time: advance() runs beside other Python threads, which must not touch it meanwhile.
class Turn {
 public:
  explicit Turn(bool& taken) : taken_{taken} {
    if (taken_)
      throw std::logic_error("the simulation is advancing in another thread; each thread needs one of its own");
    taken_ = true;
  }
  ~Turn() { taken_ = false; }
  Turn(Turn const&) = delete;
  Turn& operator=(Turn const&) = delete;

 private:
  bool& taken_;  ///< read and written under the interpreter's lock only
};

class Simulation {
 public:
  Simulation(std::shared_ptr<Model const> const& model, std::optional<MechatronicSetup> setup)
      : driver_(model, std::move(setup)), recorder_(*model) {}

  int start(Options const& options, double t0, Column const& x0) {
    Turn const turn(taken_);
    check_value(x0, Range{0.0, 1e5, "within 1e5 m, rad, m/s, rad/s", false, false, true}, "start", "x0");
    check_value(options.final_time, finite_number, "start", "final_time");
    check_state(x0);
    readings_.reset();
    return static_cast<int>(driver_.start(options, t0, x0.data()));
  }

  /// From the next output time on: a reading at each, a whole row at every `every`-th; until the next start.
  void keep_readings(int every, Vector times, Table values) {
    Turn const turn(taken_);
    require_start();
    check_value(every, Range{1.0, 1e6, "a number of output times"}, "keep_readings", "every");
    if (static_cast<int>(values.shape(1)) != driver_.reading_width())
      throw nb::value_error("values must have `reading_width` columns");
    if (times.shape(0) != values.shape(0))
      throw nb::value_error("times and values must have room for equally many readings");
    readings_.emplace(every, rows_of(times, values));
    kept_ = {std::move(times), std::move(values)};
  }
  std::size_t reading_count() const { return readings_ ? readings_->filled() : 0; }

  /// Advances to t_stop and writes one row per output time; returns status and rows filled so far.
  std::tuple<int, int> advance(double t_stop, Vector times, Table rows, int filled) {
    Turn const turn(taken_);
    require_start();
    if (std::isnan(t_stop)) throw nb::value_error("advance: t_stop must be a time, got nan");
    if (static_cast<int>(rows.shape(1)) != driver_.width()) throw nb::value_error("rows must have `width` columns");
    if (times.shape(0) != rows.shape(0))
      throw nb::value_error("times and rows must have room for equally many outputs");
    auto const capacity = static_cast<int>(std::min<std::size_t>(rows.shape(0), std::numeric_limits<int>::max()));
    check_value(filled, Range{0.0, static_cast<double>(capacity), "the number of rows filled so far"}, "advance",
                "filled");
    TimedRows table = rows_of(times, rows);
    table.room = static_cast<std::size_t>(capacity);
    table.filled = static_cast<std::size_t>(filled);
    Status status = Status::ok;
    {
      nb::gil_scoped_release other_threads_may_run;
      status = rollerrig::advance(driver_, t_stop, table, readings_ ? &*readings_ : nullptr);
    }
    if (table.left_out > 0)
      throw nb::value_error(("times, rows: room for " + std::to_string(capacity) + " outputs, " +
                             std::to_string(table.left_out) + " more were due until t_stop")
                                .c_str());
    return {static_cast<int>(status), static_cast<int>(table.filled)};
  }

  bool waits_for(std::string const& controller) {
    Turn const turn(taken_);
    return blocks().waits_for(controller);
  }
  std::vector<double> measurement(std::string const& controller) {
    Turn const turn(taken_);
    return blocks().measurement(controller);
  }
  void set_command(std::string const& controller, std::vector<double> const& command) {
    Turn const turn(taken_);
    blocks();
    driver_.set_command(controller, command);
  }

  auto derivative(double t, Column const& x) {
    Turn const turn(taken_);
    check_state(x);
    auto const sizes = dynamics().sizes();
    std::vector<double> x_dot(static_cast<std::size_t>(sizes.states)),
        z_dot(static_cast<std::size_t>(sizes.quadratures));
    dynamics().derivative(t, x.data(), x_dot.data(), z_dot.data());
    return std::pair(owned_array<nb::ndim<1>>(std::move(x_dot), {static_cast<std::size_t>(sizes.states)}),
                     owned_array<nb::ndim<1>>(std::move(z_dot), {static_cast<std::size_t>(sizes.quadratures)}));
  }

  /// df/dx, row-major.
  auto jacobian(double t, Column const& x) {
    Turn const turn(taken_);
    check_state(x);
    JacobianData j(dynamics().sizes());
    dynamics().jacobian(t, x.data(), j);
    return nb::make_tuple(matrix(j.a), matrix(j.g), matrix(j.f_t), matrix(j.g_t));
  }

  /// A, B, C, D of small motions about a state, under the inputs of a run's start; row-major.
  auto linear_model(double t, Column const& x, std::vector<double> const& pressure,
                    std::vector<double> const& roller_torque) {
    Turn const turn(taken_);
    check_state(x);
    check_count(pressure, dynamics().model().brakes.size(), "linear_model: pressure");
    check_count(roller_torque, dynamics().model().roller_torques.size(), "linear_model: roller_torque");
    LinearModel const linear = rollerrig::linear_model(driver_, t, x.data(), pressure, roller_torque);
    return nb::make_tuple(table(linear.a), table(linear.b), table(linear.c), table(linear.d));
  }

  /// State, torques of the rollers, and whether they hold their speed under the brakes.
  auto hold_speed(double t, Column const& x, std::vector<double> const& pressure) {
    Turn const turn(taken_);
    check_state(x);
    check_count(pressure, dynamics().model().brakes.size(), "hold_speed: pressure");
    HeldSpeed held = rollerrig::hold_speed(dynamics(), t, x.data(), pressure);
    std::size_t const count = held.x.size();
    return nb::make_tuple(owned_array<nb::ndim<1>>(std::move(held.x), {count}), std::move(held.roller_torque),
                          held.found);
  }

  /// What one step of a fixed-step method does to a small deviation from x, row-major.
  auto step_amplification(integrate::Method method, double step, double t, Column const& x) {
    Turn const turn(taken_);
    check_state(x);
    Options{.method = method}.check();
    return matrix(rollerrig::step_amplification(dynamics(), method, step, t, x.data()));
  }

  nb::dict equilibrium(double speed, double t, std::vector<std::tuple<int, int, double>> const& fixed,
                       std::optional<Column> const& near, bool only_near) {
    Turn const turn(taken_);
    check_value(speed, finite_number, "equilibrium", "speed");
    check_value(t, finite_number, "equilibrium", "t");
    std::vector<FixedCoordinate> coordinates;
    for (auto const& [body, coordinate, value] : fixed) {
      int const bodies = static_cast<int>(dynamics().model().bodies.size());
      check_value(body, Range{0.0, bodies - 1.0, "the index of a body"}, "equilibrium", "fixed");
      check_value(coordinate, Range{0.0, 5.0, "a coordinate, 0 to 5"}, "equilibrium", "fixed");
      check_value(value, finite_number, "equilibrium", "fixed");
      coordinates.push_back({body, coordinate, value});
    }
    if (near) {
      check_value(*near, finite_number, "equilibrium", "near");
      check_state(*near);
    }
    auto r = solve_equilibrium(
        dynamics(), speed, t, coordinates,
        near ? std::vector<double>(near->data(), near->data() + near->shape(0)) : std::vector<double>(), only_near);
    nb::dict d;
    d["converged"] = r.converged;
    d["iterations"] = r.iterations;
    d["residual"] = r.residual;
    auto const n = r.x.size();
    d["x"] = owned_array<nb::ndim<1>>(std::move(r.x), {n});
    return d;
  }

  auto record(double t, Column const& x, Column const& z) {
    Turn const turn(taken_);
    check_state(x);
    if (static_cast<int>(z.shape(0)) != dynamics().sizes().quadratures)
      throw nb::value_error("z must hold one value per quadrature");
    std::vector<double> row(static_cast<std::size_t>(recorder_.width()));
    recorder_.record(driver_.observed(), t, x.data(), z.data(), row.data());
    auto const n = row.size();
    return owned_array<nb::ndim<1>>(std::move(row), {n});
  }

  /// x_dot of a sequence of states, one per row, in one call.
  auto derivatives(double t, nb::ndarray<double const, nb::ndim<2>, nb::c_contig, nb::device::cpu> states) {
    Turn const turn(taken_);
    std::size_t const n = states.shape(1);
    if (static_cast<int>(n) != dynamics().sizes().states) throw nb::value_error("one state per row");
    std::vector<double> x_dot(states.shape(0) * n);
    for (std::size_t i = 0; i < states.shape(0); ++i)
      dynamics().derivative(t, states.data() + i * n, x_dot.data() + i * n, nullptr);
    return owned_array<nb::ndim<2>>(std::move(x_dot), {states.shape(0), n});
  }

  nb::dict statistics() const { return driver_.started() ? dict_of(driver_.statistics()) : nb::dict(); }
  nb::dict counters() const { return dict_of(dynamics().counters()); }

  /// (spells, total, longest, longest_from) of each contact.
  std::vector<std::tuple<int, double, double, double>> contact_losses() const {
    std::vector<std::tuple<int, double, double, double>> rows;
    for (auto const& loss : dynamics().contact_losses())
      rows.emplace_back(loss.spells, loss.total, loss.longest, loss.longest_from);
    return rows;
  }

  Driver& driver() { return driver_; }
  Dynamics& dynamics() { return driver_.plant(); }
  Dynamics const& dynamics() const { return driver_.plant(); }
  double time() const { return driver_.time(); }
  auto state() const {
    if (taken_) throw std::logic_error("the simulation is advancing in another thread");
    require_start();
    auto const n = static_cast<std::size_t>(dynamics().sizes().states);
    return owned_array<nb::ndim<1>>(std::vector<double>(driver_.states(), driver_.states() + n), {n});
  }
  int width() const { return driver_.width(); }
  int reading_width() const { return recorder_.reading_width(); }

 private:
  static TimedRows rows_of(Vector const& times, Table const& values) {
    return {times.data(), values.data(), values.shape(1), values.shape(0), 0, 0};
  }

  void check_state(Column const& x) const {
    if (static_cast<int>(x.shape(0)) != dynamics().sizes().states)
      throw nb::value_error("x must hold one value per state");
  }
  /// One-dimensional where it has one column.
  static nb::ndarray<nb::numpy, double> matrix(Eigen::MatrixXd const& m) {
    auto const rows = static_cast<std::size_t>(m.rows());
    auto const columns = static_cast<std::size_t>(m.cols());
    return columns == 1 ? owned_array<>(row_major(m), {rows}) : owned_array<>(row_major(m), {rows, columns});
  }

  void require_start() const {
    if (!driver_.started()) throw nb::value_error("start() has not been called");
  }
  MechatronicSystem& blocks() {
    if (driver_.system() == nullptr) throw nb::value_error("the simulation has no controllers");
    return *driver_.system();
  }

  Driver driver_;
  Recorder recorder_;
  std::optional<Readings> readings_;
  std::pair<Vector, Table> kept_;  ///< arrays that the readings stand in
  bool taken_{false};
};

void make_tangent_run(TangentRun* self, Simulation& run,
                      std::vector<std::tuple<Simulation*, Simulation*, double, bool>> const& changed,
                      Matrix const& directions, std::vector<int> kept, std::vector<double> breakpoints) {
  check_value(directions, finite_number, "TangentRun", "directions");
  check_value(breakpoints, finite_number, "TangentRun", "breakpoints");
  for (int const column : kept)
    if (column < 0 || column >= static_cast<int>(run.width())) throw nb::value_error("kept: there is no such column");
  std::vector<ChangedRuns> runs;
  for (auto const& [above, below, half_width, moves_contacts] : changed) {
    check_value(half_width, positive, "TangentRun", "changed");
    runs.push_back({&above->driver(), &below->driver(), half_width, moves_contacts});
  }
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::MatrixXd const columns =
      Eigen::Map<RowMajor const>(directions.data(), static_cast<Eigen::Index>(directions.shape(0)),
                                 static_cast<Eigen::Index>(directions.shape(1)));
  new (self) TangentRun(run.driver(), std::move(runs), columns, std::move(kept), std::move(breakpoints));
}

void bind_tangent_run(nb::module_& m) {
  nb::class_<TangentRun>(m, "TangentRun",
                         "Derivatives of the states and outputs of a simulation that has begun, by numbers that other "
                         "simulations have above and below it, and along directions of its starting state.")
      .def("__init__", &make_tangent_run, "run"_a, "changed"_a, "directions"_a, "kept"_a, "breakpoints"_a,
           nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>())
      .def(
          "advance",
          [](TangentRun& self, double t) {
            check_value(t, finite_number, "advance", "t");
            nb::gil_scoped_release other_threads_may_run;
            return static_cast<int>(self.advance(t));
          },
          "t"_a, "Advances the simulation to a time [s]; returns its status.")
      .def(
          "take_outputs",
          [](TangentRun& self) {
            nb::list outputs;
            for (TangentRun::Output& output : self.take_outputs())
              outputs.append(nb::make_tuple(
                  output.t, owned_array<nb::ndim<1>>(std::move(output.row), {self.width()}),
                  owned_array<nb::ndim<2>>(std::move(output.derivatives), {self.numbers(), self.width()})));
            return outputs;
          },
          "What has been recorded since the last call: time [s], kept columns, their derivatives, one row per number.")
      .def_prop_ro("time", &TangentRun::time)
      .def_prop_ro(
          "tangents", [](TangentRun const& self) { return table(self.tangents()); }, nb::rv_policy::move,
          "Derivatives of the states: (states, numbers and directions).");
}

nb::list field_list(auto const& fields) {
  nb::list list;
  for (auto const& f : fields)
    list.append(nb::make_tuple(std::string(f.name), std::string(f.unit), std::string(f.meaning)));
  return list;
}

}  // namespace

void bind_simulation(nb::module_& m) {
  using S = Simulation;
  Argument const pressure{"pressure", not_negative};
  Argument const t{"t"}, x{"x"}, states{"states"}, controller{"controller"}, step{"step", positive};
  nb::class_<S> simulation(m, "Simulation", "Integrates one model; SI, states as in docs/theory.");
  simulation
      .def(nb::init<std::shared_ptr<Model const>, std::optional<MechatronicSetup>>(), "model"_a, "setup"_a = nb::none(),
           "Of a model, with sensors, controllers and actuators around it if `setup` is given.")
      .def("start", &S::start, "options"_a, "t0"_a, "x0"_a)
      .def("advance", &S::advance, "t_stop"_a, "times"_a.noconvert(), "rows"_a.noconvert(), "filled"_a,
           "Status and rows filled; raises ValueError where `times` and `rows` have no room for the outputs due.")
      .def("keep_readings", &S::keep_readings, "every"_a, "times"_a.noconvert(), "values"_a.noconvert(),
           "At each output time a reading of `reading_fields`, at every `every`-th a row; what does not fit is left "
           "out.")
      .def("equilibrium", &S::equilibrium, "speed"_a, "t"_a, "fixed"_a, "near"_a = nb::none(), "only_near"_a = false);
  def_method(simulation, "waits_for",
             "Whether a controller of the caller must be answered for before advance() continues.", &S::waits_for,
             controller);
  def_method(simulation, "measurement", "What a controller sees, axle by axle: measurement_fields.", &S::measurement,
             Argument{"controller"});
  def_method(simulation, "set_command", "Answers for a controller, one number per axle.", &S::set_command, controller,
             Argument{"command"});
  def_method(simulation, "derivative", "x_dot and z_dot in a state.", &S::derivative, t, x);
  def_method(simulation, "jacobian", "df/dx, dg/dx, df/dt, dg/dt in a state.", &S::jacobian, t, x);
  def_method(
      simulation, "linear_model",
      "A, B, C, D in a state, under cylinder pressures and torques of the rollers (empty: none): inputs are torques of "
      "axles and rollers and cylinder pressures of brakes, outputs the recorded columns of bodies and wheels.",
      &S::linear_model, t, x, pressure, Argument{"roller_torque"});
  def_method(simulation, "hold_speed",
             "Steady rolling under cylinder pressures [Pa], near a state without: state, torques of the rollers that "
             "hold their speed [N m], and whether there is one.",
             &S::hold_speed, t, x, pressure);
  def_method(simulation, "step_amplification", "What one step of a fixed-step method does to a small deviation from x.",
             &S::step_amplification, Argument{"method"}, step, t, x);
  def_method(simulation, "record", "One row of the plant's outputs in a state.", &S::record, t, x, Argument{"z"});
  def_method(simulation, "derivatives", "x_dot of one state per row.", &S::derivatives, t, states);
  simulation.def("statistics", &Simulation::statistics)
      .def("counters", &Simulation::counters)
      .def("contact_losses", &Simulation::contact_losses,
           "Per contact: spells without contact; their sum, the longest and when it began [s].")
      .def_prop_ro("time", &Simulation::time)
      .def_prop_ro("state", &Simulation::state, nb::rv_policy::move)
      .def_prop_ro("width", &Simulation::width)
      .def_prop_ro("reading_width", &Simulation::reading_width)
      .def_prop_ro("reading_count", &Simulation::reading_count)
      .def_prop_ro("state_count", [](Simulation& s) { return s.dynamics().sizes().states; })
      .def_prop_ro("quadrature_count", [](Simulation& s) { return s.dynamics().sizes().quadratures; })
      .def_prop_ro("failed_contact", [](Simulation& s) { return s.dynamics().failed_contact(); })
      .def_prop_ro(
          "torque_bodies",
          [](Simulation& s) {
            std::vector<int> bodies;
            for (auto const& torque : s.dynamics().model().axle_torques) bodies.push_back(torque.wheelset);
            for (auto const& torque : s.dynamics().model().roller_torques) bodies.push_back(torque.roller);
            return bodies;
          },
          "Body that each torque of the model acts on: those of axles, then those of rollers.")
      .def_prop_ro(
          "angle_index", [](Simulation& s) { return s.dynamics().map().angle; },
          "Per body the quadrature that is the angle it has turned; -1: none is.")
      .def_prop_ro("coordinate_index", [](Simulation& s) { return s.dynamics().map().coordinate; })
      .def_prop_ro("rate_index", [](Simulation& s) { return s.dynamics().map().rate; });
  bind_tangent_run(m);
  nb::list readings;
  for (auto const name : Recorder::reading_fields()) readings.append(std::string(name));
  m.attr("reading_fields") = readings;
  m.attr("patches_recorded") = Recorder::patches;
  m.attr("body_fields") = field_list(Recorder::body_fields());
  m.attr("wheel_fields") = field_list(Recorder::wheel_fields());
  m.attr("patch_fields") = field_list(Recorder::patch_fields());
  m.attr("element_fields") = field_list(Recorder::element_fields());
  m.attr("axle_fields") = field_list(MechatronicSystem::axle_fields());
  m.attr("train_fields") = field_list(MechatronicSystem::train_fields());
  m.attr("measurement_fields") = field_list(measurement_fields);
  m.attr("run_fields") = field_list(Recorder::run_fields());
  m.def(
      "status_sentence", [](int status) { return std::string(status_sentence(static_cast<Status>(status))); },
      "status"_a);
  // in the order of Status
  constexpr char const* names[] = {"ok",       "not_finite",        "contact_lost",     "off_profile",
                                   "derailed", "step_too_small",    "too_many_steps",   "interrupted",
                                   "stopped",  "rollers_protected", "controller_failed"};
  nb::dict codes;
  for (char const* name : names) codes[name] = codes.size();
  m.attr("status_codes") = codes;
}
