// Small models for the tests of the system: a wheelset on rollers or rails, on springs or free; and a vehicle on track.
#pragma once
#include <memory>

#include "profiles.hpp"
#include "rollerrig/system/dynamics.hpp"
#include "rollerrig/system/equilibrium.hpp"

namespace rollerrig::test {

/// Parts of a model, to be changed before it is built.
struct Parts : ModelParts {
  operator std::shared_ptr<Model const>() const { return build(); }
  std::shared_ptr<Model const> build() const { return model_of(*this); }
};

struct Setup {
  double roller_radius = 0.725;  ///< [m]; 0: rails
  double speed = 20.0;           ///< [m/s]
  double friction = 0.3;
  bool driven = true;           ///< rollers controlled in speed
  double lateral_spring = 2e6;  ///< [N/m], to ground, and the same along; 0: none
};

/// A wheelset of 11 t on its springs; S1002 on UIC60.
Parts wheelset_parts(Setup const& setup);
std::shared_ptr<Model const> wheelset_model(Setup const& setup);

/// A frame on two wheelsets, S1002 on UIC60.
struct VehicleSetup {
  double speed = 20.0;         ///< [m/s]
  double wheelbase = 8.0;      ///< long: the frames of its wheelsets differ
  bool elastic_rails = false;  ///< each rail on springs under each wheelset; it rolls about its foot
  double shift = 0.0;          ///< the line, the irregularities and the start moved along by this [m]
  double side = 1.0;           ///< -1: everything mirrored
};

/// Curvature 0 to 1/400 m and cant 0 to 120 mm over 40 m from 10 m on, without corners, and back through zero to a reverse
/// curve without a straight between.
Line curved_line(double shift = 0.0, double side = 1.0);

/// Rails that go apart, one more than the other, rise and lean over 30 m from 20 m on, and stay so.
void lay_rails(Line& line, double shift = 0.0, double side = 1.0);

/// A wave of each rail, no two alike, over 60 m; right and left change places in the mirror.
Irregularity waves(double side = 1.0, double fade_in = 20.0);

Parts vehicle_parts(VehicleSetup const& setup);
std::shared_ptr<Model const> vehicle_model(VehicleSetup const& setup);

}  // namespace rollerrig::test
