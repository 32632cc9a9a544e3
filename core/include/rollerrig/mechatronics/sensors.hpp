// mechatronics/sensors.hpp - what controllers see of speeds, torques and loads.
//
//   true motion and forces -> [sensors] -> measurements
//
// To add a speed sensor: a struct here, its line in AnySpeedSensor, its table in
// python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <variant>

#include "rollerrig/fields.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// Normally distributed number of mean 0 and deviation 1, the n-th of a stream (SplitMix64 and Box-Muller): a function of seed and
/// sample number alone, so that a run repeats to the last bit.
inline double normal_number(std::uint64_t stream, std::uint64_t n) {
  auto const mix = [](std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  };
  auto const uniform = [&](std::uint64_t k) {  // in (0, 1)
    return (static_cast<double>(mix(mix(stream) ^ k) >> 11) + 0.5) * 0x1p-53;
  };
  return std::sqrt(-2.0 * std::log(uniform(2 * n))) * std::cos(2.0 * pi * uniform(2 * n + 1));
}

/// The true motion of an axle at an instant, of which a speed sensor reads some.
struct AxleTurn {
  double time{};   ///< [s]
  double angle{};  ///< since the start [rad]
  double speed{};  ///< [rad/s]
  void state(auto& archive) { archive(time, angle, speed); }
};

/// Samples over which an encoder's counts may be differenced.
inline constexpr int longest_window = 16;
inline constexpr Range window_range{0.0, longest_window, "0 to 16 samples"};

/// Incremental encoder: speed from the counts of the last few samples.
///
///   true angle at the sampling instant -> [counts] -> their difference over the window -> speed
struct Encoder {
  static constexpr char const* name = "encoder";

  double counts{}, jitter{};
  int window{};  ///< samples over which counts are differenced, 1..16

  static constexpr auto fields() {
    return members(
        Member{"counts", &Encoder::counts, "1", "counts per turn; 0: an ideal sensor", not_negative},
        Member{"jitter", &Encoder::jitter, "1", "standard deviation of the edges' position, in counts", not_negative},
        Member{"window", &Encoder::window, window_range});
  }

  struct State {
    std::array<double, longest_window + 1> counts{};
    int head{0};  ///< one past the newest count
    int filled{0};
    double last_speed{0.0}, offset{0.0};
    std::uint64_t samples{0};
    void state(auto& archive) {
      archive(counts, last_speed, offset, samples);
      for (int* place : {&head, &filled}) archive.within(*place, 0, longest_window);
    }
  };

  State start(AxleTurn const& now, std::uint64_t /*stream*/) const {
    State state;
    state.last_speed = now.speed;
    state.offset = now.angle;
    return state;
  }

  void follow(State& /*state*/, AxleTurn const& /*now*/, std::uint64_t /*stream*/) const {}

  /// Speed that the controller sees [rad/s].
  ///
  /// @param period  sample time [s]
  double read(State& s, AxleTurn const& now, double period, std::uint64_t stream) const {
    if (!(counts > 0.0)) return now.speed;
    double const shift = jitter > 0.0 ? jitter * normal_number(stream, s.samples) : 0.0;
    ++s.samples;
    double const count = std::floor((now.angle - s.offset) / (2.0 * pi) * counts + shift);
    int const over = std::clamp(window, 1, longest_window);
    if (s.filled >= 1) {
      int const back = s.filled < over ? s.filled : over;
      double const before = s.counts[at((s.head + longest_window + 1 - back) % (longest_window + 1))];
      s.last_speed = (count - before) * 2.0 * pi / (counts * back * period);
    }
    s.head = (s.head + 1) % (longest_window + 1);
    s.counts[at((s.head + longest_window) % (longest_window + 1))] = count;
    if (s.filled < longest_window) ++s.filled;
    return s.last_speed;
  }
};

/// Toothed wheel and pick-up: edges that pass, and when.
///
///   true angle at each step -> [phonic wheel] -> number of edges, time of the last one
///
/// One pick-up does not tell the direction: an axle that swings about standstill gives edges as one that turns.
struct PhonicWheel {
  double teeth{};        ///< around it
  double pitch_error{};  ///< standard deviation of a tooth's place [pitches]; the same tooth after each turn

  double pitch() const { return 2.0 * pi / teeth; }  ///< [rad]

  /// Angle of the m-th edge [rad]; a tooth stays between its neighbours.
  double edge(double m, std::uint64_t stream) const {
    if (!(pitch_error > 0.0)) return m * pitch();
    double const tooth = m - teeth * std::floor(m / teeth);
    double const shift = pitch_error * normal_number(stream, static_cast<std::uint64_t>(tooth));
    return (m + std::clamp(shift, -0.4, 0.4)) * pitch();
  }

  double last_edge(double angle, std::uint64_t stream) const {
    double const m = std::floor(angle / pitch());
    if (!(pitch_error > 0.0)) return m;
    return edge(m, stream) > angle ? m - 1.0 : edge(m + 1.0, stream) <= angle ? m + 1.0 : m;
  }
};

struct PassedEdges {
  double edge{0.0};   ///< the last one behind the pick-up
  double angle{0.0};  ///< at the last step [rad]
  double time{0.0};   ///< of it [s]
  void state(auto& archive) { archive(edge, angle, time); }

  /// One step on: number of edges passed; `at` becomes the time of the last of them, to within the change of speed over a step.
  double follow(PhonicWheel const& wheel, AxleTurn const& now, std::uint64_t stream, double& at) {
    double const reached = wheel.last_edge(now.angle, stream);
    double const passed = std::fabs(reached - edge);
    if (passed > 0.0) {
      double const last = wheel.edge(reached > edge ? reached : reached + 1.0, stream);
      at = time + std::clamp((last - angle) / (now.angle - angle), 0.0, 1.0) * (now.time - time);
    }
    edge = reached;
    angle = now.angle;
    time = now.time;
    return passed;
  }
};

/// Speed from the time between edges of a phonic wheel.
///
///   edges -> [clock] -> whole pitches over the time between two edges -> speed; no edge for long: slower, then standstill
///
///     w = n (2 pi/z) / (t_n - t_0),    without an edge for a time t:  w <= (2 pi/z)/t;  t > timeout: w = 0        (A14)
///
/// Source  the common measurement of speed by pulse periods; docs/theory/adhesion.md. A magnitude: one pick-up.
struct PulsePeriod {
  static constexpr char const* name = "pulse_period";

  double teeth{}, pitch_error{}, averaging_time{}, timeout{}, clock{};

  static constexpr auto fields() {
    using P = PulsePeriod;
    return members(
        Member{"teeth", &P::teeth, "1", "number of teeth", positive},
        Member{"pitch_error", &P::pitch_error, "1", "standard deviation of a tooth's position, in pitches",
               not_negative},
        Member{"averaging_time", &P::averaging_time, "s",
               "least duration over which edges are timed; 0: from sample to sample", not_negative},
        Member{"timeout", &P::timeout, "s", "duration without an edge after which the axle stands", positive},
        Member{"clock", &P::clock, "Hz", "frequency of the clock that times the edges; 0: exact", not_negative});
  }

  struct State {
    PassedEdges edges{};
    bool timing{false};               ///< the first edge after standstill only starts the clock
    double from{0.0}, last{0.0};      ///< times of the first and the last edge counted [s]
    double counted{0.0}, speed{0.0};  ///< edges between them; last result [rad/s]
    void state(auto& archive) { archive(edges, timing, from, last, counted, speed); }
  };

  State start(AxleTurn const& now, std::uint64_t stream) const {
    State state;
    state.edges = {wheel().last_edge(now.angle, stream), now.angle, now.time};
    state.last = now.time;
    state.speed = std::fabs(now.speed);
    return state;
  }

  void follow(State& s, AxleTurn const& now, std::uint64_t stream) const {
    double at = 0.0;
    double const passed = s.edges.follow(wheel(), now, stream, at);
    if (!(passed > 0.0)) return;
    s.last = clock > 0.0 ? std::floor(at * clock) / clock : at;
    s.counted += passed;
    if (s.timing) return;
    s.timing = true;
    s.from = s.last;
    s.counted = 0.0;
  }

  double read(State& s, AxleTurn const& now, double /*period*/, std::uint64_t /*stream*/) const {
    double const silent = now.time - s.last;
    if (silent > timeout) {
      s.timing = false;
      s.counted = 0.0;
      return s.speed = 0.0;
    }
    if (s.counted > 0.0 && s.last > s.from && s.last - s.from >= averaging_time) {
      s.speed = s.counted * wheel().pitch() / (s.last - s.from);
      s.from = s.last;
      s.counted = 0.0;
    }
    double const surely = silent - (clock > 0.0 ? 1.0 / clock : 0.0);
    if (surely > 0.0) s.speed = std::fmin(s.speed, due * wheel().pitch() / surely);
    return s.speed;
  }

 private:
  static constexpr double due = 1.0 + 1e-9;  ///< round-off: an edge due now is no sign of slowing

  PhonicWheel wheel() const { return {teeth, pitch_error}; }
};

/// Speed from the number of edges of a phonic wheel in a gate time.
///
///   edges -> [counter over the gate time] -> speed, in steps of one edge per gate time        (A15)
struct PulseFrequency {
  static constexpr char const* name = "pulse_frequency";

  double teeth{}, pitch_error{}, gate_time{};

  static constexpr auto fields() {
    using P = PulseFrequency;
    return members(
        Member{"teeth", &P::teeth, "1", "number of teeth", positive},
        Member{"pitch_error", &P::pitch_error, "1", "standard deviation of a tooth's position, in pitches",
               not_negative},
        Member{"gate_time", &P::gate_time, "s", "least duration over which edges are counted", not_negative});
  }

  struct State {
    PassedEdges edges{};
    double opened{0.0};               ///< the gate [s]
    double counted{0.0}, speed{0.0};  ///< edges since; last result [rad/s]
    void state(auto& archive) { archive(edges, opened, counted, speed); }
  };

  State start(AxleTurn const& now, std::uint64_t stream) const {
    return {.edges = {wheel().last_edge(now.angle, stream), now.angle, now.time},
            .opened = now.time,
            .counted = 0.0,
            .speed = std::fabs(now.speed)};
  }

  void follow(State& s, AxleTurn const& now, std::uint64_t stream) const {
    double at = 0.0;
    s.counted += s.edges.follow(wheel(), now, stream, at);
  }

  double read(State& s, AxleTurn const& now, double /*period*/, std::uint64_t /*stream*/) const {
    constexpr double rounding = 1.0 - 1e-9;  // of the sum of steps that the gate time is
    double const open = now.time - s.opened;
    if (open > 0.0 && open >= gate_time * rounding) {
      s.speed = s.counted * wheel().pitch() / open;
      s.opened = now.time;
      s.counted = 0.0;
    }
    return s.speed;
  }

 private:
  PhonicWheel wheel() const { return {teeth, pitch_error}; }
};

/// A force or torque transducer: first-order lag, then noise, resolution and range of its reading.
///
///   true force at each step -> [transducer] -> reading at the sampling instant
struct ForceSensor {
  std::optional<double> bandwidth{};
  double noise{}, resolution{};
  std::optional<double> range{};

  static constexpr auto fields() {
    using P = ForceSensor;
    return members(Member{"bandwidth", &P::bandwidth, "rad/s", "bandwidth of the lag; absent: no lag", positive},
                   Member{"noise", &P::noise, "N or N m", "standard deviation of a reading", not_negative},
                   Member{"resolution", &P::resolution, "N or N m", "resolution of a reading; 0: none", not_negative},
                   Member{"range", &P::range, "N or N m", "largest |reading|; absent: no limit", positive});
  }
};

class ForceReading {
 public:
  void reset(double value) {
    filtered_ = last_ = value;
    samples_ = 0;
  }

  /// The lag over one step, exact for a value on a straight line.
  void follow(ForceSensor const& sensor, double value, double step) {
    if (sensor.bandwidth) {
      double const slope = (value - last_) / step;
      double const behind = slope / *sensor.bandwidth;  // of the settled ramp
      filtered_ = value - behind + (filtered_ - last_ + behind) * std::exp(-*sensor.bandwidth * step);
    } else {
      filtered_ = value;
    }
    last_ = value;
  }

  double read(ForceSensor const& sensor, std::uint64_t stream) {
    double reading = filtered_;
    if (sensor.noise > 0.0) reading += sensor.noise * normal_number(stream, samples_++);
    if (sensor.resolution > 0.0) reading = sensor.resolution * std::round(reading / sensor.resolution);
    if (sensor.range) reading = std::fmin(*sensor.range, std::fmax(-*sensor.range, reading));
    return reading;
  }

  void state(auto& archive) { archive(filtered_, last_, samples_); }

 private:
  double filtered_{0.0}, last_{0.0};
  std::uint64_t samples_{0};
};

/// Mean of a drive's torque between the samples of its controller, by trapezes over the steps.
class MeanTorque {
 public:
  void follow(double torque) {
    if (begun_) sum_ += 0.5 * (now_ + torque), ++steps_;
    now_ = torque;
    begun_ = true;
  }
  double now() const { return now_; }
  double take() {
    double const mean = steps_ > 0 ? sum_ / steps_ : 0.0;
    sum_ = 0.0;
    steps_ = 0;
    return mean;
  }

  void state(auto& archive) {
    archive(now_, sum_, begun_);
    archive.within(steps_, 0, 1 << 30);
  }

 private:
  double now_{0.0}, sum_{0.0};
  int steps_{0};
  bool begun_{false};
};

using AnySpeedSensor = OneOf<Encoder, PulsePeriod, PulseFrequency>;

struct Sensors {
  AnySpeedSensor axles{}, rollers{};           ///< for the rig's controller
  std::optional<AnySpeedSensor> vehicle{};     ///< the vehicle's own, for its controllers; absent: those of `axles`
  std::optional<ForceSensor> roller_torque{};  ///< in the drive shaft of each roller axle; absent: its torque is known
  ForceSensor axle_load{};                     ///< vertical force of rail or rollers on both wheels of an axle
  std::uint64_t seed{};                        ///< of all noise

  static constexpr auto fields() {
    using P = Sensors;
    return members(Member{"axles", &P::axles}, Member{"rollers", &P::rollers}, Member{"vehicle", &P::vehicle},
                   Member{"roller_torque", &P::roller_torque}, Member{"axle_load", &P::axle_load},
                   Member{"seed", &P::seed, any_integer});
  }
};

}  // namespace rollerrig
