// mechatronics/speed_sensor/encoder.hpp - incremental encoder: speed from the counts of the last few samples.
//
//   true angle at the sampling instant -> [counts] -> their difference over the window -> speed
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/noise.hpp"
#include "rollerrig/mechatronics/speed_sensor/axle_turn.hpp"

namespace rollerrig {

/// Samples over which an encoder's counts may be differenced.
inline constexpr int longest_window = 16;
inline constexpr Range window_range{0.0, longest_window, "0 to 16 samples"};

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
    int const over = window < 1 ? 1 : window > longest_window ? longest_window : window;
    if (s.filled >= 1) {
      int const back = s.filled < over ? s.filled : over;
      double const before =
          s.counts[static_cast<std::size_t>((s.head + longest_window + 1 - back) % (longest_window + 1))];
      s.last_speed = (count - before) * 2.0 * pi / (counts * back * period);
    }
    s.head = (s.head + 1) % (longest_window + 1);
    s.counts[static_cast<std::size_t>((s.head + longest_window) % (longest_window + 1))] = count;
    if (s.filled < longest_window) ++s.filled;
    return s.last_speed;
  }
};

}  // namespace rollerrig
