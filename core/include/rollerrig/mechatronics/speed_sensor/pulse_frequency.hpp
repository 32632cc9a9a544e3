// mechatronics/speed_sensor/pulse_frequency.hpp - speed from the number of edges of a phonic wheel in a gate time.
//
//   edges -> [counter over the gate time] -> speed, in steps of one edge per gate time        (A15)
#pragma once
#include <cmath>
#include <cstdint>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/speed_sensor/phonic_wheel.hpp"

namespace rollerrig {

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

}  // namespace rollerrig
