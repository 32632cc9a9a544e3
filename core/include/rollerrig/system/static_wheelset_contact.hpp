// system/static_wheelset_contact.hpp - a wheelset at rest on its rollers or rails, at a given lateral position and yaw.
//
//   position, load -> [static contact] -> height and roll of the wheelset, its patches
//
// The problem behind `rollerrig contact`: elastic normal forces only. The load acts at the wheelset's centre, and what
// holds the wheelset sideways acts at the height of the running surface, where the creep forces would: so the wheels share
// the load by their lever arms, and a steep flange does not tip the wheelset.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include "rollerrig/contact/patch.hpp"
#include "rollerrig/system/model.hpp"

namespace rollerrig {

/// Position of the wheelset; z and roll are found where they are not given. Over the design position [m, rad].
struct WheelsetPosition {
  double x{0.0}, y{0.0}, z{0.0}, roll{0.0}, yaw{0.0};
};

struct StaticPatch {
  bool right{false};
  double wheel_s{0.0}, rail_y{0.0};      ///< [m]
  double angle{0.0};                     ///< contact angle: slope of the wheel profile as an angle, EN sense [rad]
  double a{0.0}, b{0.0}, approach{0.0};  ///< [m]
  double normal{0.0};                    ///< [N]
  double weight{1.0};         ///< blending weight: contact/normal/hertz_ellipses.hpp, contact/normal/strip_contact.hpp
  double peak_pressure{0.0};  ///< [Pa]
  double length{0.0};         ///< along the rolling direction [m]
  double width{0.0};          ///< across it [m]
  double area{0.0};           ///< [m^2]
  Vec3<double> point{}, direction{};  ///< on the roller and normal, b frame, not mirrored
  double wheel_radius{0.0};           ///< rolling radius at the contact [m]
  bool limited{false};                ///< curvatures outside Hertz' theory
};

struct LoadedWheelset {
  bool converged{false};
  WheelsetPosition position{};
  double vertical{0.0};     ///< sum of vertical contact forces [N]
  double roll_moment{0.0};  ///< about the point below the wheelset's centre at the running surface [N m]
  std::vector<StaticPatch> patches;
};

class StaticWheelsetContact {
 public:
  /// @param left, right  indices of the wheelset's contacts; throws std::invalid_argument where they are not
  StaticWheelsetContact(std::shared_ptr<Model const> model, int left, int right);

  /// The equilibrium under `load` [N]; free to roll, or at position.roll.
  LoadedWheelset solve(WheelsetPosition position, double load, bool free_to_roll) const;

  /// Height z at which the wheel of one side just touches, all else as given [m].
  double touch_height(WheelsetPosition position, bool right) const;

  /// The patches of one side with the normal contact the case asks for.
  std::vector<StaticPatch> patches(WheelsetPosition const& position, bool right) const;

  /// All minima of the gap closer than `reach` in one side, as Hertz patches with negative approach where open.
  std::vector<StaticPatch> minima(WheelsetPosition const& position, bool right, double reach) const;

 private:
  friend class WheelBatch;
  struct Load {
    double vertical, roll_moment;
  };
  RelativePose<double> pose(WheelsetPosition const& p, bool right) const;
  Load load_at(WheelsetPosition const& p) const;
  double height_for(WheelsetPosition p, double load) const;

  std::shared_ptr<Model const> model_;
  std::array<WheelContact const*, 2> contact_;
};

/// Wheels of one side of a wheelset, 0.1 mm apart across, whose normal contacts are evaluated in one call: for timing.
class WheelBatch {
 public:
  WheelBatch(StaticWheelsetContact const& wheelset, WheelsetPosition position, bool right, int wheels);
  void evaluate();

 private:
  NormalLaw const& law_;
  std::vector<RelativePose<double>> pose_;
  std::vector<PatchList<NormalPatch<double>>> patches_;
  std::vector<int> count_;
  std::vector<NormalContact<double, NormalPatch<double>>> contacts_;
};

}  // namespace rollerrig
