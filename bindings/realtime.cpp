// bindings/realtime.cpp - the server in real time: made in Python, run without it.
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <memory>
#include <system_error>

#include "arguments.hpp"
#include "fields.hpp"
#include "rollerrig/realtime/rig.hpp"
#include "rollerrig/realtime/server.hpp"
#include "rollerrig/realtime/system.hpp"

using namespace nb::literals;
using namespace rollerrig;
using namespace rollerrig::realtime;

namespace {

using Loop = Server<Rig, AnyPort, DeadlineClock>;

constexpr double most_recorded = 2.5e8;
constexpr Range a_port{0.0, 65535.0, "from 0 to 65535"};
constexpr char const* endings[] = {"ran", "stopped_by_caller", "plant_ended", "controller_silent"};

/// Of the rig's chosen inputs, with their safe values.
std::vector<Input> inputs_of(Rig const& rig, std::vector<int> const& chosen, std::vector<double> const& safe) {
  if (safe.size() != chosen.size()) throw nb::value_error("safe: needed is one number per input");
  std::vector<Input> inputs;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    Variable const& variable = rig.plant().variables()[static_cast<std::size_t>(chosen[i])];
    if (!variable.allows(safe[i])) throw nb::value_error(("safe: not allowed for " + variable.name).c_str());
    inputs.push_back({variable.start, safe[i], variable.least, variable.most, variable.whole});
  }
  return inputs;
}

/// Settings, if a frame and a record of such a run have room.
ServerSettings with_room(ServerSettings const& settings, Rig const& rig) {
  if (rig.outputs() > RR_MOST_VALUES || rig.inputs() > RR_MOST_VALUES)
    throw nb::value_error("inputs, outputs: a frame holds at most 512 numbers");
  double const kept = static_cast<double>(settings.periods) * static_cast<double>(rig.inputs() + rig.outputs());
  if (settings.record && kept > most_recorded)
    throw nb::value_error("settings: periods must be fewer for a record, it holds at most 2.5e8 numbers");
  return settings;
}

nb::tuple spread(Histogram const& h) {
  return nb::make_tuple(h.count(), h.quantile(0.5), h.quantile(0.99), h.quantile(0.9999), h.largest());
}

auto table(std::vector<double> const& values, std::size_t rows, std::size_t columns) {
  std::vector<double> part(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rows * columns));
  return owned_array<nb::ndim<2>>(std::move(part), {rows, columns});
}

class RigServer {
 public:
  RigServer(AssembledModel const& assembled, std::vector<int> const& inputs, std::vector<int> const& outputs,
            std::vector<double> const& safe, std::string const& description, std::string const& address, int port,
            ServerSettings const& settings)
      : rig_{assembled, inputs, outputs, settings.period},
        port_{address, port},
        clock_{std::llround(1e9 * settings.spin)},
        loop_{rig_, port_, clock_, inputs_of(rig_, inputs, safe), description, with_room(settings, rig_)},
        in_real_time_{!settings.lock_step} {}

  /// How it ended, the code of the plant's status, and what the system allowed for memory and scheduling.
  std::tuple<std::string, int, std::string, std::string> run() {
    if (taken_.exchange(true)) throw std::logic_error("a server runs once");
    nb::gil_scoped_release other_threads_may_run;
    std::string memory = "not asked for", scheduling = "not asked for";
    Ending ending = Ending::plant_ended;
    if (in_real_time_) {
      RealTimePriority const priority;
      memory = priority.memory(), scheduling = priority.scheduling();
      if (rig_.start() == Status::ok) ending = loop_.run();
    } else if (rig_.start() == Status::ok) {
      ending = loop_.run();
    }
    return {endings[static_cast<int>(ending)], static_cast<int>(rig_.plant().status()), memory, scheduling};
  }

  void stop() { loop_.stop(); }
  int port() const { return port_.port(); }
  std::string failed_wheel() const { return std::string(rig_.plant().failed_wheel()); }

  nb::dict statistics() const {
    Statistics const& s = loop_.statistics();
    nb::dict d, frames;
    d["step"] = spread(s.step);
    d["wake"] = spread(s.wake);
    d["periods"] = s.periods.get();
    d["waited"] = s.waited.get();
    d["misses"] = s.misses.get();
    d["skipped"] = s.skipped.get();
    d["trips"] = s.trips.get();
    d["first_trip"] = 1e-9 * static_cast<double>(s.first_trip.get());
    d["silent"] = s.silent.get();
    d["longest_silent"] = s.longest_silent.get();
    d["time"] = 1e-9 * static_cast<double>(s.time.get());
    d["state"] = s.state.load();
    for (std::size_t v = 0; v < verdict_count; ++v)
      frames[nb::str(verdict_names[v].data())] = loop_.gate().counted(static_cast<Verdict>(v));
    d["frames"] = frames;
    return d;
  }

  /// Rows (upper edge [ns], periods, wakings) of the bins that have any.
  std::vector<std::tuple<std::uint64_t, std::uint64_t, std::uint64_t>> histogram() const {
    std::vector<std::tuple<std::uint64_t, std::uint64_t, std::uint64_t>> rows;
    Statistics const& s = loop_.statistics();
    for (std::size_t i = 0; i < Histogram::bins(); ++i)
      if (s.step.in_bin(i) + s.wake.in_bin(i) > 0)
        rows.emplace_back(Histogram::upper_edge(i), s.step.in_bin(i), s.wake.in_bin(i));
    return rows;
  }

  auto commands() const {
    Record const& record = loop_.recorded();
    return table(record.commands, record.periods, record.inputs);
  }
  auto sensors() const {
    Record const& record = loop_.recorded();
    return table(record.sensors, record.taken() ? record.periods + 1 : 0, record.outputs);
  }

 private:
  Rig rig_;
  AnyPort port_;
  DeadlineClock clock_;
  Loop loop_;
  bool in_real_time_;
  std::atomic<bool> taken_{false};
};

/// Processor time of each period of a rig from its start, commands at their start values [ns].
nb::tuple measure_rig(AssembledModel const& assembled, std::vector<int> const& inputs, std::vector<int> const& outputs,
                      double period, int periods, int repeats) {
  require_real_time();
  Rig rig(assembled, inputs, outputs, period);
  auto cost = std::make_unique<Histogram>();
  {
    nb::gil_scoped_release other_threads_may_run;
    measure_periods(rig, static_cast<std::size_t>(periods), repeats, &processor_time, *cost);
  }
  return spread(*cost);
}

/// Outputs at the start and after each period, the commands given beforehand; fewer where the run ends before.
auto replay_rig(AssembledModel const& assembled, std::vector<int> const& inputs, std::vector<int> const& outputs,
                double period, Matrix const& commands) {
  if (commands.shape(1) != inputs.size()) throw nb::value_error("commands: needed is one column per input");
  Rig rig(assembled, inputs, outputs, period);
  std::size_t const n = outputs.size();
  std::vector<double> rows(n * (commands.shape(0) + 1));
  std::size_t done = 0;
  {
    nb::gil_scoped_release other_threads_may_run;
    bool goes_on = rig.start() == Status::ok;
    rig.read(rows);
    while (goes_on && done < commands.shape(0)) {
      goes_on = rig.step({commands.data() + done * inputs.size(), inputs.size()});
      rig.read(std::span(rows).subspan(n * ++done, n));
    }
  }
  return table(rows, done + 1, n);
}

}  // namespace

void bind_realtime(nb::module_& m) {
  Argument const assembled{"assembled"}, inputs{"inputs", an_index}, outputs{"outputs", an_index};
  Argument const period{"period", Range{1e-6, 10.0, "from 1e-6 to 10 s"}};
  bind_struct<ServerSettings>(m, "ServerSettings", "How a server keeps time, and how long it is patient.");
  nb::class_<RigServer>(m, "RigServer", "A rig that answers a controller, period by period.")
      .def(
          "__init__",
          [](RigServer* self, AssembledModel const& model, std::vector<int> const& commands,
             std::vector<int> const& sensors, std::vector<double> const& safe, std::string const& description,
             std::string const& address, int port, ServerSettings const& settings) {
            check_value(safe, finite_number, "RigServer", "safe");
            check_value(port, a_port, "RigServer", "port");
            new (self) RigServer(model, commands, sensors, safe, description, address, port, settings);
          },
          nb::kw_only(), "assembled"_a, "inputs"_a, "outputs"_a, "safe"_a, "description"_a, "address"_a, "port"_a,
          "settings"_a)
      .def("run", &RigServer::run, "To its end, without the interpreter: ending, status, memory, scheduling.")
      .def("stop", &RigServer::stop, "Ends run() after the period at work; from any thread.")
      .def("statistics", &RigServer::statistics, "At any time, from any thread.")
      .def("histogram", &RigServer::histogram, "Rows: upper edge [ns], steps, wakings.")
      .def("commands", &RigServer::commands, "What acted in each period, if it was recorded.")
      .def("sensors", &RigServer::sensors, "Of the start and of the end of each period, if it was recorded.")
      .def_prop_ro("port", &RigServer::port)
      .def_prop_ro("failed_wheel", &RigServer::failed_wheel);
  def_function(m, "measure_rig", "Least processor time of each period [ns]: count, median, 99 %, 99.99 %, longest.",
               &measure_rig, assembled, inputs, outputs, period,
               Argument{"periods", Range{1.0, 2e6, "a count from 1 to 2e6"}},
               Argument{"repeats", Range{1.0, 100.0, "a count from 1 to 100"}});
  def_function(m, "replay_rig", "Outputs at the start and after each period of given commands.", &replay_rig, assembled,
               inputs, outputs, period, Argument{"commands"});
  def_function(m, "require_real_time", "Raises RuntimeError where this system has no server.", &require_real_time);
}
