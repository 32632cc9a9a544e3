// mechatronics/speed_sensor/pulse_period.hpp - speed from the time between edges of a phonic wheel.
//
//   edges -> [clock] -> whole pitches over the time between two edges -> speed; no edge for long: slower, then standstill
//
//     w = n (2 pi/z) / (t_n - t_0),    without an edge for a time t:  w <= (2 pi/z)/t;  t > timeout: w = 0        (A14)
//
// Source  the common measurement of speed by pulse periods; docs/theory/adhesion.md. A magnitude: one pick-up.
#pragma once
#include <cmath>
#include <cstdint>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/speed_sensor/phonic_wheel.hpp"

namespace rollerrig {

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

}  // namespace rollerrig
