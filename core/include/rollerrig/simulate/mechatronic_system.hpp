// simulate/mechatronic_system.hpp - sensors, controllers, actuators and the train's motion around the plant, step by step.
//
//   plant at t_k -> sensors -> controllers that are due -> commands, after their delay -> brake unit, if it is asked as they are
//                -> motors and brakes -> inputs on straight lines over one step -> plant at t_k+1
//
// A controller marked `external` is asked for by the caller: sample() returns false at its instant, the caller reads
// measurement(), sets the command and continues.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "rollerrig/contact/adhesion/rail_memory.hpp"
#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/simulate/actuator_states.hpp"
#include "rollerrig/simulate/recorder.hpp"
#include "rollerrig/simulate/sensor_readings.hpp"
#include "rollerrig/simulate/train_motion.hpp"

namespace rollerrig {

class MechatronicSystem {
 public:
  /// Columns of record(), per axle and for the train.
  static std::span<Field const> axle_fields();
  static std::span<Field const> train_fields();

  /// Throws std::invalid_argument for more than `most_axles` axles, or a controller without a sample time.
  explicit MechatronicSystem(MechatronicSetup setup);

  /// The plant before the first step; to be called before it is evaluated.
  void prepare(Model const& model, Inputs& inputs) const;
  /// Takes the plant's state at time 0.
  void start(Dynamics const& plant);
  /// Reads the sensors and asks every controller that is due; false where the caller must answer first.
  ///
  /// @param z  the plant's quadratures, for the angles
  bool sample(Dynamics const& plant, std::int64_t step, double const* z);
  /// Asks the brake unit, where it stands for a controller: after all controllers have been answered for.
  void ask_machines(std::int64_t step);
  /// Sets the inputs over the step that begins.
  void act(Dynamics const& plant, std::int64_t step, Inputs& inputs);
  /// After a step: the train's motion, and whether the run ends here.
  Status advance(Dynamics const& plant, std::int64_t step);

  MechatronicSetup const& setup() const { return setup_; }
  int width() const;
  /// One row of the train's and all axles' columns, in the plant's last evaluation.
  void record(Dynamics const& plant, std::int64_t step, double const* z, Inputs const& inputs, double* row) const;

  /// Whether the caller must answer for some controller, or for that of this name.
  bool has_pending() const;
  bool waits_for(std::string_view controller) const;
  /// What a controller sees, axle by axle: measurement_fields.
  std::vector<double> measurement(std::string_view controller) const;
  /// Numbers of measurement(), for a caller with room of his own; the controller's place in the setup.
  int measurement_width(std::size_t controller) const;
  void measure(std::size_t controller, double* row) const;
  /// The same controllers with other numbers, from their next samples on; no list in them may be of another length.
  void set_controllers(std::vector<SampledController> const& controllers);
  /// What a caller asks for; it may change at every instant.
  CallerDemands& caller() { return caller_; }
  /// Whoever waits does so no longer, and keeps his last command.
  void cancel_pending();
  /// Answers for every external controller, waiting or not, with the caller's present commands.
  void answer(std::int64_t step);
  /// Answers for an external controller; throws std::invalid_argument where there is none of that name.
  void set_command(std::string_view controller, std::span<double const> command, std::int64_t step);

  void state(auto& archive) {
    archive(measured_, sensors_, actuators_, train_, simulated_, impulse_of_simulated_);
    for (Controller& own : controllers_) {
      archive(own.state, own.commands, own.pending);
      own.commands.each([&](PerAxle<double> const& values) { archive.need(field_of(own.command).allows(values)); });
    }
    archive(caller_, speed_control_, acting_, rail_, wheel_, slides_for_, sanding_, sand_, sanded_, sand_used_,
            track_brake_power_, track_brake_energy_);
    for (CommandField const& field : command_fields)
      archive.need(field.allows(caller_.commands.*field.of) && field.allows(acting_.*field.of));
    archive.need(field_of(Command::dump_valve).allows(measured_.dump_valve));
  }

 private:
  struct Controller {
    std::string_view name;
    Command command;
    StateOf<AnyController> state;
    DelayedCommands commands;
    bool pending{false};
  };

  std::size_t axles() const { return setup_.axles.size(); }
  std::size_t under_test() const { return setup_.under_test(); }
  bool frame_moves() const { return setup_.frame.train_mass > 0.0; }
  double time(std::int64_t step) const { return setup_.step * static_cast<double>(step); }
  double train_speed(Dynamics const& plant) const;
  std::optional<double> reference_speed() const;
  RigController const* rig() const {
    return rig_ ? std::get_if<RigController>(&setup_.controllers[*rig_].controller) : nullptr;
  }
  RigController::State const* rig_state() const {
    return rig_ ? std::get_if<RigController::State>(&controllers_[*rig_].state) : nullptr;
  }
  RigController::State* rig_state() {
    return rig_ ? std::get_if<RigController::State>(&controllers_[*rig_].state) : nullptr;
  }
  double axle_speed(Dynamics const& plant, std::size_t axle) const;
  TrainStep train_step(std::int64_t step) const;
  void step_simulated(std::int64_t step);
  void sample_brake_demand(std::int64_t step);
  void ask(std::size_t index, std::int64_t step);
  PerAxle<double> answer_of(std::size_t index);
  void read_true_forces(Dynamics const& plant);
  void dissipate(Dynamics const& plant, Inputs& inputs);
  void deposit_sand(Dynamics const& plant, Inputs& inputs);
  void switch_sand(Dynamics const& plant, std::int64_t step);
  bool axle_is_sliding(std::size_t axle) const;
  double train_distance() const;
  double track_brake_force(Dynamics const& plant) const;
  bool slip_limit_exceeded(Dynamics const& plant);
  void record_axle(Dynamics const& plant, std::size_t axle, Inputs const& inputs, double* row) const;
  void record_simulated(std::size_t axle, double* row) const;

  MechatronicSetup setup_;
  Measurements measured_;
  SensorReadings sensors_;
  ActuatorStates actuators_;
  TrainMotion train_;
  SimulatedAxleStates simulated_;
  double impulse_of_simulated_{0.0};  ///< since the last sample of the rig's controller [N s]
  std::vector<Controller> controllers_;
  std::optional<std::size_t> rig_{}, brake_unit_{};  ///< of controllers_
  CallerDemands caller_{};
  PerAxle<StateOf<AnyFeedback>> speed_control_{};  ///< of the drives that the caller asks for a speed
  AxleCommands acting_{};
  std::array<RailCells, 2> rail_;                 ///< left, right
  std::array<PerAxle<CleanedWheel>, 2> wheel_{};  ///< left, right
  PerAxle<double> slides_for_{};                  ///< wheel on roller, beyond the protection's limit [s]
  SandingSwitch sanding_;
  DelayedCommands sand_;                                     ///< flow in front of each axle [kg/s]
  SandedRail sanded_;                                        ///< both rails alike
  double sand_used_{0.0};                                    ///< [kg]
  double track_brake_power_{0.0}, track_brake_energy_{0.0};  ///< [W], [J]
  int shortest_{0};                                          ///< sample time of the controllers, in steps; 0: none
};

}  // namespace rollerrig
