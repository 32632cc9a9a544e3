// simulate/setup.hpp - sensors, controllers and actuators around a vehicle under test: everything that is constant in a run.
//
//   plant -> sensors -> controllers -> actuators -> inputs of the plant
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <variant>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/brake_unit.hpp"
#include "rollerrig/mechatronics/brakes.hpp"
#include "rollerrig/mechatronics/motor.hpp"
#include "rollerrig/mechatronics/pneumatics.hpp"
#include "rollerrig/mechatronics/rig_controller.hpp"
#include "rollerrig/mechatronics/sanding.hpp"
#include "rollerrig/mechatronics/sensors.hpp"
#include "rollerrig/mechatronics/simulated_axles.hpp"
#include "rollerrig/mechatronics/wheel_slide_protection.hpp"
#include "rollerrig/mechatronics/wheel_slip_control.hpp"

namespace rollerrig {

/// The controllers that a case can have, each a table of its name. To add one: a header with a struct like WheelSlipControl, its line
/// here, its table in the configuration.
using AnyController = std::variant<WheelSlideProtection, WheelSlipControl, RigController, BrakeUnit>;

inline Command command_of(AnyController const& any) {
  return std::visit([](auto const& law) { return law.command; }, any);
}

inline constexpr Range sampling_steps{1.0, 1e9, "one step or more"};
inline constexpr Range delay_steps{0.0, 1e5, "none to 100000 steps"};  ///< each is kept

/// When a controller is asked, and how long its answer takes.
struct Sampling {
  int every{1};          ///< sample time in sampling steps
  int delay{0};          ///< sampling steps from the sample to the command's acting
  bool external{false};  ///< the caller computes the command

  static constexpr auto fields() {
    return members(Member{"every", &Sampling::every, sampling_steps}, Member{"delay", &Sampling::delay, delay_steps},
                   Member{"external", &Sampling::external});
  }
};

struct SampledController {
  Sampling sampling{};
  AnyController controller{};

  static constexpr auto fields() {
    using P = SampledController;
    return members(Member{"sampling", &P::sampling}, Member{"controller", &P::controller});
  }
};

constexpr int absent = -1;

/// One axle of the train: of the vehicle under test, by indices of the model, with its rollers on a rig, or only simulated.
struct AxleParts {
  int wheelset{absent};     ///< body; absent: the axle is simulated, see simulated_axles.hpp
  int axle_torque{absent};  ///< of the traction motor
  int brake{absent};
  int roller{absent};         ///< body
  int roller_torque{absent};  ///< of the roller's drive
  std::array<int, 2> contacts{absent, absent};
  bool has_brake{};  ///< of a simulated axle
  bool has_motor{};  ///< of a simulated axle

  bool driven() const { return axle_torque != absent || has_motor; }
  bool electrodynamic{};  ///< brakes with its motor too
  bool sands{};           ///< sand falls in front of its wheels

  static constexpr auto fields() {
    using P = AxleParts;
    return members(
        Member{"wheelset", &P::wheelset, index_or_none}, Member{"axle_torque", &P::axle_torque, index_or_none},
        Member{"brake", &P::brake, index_or_none}, Member{"roller", &P::roller, index_or_none},
        Member{"roller_torque", &P::roller_torque, index_or_none}, Member{"contacts", &P::contacts, index_or_none},
        Member{"has_brake", &P::has_brake}, Member{"has_motor", &P::has_motor},
        Member{"electrodynamic", &P::electrodynamic}, Member{"sands", &P::sands});
  }
};

/// The same on each axle; what no axle has is never evaluated.
struct Actuators {
  FrictionBrake brake{};
  Pneumatics pneumatics{};
  bool by_traction_motors{};                            ///< the traction motors exert the brake's torque
  std::optional<ElectrodynamicBrake> electrodynamic{};  ///< of the axles that have it
  std::optional<TrackBrake> track_brake{};
  TimeTable brake_demand{};
  Motor motor{};
  TimeTable torque_demand{};
  Motor roller_drive{};

  static constexpr auto fields() {
    using P = Actuators;
    return members(
        Member{"brake", &P::brake}, Member{"pneumatics", &P::pneumatics},
        Member{"by_traction_motors", &P::by_traction_motors}, Member{"electrodynamic", &P::electrodynamic},
        Member{"track_brake", &P::track_brake},
        Member{"brake_demand", &P::brake_demand, "Pa", "demanded cylinder pressure over the ambient, over time"},
        Member{"motor", &P::motor},
        Member{"torque_demand", &P::torque_demand, "N m",
               "demanded torque of the traction motor of each axle, positive forward, over time"},
        Member{"roller_drive", &P::roller_drive});
  }
};

/// Ends a test on rollers before real sliding damages them.
struct RollerProtection {
  double slip{}, time{};

  static constexpr auto fields() {
    return members(
        Member{"slip", &RollerProtection::slip, "m/s", "real sliding between wheel and roller that damages them",
               not_negative},
        Member{"time", &RollerProtection::time, "s", "duration of such sliding that ends a test", not_negative});
  }
};

/// On track the vehicle's frame moves at the train's speed.
struct TravellingFrame {
  double train_mass{}, fixed_mass{};

  static constexpr auto fields() {
    using P = TravellingFrame;
    return members(Member{"train_mass", &P::train_mass, "kg",
                          "mass that these axles brake or pull; 0: on a rig the frame does not move", not_negative},
                   Member{"fixed_mass", &P::fixed_mass, "kg", "part of it that is fixed in the frame", not_negative});
  }
};

struct MechatronicSetup {
  double step{}, speed{}, stop_speed{};
  std::vector<AxleParts> axles{};
  Actuators actuators{};
  Sensors sensors{};
  std::vector<SampledController> controllers{};
  RollerProtection protection{};
  TravellingFrame frame{};
  double rail_cell{}, energy_width{}, wheel_memory{};
  std::optional<Sanding> sanding{};
  SimulatedAxles simulated{};         ///< the last ones of `axles`
  std::optional<VirtualRail> rail{};  ///< under them
  std::vector<double> brake_delay{};
  std::vector<int> reservoir{};    ///< number of the reservoir that feeds each axle; empty: one feeds all
  std::vector<int> relay_valve{};  ///< number of each axle's relay valve; empty: one for each reservoir

  /// Axles in the model: the first ones of `axles`.
  std::size_t under_test() const { return axles.size() - simulated.count(); }
  /// Cylinder pressure asked of an axle [Pa].
  double demand(std::size_t axle, double t) const {
    return actuators.brake_demand.at(brake_delay.empty() ? t : t - brake_delay[axle]);
  }

  /// Whether the brake unit is asked as a controller is.
  bool brake_unit_is_sampled() const {
    return std::any_of(controllers.begin(), controllers.end(),
                       [](SampledController const& one) { return std::holds_alternative<BrakeUnit>(one.controller); });
  }

  /// Whether there are cylinders to be filled.
  bool braked() const {
    bool const any =
        std::any_of(axles.begin(), axles.end(), [](AxleParts const& axle) { return axle.brake != absent; });
    return any || actuators.by_traction_motors;
  }

  static constexpr auto fields() {
    using P = MechatronicSetup;
    return members(
        Member{"step", &P::step, "s", "sampling step: all samples and changes of commands lie on its multiples",
               positive},
        Member{"speed", &P::speed, "m/s", "speed at the start"},
        Member{"stop_speed", &P::stop_speed, "m/s",
               "speed below which a train has stopped; 0: it starts from rest and runs on"},
        Member{"axles", &P::axles}, Member{"actuators", &P::actuators}, Member{"sensors", &P::sensors},
        Member{"controllers", &P::controllers}, Member{"protection", &P::protection}, Member{"frame", &P::frame},
        Member{"rail_cell", &P::rail_cell, "m", "length of the cells of rail in which dissipated energy is kept",
               positive},
        Member{"energy_width", &P::energy_width, "m",
               "width of rail over which dissipated energy is spread; 0: that of the patches", not_negative},
        Member{"wheel_memory", &P::wheel_memory, "m",
               "rolling distance over which a wheel's own cleaning fades; 0: it keeps nothing", not_negative},
        Member{"sanding", &P::sanding}, Member{"simulated", &P::simulated}, Member{"rail", &P::rail},
        Member{"brake_delay", &P::brake_delay, "s", "delay of the demand at each axle, (N3); empty: none",
               not_negative},
        Member{"reservoir", &P::reservoir}, Member{"relay_valve", &P::relay_valve});
  }
};

struct Model;

/// Throws std::invalid_argument where a setup names what the model does not have, or has not what a controller needs.
void check_setup(MechatronicSetup const& setup, Model const& model);

/// Throws std::invalid_argument: lists of the wrong length for so many axles under test, a sample time or delay out of its range.
void check_controller(SampledController const& sampled, std::size_t axles);

}  // namespace rollerrig
