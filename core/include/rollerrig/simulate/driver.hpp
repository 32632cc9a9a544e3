// simulate/driver.hpp - marches a model through time: any integrator, and between its steps sampled sensors, controllers and
// actuators, if there are any.
//
//   Model, state, Options -> [integrator]                                              -> outputs, Status
//                            [sample -> act -> integrator up to the next instant] ...  -> the same, with sampled blocks
//
// With sampled blocks the run consists of whole sampling steps; outputs stand on them. At each instant the sensors are read and
// the controllers asked, then the output is shown, then the inputs of the plant are set for the step: they are straight lines
// that join. A method of fixed step therefore keeps the slope at the instant that it found before; what does jump, V' of the
// travelling frame and the dissipated energy, shifts a velocity by less than step / 2 times the jump, docs/theory/rig_control.md
// (D8). An adaptive method evaluates it anew.
#pragma once
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "rollerrig/integrate/differential_equation.hpp"
#include "rollerrig/integrate/options.hpp"
#include "rollerrig/simulate/mechatronic_system.hpp"
#include "rollerrig/simulate/recorder.hpp"
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

namespace integrate {
template <DifferentialEquation System>
class Integrator;
}

/// Who sees the outputs of a run.
using Observer = std::function<void(double t, double const* x, double const* z)>;

/// Every number of the settings, and every length of a step that a run may be cut into against its duration: throws
/// std::invalid_argument for a run that would not end.
void check_settings(integrate::Options const& options, int states, double t0, double sampling_step);

class Driver {
 public:
  Driver(Driver const&) = delete;
  Driver& operator=(Driver const&) = delete;
  /// Throws std::invalid_argument for a setup that cannot be run.
  Driver(std::shared_ptr<Model const> model, std::optional<MechatronicSetup> setup);
  ~Driver();

  /// Begins a run; throws std::invalid_argument for impossible options, and for an end that the steps would never reach.
  Status start(integrate::Options options, double t0, double const* x0);

  /// Runs to time t_stop, to where an external controller waits, or to the end; shows the observer each output time.
  Status advance(double t_stop, Observer const& observer);

  /// Reads the sensors and asks the controllers at this instant, as advance() would before its next step.
  void sample_now();
  /// Where another program integrates: at each instant of sampling, in the states it found, what happens between two steps of a
  /// run. The inputs then hold to the next.
  Status pass_sample(double const* x, double const* z);
  /// Its two halves: up to where the instant may be recorded, and what acts from then on.
  Status reach_sample(double const* x, double const* z);
  void act_on_sample();
  double next_sample() const;  ///< [s]; infinite: nothing is sampled
  /// From now on advance() answers for external controllers with the caller's commands, where otherwise it returns.
  void answer_for_controllers() { answers_externally_ = true; }

  /// Without sampled blocks: a torque of the model beside its own table [N m], from a time within the last step on. Steps end
  /// where advance() is asked to from then on.
  void hold_torque(bool of_roller, std::size_t index, double value, double from);
  /// Without sampled blocks: from a time within the last step on, the running speed of the model goes on a straight line from what
  /// it is there to another [m/s] in a time [s], and beyond; in no time: it stays there.
  void ramp_speed(double speed, double over, double from);
  /// Friction of a contact over what its law says, from now on; without sampled blocks from a time within the last step on.
  void hold_friction(std::size_t contact, double factor, double from);

  /// One row of width() numbers: the plant's, then those of the sampled blocks.
  void record(double t, double const* x, double const* z, double* row);
  /// Of the plant alone what is read between the output times: reading_width() numbers.
  void record_reading(double t, double const* x, double const* z, double* row);
  int reading_width() const { return recorder_.reading_width(); }
  /// A whole row where the run is, without sampled blocks up to a step before it.
  void record_at(double t, double* row);
  int width() const { return recorder_.width() + (system_ ? system_->width() : 0); }

  bool started() const { return integrator_ != nullptr; }
  double time() const;
  double step_start() const;
  double const* states() const;
  integrate::Statistics const& statistics() const;
  int failed_contact() const { return plant_.failed_contact(); }
  Dynamics& plant() { return plant_; }
  Dynamics const& plant() const { return plant_; }
  Dynamics& observed() { return observed_; }
  Dynamics const& observed() const { return observed_; }
  Inputs const& inputs() const { return inputs_; }                              ///< that act on the plant
  integrate::Integrator<DrivenDynamics>& integrator() { return *integrator_; }  ///< of a run that has begun
  /// Within the last step, step_start() <= t <= time(); x and z as record() takes them.
  void sample_states(double t, double* x, double* z);
  MechatronicSystem* system() { return system_ ? &*system_ : nullptr; }
  MechatronicSystem const* system() const { return system_ ? &*system_ : nullptr; }
  void set_command(std::string_view controller, std::span<double const> command) {
    system_->set_command(controller, command, step_);
  }

  /// Everything that changes in a run, for plant/state_archive.hpp, where the integrator is known; of a run that has begun.
  void state(auto& archive) {
    plant_.list_inputs(archive, inputs_);
    archive(plant_, observed_);
    if (system_) archive(*system_);
    archive(*integrator_, sampled_, brake_unit_sampled_, acted_, held_);
    archive.time(final_time_);
    archive.within(step_, std::int64_t{0}, std::int64_t{1} << 60);
    archive.within(status_, Status::ok, Status::controller_failed);
    archive.need(system_ || held_ || !is_held());  // whoever holds it lets it go on
    bool const exchanged = !system_ || acted_ || status_ != Status::ok;
    archive.need(exchanged || std::fabs(time() - setup_->step * static_cast<double>(step_)) < 0.5 * setup_->step);
  }

 private:
  /// Evaluated at an output: at a sample the run's own, otherwise one of its own, which changes no bit of the run.
  Dynamics& shown(double t, double const* x) {
    return system_ || plant_.evaluated_at(t, x, inputs_) ? plant_ : observed_;
  }
  bool is_held() const;
  std::int64_t steps_until(double t_stop) const;
  void sample();
  void sample_end();
  void advance_step();
  void start_without_slip(double* x);
  bool ended_as_planned() const {
    bool const by_block = status_ == Status::stopped || status_ == Status::rollers_protected;
    return by_block || (status_ == Status::ok && step_ == steps_until(final_time_));
  }
  void show(Observer const& observer) const;

  Dynamics plant_;
  Inputs inputs_;
  DrivenDynamics driven_{plant_, inputs_};
  Dynamics
      observed_;  ///< outputs between the steps' ends are evaluated apart: asking for them changes no bit of the run
  Recorder recorder_;
  std::optional<MechatronicSetup> setup_;
  std::optional<MechatronicSystem> system_;
  std::unique_ptr<integrate::Integrator<DrivenDynamics>> integrator_;
  double final_time_{0.0};
  std::int64_t step_{0};            ///< sampling steps done
  std::int64_t output_every_{1};    ///< in sampling steps
  bool sampled_{false};             ///< at this instant
  bool brake_unit_sampled_{false};  ///< at this instant
  bool answers_externally_{false};  ///< for external controllers
  bool acted_{false};               ///< at this instant, where another program integrates
  bool held_{false};                ///< a torque is
  Status status_{Status::ok};
  std::vector<double> x_, z_;  ///< within a step
};

}  // namespace rollerrig
