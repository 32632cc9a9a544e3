// system/model_parts.hpp - what a model was built of, to be kept and built again.
//
//   Model -> [parts_of] -> ModelParts -> [model_of: ModelBuilder] -> the same Model
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "rollerrig/system/model_builder.hpp"

namespace rollerrig {

/// In the order of the model's indices.
struct ModelParts {
  double gravity{};
  std::vector<Body> bodies{};
  std::vector<ForceElement> elements{};
  std::vector<UniformSpline> profiles{};
  std::vector<ContactDescription> contacts{};
  std::vector<AxleTorque> axle_torques{};
  std::vector<RollerTorque> roller_torques{};
  std::vector<AxleBrake> brakes{};
  std::vector<BodyTrackBrake> track_brakes{};
  std::vector<int> rolling_wheelsets{};  ///< bodies that roll on their rollers without slip
  RunningResistance resistance{};
  TimeTable speed{};
  Line line{};
  double start{};
  std::optional<Irregularity> irregularity{};
  RailHeads left_heads{}, right_heads{};
  double contact_loss_limit{};

  static constexpr auto fields() {
    using P = ModelParts;
    return members(Member{"gravity", &P::gravity, "m/s^2", "acceleration of free fall"}, Member{"bodies", &P::bodies},
                   Member{"elements", &P::elements}, Member{"profiles", &P::profiles}, Member{"contacts", &P::contacts},
                   Member{"axle_torques", &P::axle_torques}, Member{"roller_torques", &P::roller_torques},
                   Member{"brakes", &P::brakes}, Member{"track_brakes", &P::track_brakes},
                   Member{"rolling_wheelsets", &P::rolling_wheelsets, an_index}, Member{"resistance", &P::resistance},
                   Member{"speed", &P::speed, "m/s", "running speed over time"}, Member{"line", &P::line},
                   Member{"start", &P::start, "m", "arc length of the vehicle's reference point at time 0"},
                   Member{"irregularity", &P::irregularity}, Member{"left_heads", &P::left_heads},
                   Member{"right_heads", &P::right_heads},
                   Member{"contact_loss_limit", &P::contact_loss_limit, "s", "duration without contact that ends a run",
                          positive});
  }
};

ModelParts parts_of(Model const& model);

/// Throws std::invalid_argument that names what cannot be built.
std::shared_ptr<Model const> model_of(ModelParts const& parts);

}  // namespace rollerrig
