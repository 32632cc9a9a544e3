// simulate/sampled_run.hpp - machines and controllers around the plant: who is sampled when, and what acts until the next time.
//
//   plant at t_k -> sensors -> controllers that are due -> commands, after their delay -> motors and brakes
//                -> inputs on straight lines over one step -> plant at t_k+1
//
// The plant integrates continuously; every sample and every change of a command stands on the bench's own grid of steps, of
// which all sample times and delays are multiples. A controller marked `external` is asked for by the caller: advance()
// comes back at its instant, the caller reads measurement(), sets the command and goes on.
//
// On track the frames travel with the train: V(t) is a straight line over each step, its slope from the forces at the step's
// start, extrapolated by half a step. Any V(t) describes the same physics; this one keeps the bodies in their places.
#pragma once
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "rollerrig/contact/adhesion/recovered_rail.hpp"
#include "rollerrig/integrate/exponential_runge_kutta_4.hpp"
#include "rollerrig/mechatronics/contact_force_estimator.hpp"
#include "rollerrig/mechatronics/motor.hpp"
#include "rollerrig/mechatronics/rig_controller.hpp"
#include "rollerrig/mechatronics/sensor.hpp"
#include "rollerrig/mechatronics/virtual_rail.hpp"
#include "rollerrig/mechatronics/virtual_train.hpp"
#include "rollerrig/mechatronics/wheel_slide_protection.hpp"
#include "rollerrig/mechatronics/wheel_slip_control.hpp"
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

constexpr int most_axles = 8;

/// When a controller is asked, and how long its answer takes.
struct Sampling {
  int every{1};          ///< sample time in steps of the bench; 0: the controller is not there
  int delay{0};          ///< steps from the sample to the command's acting
  bool external{false};  ///< the caller computes the command
};

/// One axle of the vehicle, and on a rig its rollers. -1: not there.
struct BenchAxle {
  int wheelset{0};      ///< body
  int axle_torque{-1};  ///< of the model: the traction motor
  int brake{-1};        ///< of the model
  int roller{-1};       ///< body
  int roller_torque{-1};
  std::array<int, 2> contact{-1, -1};
};

/// A column of what the bench records beside the plant.
struct BenchColumn {
  std::string_view name, unit, meaning;
};

/// Everything the bench is made of; constant during a run.
struct BenchSetup {
  double step{1e-3};   ///< [s]
  double duration{0};  ///< [s]
  std::vector<BenchAxle> axles;
  double speed{0.0};        ///< at the start [m/s]
  double floor_speed{0.5};  ///< a train slower than this has stopped: the run ends [m/s]

  TimeTable brake_demand{};     ///< cylinder pressure over the ambient [Pa]
  PneumaticBrake brake{};       ///< the same on each axle
  bool motor_brakes{false};     ///< the traction motors stand in for the brake: its torque becomes their command
  TimeTable traction_demand{};  ///< torque per axle, positive forward [N m]
  Motor motor{};                ///< of each axle

  Sampling slide_sampling{0, 0, false};
  WheelSlideProtection slide{};
  Sampling wheel_slip_sampling{0, 0, false};
  WheelSlipControl wheel_slip_control{};
  Encoder axle_encoder{}, roller_encoder{};
  bool has_torque_sensor{false};  ///< on the rollers' drive shafts; without it the torque is known
  ForceSensor torque_sensor{};
  ForceSensor load_sensor{};  ///< vertical force of both wheels of an axle
  std::uint64_t seed{0};

  Sampling rig_sampling{0, 0, false};  ///< the controller of the rollers; every = 0: none
  bool reproduce{false};               ///< our own rig controller reproduces the virtual train
  VirtualTrain train{};
  VirtualRail rail{};
  std::array<double, most_axles> place{};  ///< of the axles along the train [m]
  ContactForceEstimator estimator{};
  bool commanded_torque{false};  ///< the estimator takes the command for the torque that acts
  bool measured_loads{false};    ///< the virtual train's axles carry what is measured
  RigFeedback feedback{};
  Motor roller_motor{};
  double slip_limit{1.0};  ///< protection: real sliding between wheel and roller [m/s] ...
  double slip_time{0.2};   ///< ... for longer than this [s] ends the test

  double travelling_mass{0.0};  ///< on track: of the train that these axles brake [kg]; 0: on a rig
  double held_mass{0.0};        ///< of it, what is held in the frame [kg]
  double rail_cell{0.05};       ///< dissipated energy is kept along the rail in cells of this length [m]
  bool pure_rolling{false};     ///< on rollers: system/rolling_constraint.hpp
};

class TestBench {
 public:
  enum class Role : int { slide_protection, wheel_slip_control, rig };
  static constexpr int roles = 3;

  /// Columns of fill_row(), per axle and for the train.
  static std::span<BenchColumn const> axle_columns();
  static std::span<BenchColumn const> train_columns();

  TestBench(Dynamics& dynamics, BenchSetup const& setup);

  Status start(double const* x0);

  /// Runs to time t_stop, or to where an external controller is due or the test ends.
  ///
  /// @param observer  observer(t, x, z): called at every `output_every`-th step
  template <class Observer>
  Status advance(double t_stop, int output_every, Observer&& observer) {
    while (status_ == Status::ok && !ended_ && step_count_ < last_step(t_stop)) {
      if (!sampled_ && !sample()) return Status::ok;  // an external controller is asked for
      if (output_every > 0 && step_count_ % output_every == 0)
        observer(time(), y_.data(), y_.data() + dynamics_->sizes().states);
      step();
    }
    bool const over = ended_ || step_count_ == last_step(setup_.duration);
    if (status_ == Status::ok && over && output_every > 0 && step_count_ % output_every == 0)
      observer(time(), y_.data(), y_.data() + dynamics_->sizes().states);
    return status_;
  }

  double time() const { return setup_.step * static_cast<double>(step_count_); }
  bool ended() const { return ended_; }  ///< the train stands, or the protection acted
  bool protected_rollers() const { return protection_acted_; }
  bool due(Role role) const { return due_[static_cast<std::size_t>(role)]; }
  /// What a controller sees, per axle: the axle's speed and the roller's [rad/s], the roller's torque [N m], estimated
  /// contact force [N] and axle torque [N m], speed of the virtual axle [rad/s], feed-forward (D5) [N m], load [N].
  std::vector<double> measurement(Role role) const;
  /// Valve states 0 fill, 1 hold, 2 vent; torque factors; roller torques [N m]: one per axle.
  void set_command(Role role, double const* command);
  void fill_row(double* axles, double* train) const;
  Inputs const& inputs() const { return inputs_; }
  int failed_contact() const { return dynamics_->failed_contact(); }
  integrate::Statistics const& statistics() const { return plant_.statistics; }

 private:
  struct Axle {
    double torque_state[2]{};                    // traction motor
    double cylinder_state[2]{};                  // control valve, cylinder
    double roller_state[2]{};                    // roller motor
    double air{0.0};                             // taken by the cylinder [m^3]
    double wheel_speed{0.0}, roller_speed{0.0};  // measured [rad/s]
    double roller_torque{0.0};                   // mean since the last sample, as the estimator sees it [N m]
    double torque_now{0.0}, torque_sum{0.0};     // of the drive, at this step; its means over the steps since
    int torque_steps{0};
    double measured_torque{0.0}, measured_load{0.0};  // as the sensors say
    double sampled_torque{0.0};                       // measured at the last sample of the rig's controller
    ForceReading torque_reading, load_reading;
    double stand_in{0.0};        // brake torque that the motor stands in for [N m]
    double energy_density{0.0};  // energy per area on the piece of rail under the axle now [J/m^2]
    double virtual_energy{0.0};
    double slip_for{0.0};  // [s]
    double feed_forward{0.0}, wanted_torque{0.0}, command{0.0};
    int dump_cycles{0};
    EncoderReading encoder, roller_encoder;
    ContactForceEstimate estimate;
    RigFeedbackState feedback;
  };
  /// Commands of one role on their way.
  struct Pending {
    std::vector<std::array<double, most_axles>> value;  ///< ring
    std::vector<long> acts_at;
    std::array<double, most_axles> now{};
    std::size_t first{0}, count{0};
  };

  long last_step(double t_stop) const;
  bool sample();
  void run_controller(Role role);
  void control_rig();
  void reset_sensors();
  void read_sensors(double period);
  double drive_torque(Axle& axle) const;
  double load(int axle) const;
  double acting_torque(int axle) const;
  double acting_force(int axle) const;
  void post(Role role, double const* command);
  void take_commands();
  void step();
  void move_machines();
  void move_train();
  void dissipate_energy();
  void protect();
  Sampling const& sampling(Role role) const;

  Dynamics* dynamics_;
  BenchSetup setup_;
  Inputs inputs_;
  DrivenDynamics driven_;
  integrate::Evaluator<DrivenDynamics> plant_;
  integrate::ExponentialRungeKutta4 method_;
  integrate::Vector y_, y_new_;
  std::vector<Axle> axle_;
  std::array<Pending, roles> pending_;
  std::array<bool, roles> due_{};
  WheelSlideProtectionState slide_;
  WheelSlipControlState wheel_slip_control_;
  VirtualTrainState train_;
  std::array<RecoveredRail, 2> rail_;  ///< left, right, under the 3-D wheels
  RecoveredRail virtual_rail_;
  double speed_{0.0}, distance_{0.0}, acceleration_{0.0}, last_acceleration_{0.0};
  long step_count_{0};
  Status status_{Status::ok};
  bool sampled_{false}, ended_{false}, protection_acted_{false};
};

}  // namespace rollerrig
