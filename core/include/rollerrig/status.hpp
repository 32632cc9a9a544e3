// status.hpp - what a computation of the core may end with, and the sentence a user reads.
//
// The hot loop never throws: each function that can fail returns a Status, and the first that is not
// ok is passed up unchanged.
#pragma once
#include <string_view>

namespace rollerrig {

enum class Status : int {
  ok = 0,
  not_finite,         ///< a state, force or error estimate is infinite or not a number
  contact_lost,       ///< a wheel carries no load where the model needs a contact
  off_profile,        ///< a contact point left the range of a wheel, rail or roller profile
  derailed,           ///< a wheelset climbed over the flange or fell between the rails
  step_too_small,     ///< the error tolerance asks for a step below the resolution of time
  too_many_steps,     ///< the step budget of the run is exhausted
  interrupted,        ///< the caller asked to stop
  stopped,            ///< the train has come to a stop: the end of a brake test
  rollers_protected,  ///< a wheel slid on its roller for too long
  controller_failed,  ///< a controller of the caller gave no usable command
};

/// A sentence with the remedy, ready to be shown with time and wheel put in front.
constexpr std::string_view status_sentence(Status status) {
  switch (status) {
    case Status::ok: return "The computation ended as asked.";
    case Status::not_finite:
      return "A state or force became infinite or not a number; reduce the step or the tolerance, "
             "and look for extreme values in the inputs.";
    case Status::contact_lost:
      return "A wheel lost contact; reduce the speed, the torque or the disturbance, or raise the "
             "load on that wheel.";
    case Status::off_profile:
      return "A contact point came to the end of its profile; check gauge, back-to-back distance, the starting "
             "position and the speed, or give a profile that reaches further if its points end there.";
    case Status::derailed:
      return "A wheelset derailed; the results up to this time are valid, reduce the speed or the "
             "disturbance to go on.";
    case Status::step_too_small:
      return "The error tolerance cannot be met with any step; relax the tolerances, or smooth a jump "
             "in the inputs or declare it as a breakpoint.";
    case Status::too_many_steps:
      return "The step budget is exhausted; raise the largest number of steps, relax the tolerances, or "
             "choose the stiff method rodas4.";
    case Status::stopped: return "The computation ended as asked. The train has stopped.";
    case Status::rollers_protected:
      return "The protection of the rollers ended the test: a wheel slid on its roller; less torque or more friction "
             "between "
             "wheel and roller, or raise the limit rig_control.protection.slip.";
    case Status::controller_failed:
      return "A controller gave no usable command; the results up to this time are valid.";
    case Status::interrupted: return "The computation was interrupted; the results up to this time are valid.";
  }
  return "Unknown status; this is a programming error, please report it.";
}

}  // namespace rollerrig
