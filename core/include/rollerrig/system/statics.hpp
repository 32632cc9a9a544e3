// system/statics.hpp - how a vehicle stands on its wheels in the design position.
//
//   masses and load-carrying springs -> [least squares] -> preload of each spring, load of each axle
#pragma once
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/vector.hpp"

namespace rollerrig {

/// A body of a vehicle at rest.
struct StandingBody {
  double mass{0.0};
  Vec3<double> position{};
  bool on_wheels{false};  ///< a wheelset: whatever presses on it, the track carries

  static constexpr auto fields() {
    using P = StandingBody;
    return members(Member{"mass", &P::mass, "kg", "mass", not_negative},
                   Member{"position", &P::position, "m", "position of the centre of mass"},
                   Member{"on_wheels", &P::on_wheels});
  }
};

/// An element that carries load in the design position.
struct LoadSpring {
  int body_a{0}, body_b{0};
  Vec3<double> point{};

  static constexpr auto fields() {
    using P = LoadSpring;
    return members(Member{"body_a", &P::body_a, an_index}, Member{"body_b", &P::body_b, an_index},
                   Member{"point", &P::point, "m", "point of action of its force"});
  }
};

struct StaticLoads {
  std::vector<double> preload;  ///< per spring: vertical force on its body b [N]
  std::vector<double> on_body;  ///< per body: weight and what the springs press on it; of a wheelset the axle load [N]
  double imbalance{0.0};        ///< largest force [N] or moment [N m] that no spring balances
};

/// Preloads that hold the design position: the smallest forces (least squares) for which every body but the wheelsets is in
/// balance, locks ignored.
///
/// Throws std::invalid_argument where a spring names a body that is not there.
StaticLoads static_loads(std::vector<StandingBody> const& bodies, std::vector<LoadSpring> const& springs,
                         double gravity);

}  // namespace rollerrig
