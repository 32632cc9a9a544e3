// mechatronics/speed_sensor/phonic_wheel.hpp - toothed wheel and pick-up: edges that pass, and when.
//
//   true angle at each step -> [phonic wheel] -> number of edges, time of the last one
//
// One pick-up does not tell the direction: an axle that swings about standstill gives edges as one that turns.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "rollerrig/mechatronics/noise.hpp"
#include "rollerrig/mechatronics/speed_sensor/axle_turn.hpp"

namespace rollerrig {

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

  /// The last edge before an angle.
  double last_edge(double angle, std::uint64_t stream) const {
    double const m = std::floor(angle / pitch());
    if (!(pitch_error > 0.0)) return m;
    return edge(m, stream) > angle ? m - 1.0 : edge(m + 1.0, stream) <= angle ? m + 1.0 : m;
  }
};

/// Edges since the start.
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

}  // namespace rollerrig
