// mechatronics/brakes.hpp - disc and tread brakes, traction motors that brake, and brakes that act on the rail.
//
//   cylinder pressure over the ambient -> clamping force -> friction of pads or blocks -> torque against the axle's turning
//   torque asked of an axle -> [share, characteristic, lag, slide protection] -> torque of the motor -> [after a delay] -> the rest,
//   as cylinder pressure, for pneumatics.hpp
//
//     a' = (min(s D, r F(v)) - a)/T,   C_e = k min(a, r F(v)),   p = p(D - C_e(t - t_b))        (A18)
//
// D is the torque of the friction brake under the full demand at the axle's speed, k the factor that slide protection or
// wheel-slip control leaves. The machine never drives: its torque is against the turning, and within the characteristic whatever
// its lag remembers.
//
// To add a characteristic or a law: a struct here, its line in AnyElectrodynamicBrake or AnyTrackBrake, its table in
// python/rollerrig/config/schema/brakes.py. Source  ours; docs/theory/adhesion.md.
#pragma once
#include <algorithm>
#include <cmath>
#include <variant>

#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/fields.hpp"
#include "rollerrig/math/curves.hpp"
#include "rollerrig/mechatronics/pneumatics.hpp"

namespace rollerrig {

struct FrictionBrake {
  double piston_area{}, spring_force{};
  PiecewiseLinear friction{};
  double friction_radius{}, faces{}, friction_regularisation_speed{};

  static constexpr auto fields() {
    using P = FrictionBrake;
    return members(
        Member{"piston_area", &P::piston_area, "m^2",
               "piston area of an axle, times ratio and efficiency of the rigging", not_negative},
        Member{"spring_force", &P::spring_force, "N", "force of the retracting spring, at the pads"},
        Member{"friction", &P::friction, "1",
               "friction of pad on disc or block on tread, over sliding speed at the friction radius [m/s]"},
        Member{"friction_radius", &P::friction_radius, "m",
               "effective radius of the disc; of a tread brake the wheel radius", not_negative},
        Member{"faces", &P::faces, "1", "number of friction faces of an axle that the force presses on", not_negative},
        Member{"friction_regularisation_speed", &P::friction_regularisation_speed, "m/s",
               "sliding speed below which friction turns into viscous drag", positive});
  }

  /// Torque on the axle [N m], against its turning.
  template <Scalar T>
  T torque(T const& cylinder, T const& axle_speed) const {
    T const speed = rubbing_speed(axle_speed);
    return -(sliding_torque(cylinder, axle_speed) * (friction_radius * axle_speed / speed));
  }

  /// The same of pads that slide in full, whichever way: its magnitude, also of an axle at rest [N m].
  template <Scalar T>
  T sliding_torque(T const& cylinder, T const& axle_speed) const {
    T const pressed = piston_area * cylinder - spring_force;
    T const force = select(pressed > 0.0, pressed, T(0.0));
    return faces * friction_radius * friction.at(rubbing_speed(axle_speed)) * force;
  }

  /// Cylinder pressure over the ambient at which sliding_torque() is this [Pa]; of no torque that at which the pads touch.
  double pressure(double torque, double axle_speed) const {
    double const per_force = faces * friction_radius * friction.at(rubbing_speed(axle_speed));
    return per_force > 0.0 && piston_area > 0.0 ? (torque / per_force + spring_force) / piston_area : 0.0;
  }

 private:
  /// At the friction radius, never zero [m/s].
  template <Scalar T>
  T rubbing_speed(T const& axle_speed) const {
    using std::sqrt;
    T const sliding = friction_radius * axle_speed;
    return sqrt(sliding * sliding + friction_regularisation_speed * friction_regularisation_speed);
  }
};

/// The characteristic of a traction motor that brakes, from four numbers.
///
///     F(v) = min(F_max, P/v) f(v),   f = 0 up to v_0, then a straight line to 1 at v_1        (A17)
///
/// Constant force at low speed, constant power beyond P/F_max, and the fading of a machine that no longer feeds back.
struct ConstantPowerBrake {
  static constexpr char const* name = "constant_power";

  double largest_force{}, largest_power{}, fade_from{}, fade_to{};

  static constexpr auto fields() {
    using P = ConstantPowerBrake;
    return members(Member{"largest_force", &P::largest_force, "N",
                          "largest force of one axle at the wheels' circumference, F_max", not_negative},
                   Member{"largest_power", &P::largest_power, "W", "largest power of one axle, P", not_negative},
                   Member{"fade_from", &P::fade_from, "m/s", "speed below which the force fades, v_1", positive},
                   Member{"fade_to", &P::fade_to, "m/s", "speed from which down there is no force, v_0", not_negative});
  }

  /// Largest force [N] at a speed of the wheels' circumference, not negative [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    T const fast = select(largest_force * speed > largest_power, speed, T(1.0));
    T const full = select(largest_force * speed > largest_power, largest_power / fast, T(largest_force));
    T const part = (speed - fade_to) / (fade_from - fade_to);
    return full * select(part < 0.0, T(0.0), select(part < 1.0, part, T(1.0)));
  }
};

/// The characteristic of a traction motor that brakes, as points of a diagram.
struct ForceTableBrake {
  static constexpr char const* name = "table";

  TimeTable forces{};

  static constexpr auto fields() {
    return members(Member{"forces", &ForceTableBrake::forces, "N",
                          "largest force of one axle over the speed of the wheels' circumference [m/s]"});
  }

  /// Largest force [N] at a speed of the wheels' circumference, not negative [m/s]; constant beyond the ends of the table.
  template <Scalar T>
  T force(T const& speed) const {
    return forces.at(speed);
  }
};

using AnyElectrodynamicBrake = OneOf<ConstantPowerBrake, ForceTableBrake>;

/// What the machine of an axle does while slide protection vents the axle's cylinder, or where wheel-slip control acts on it.
enum class OnSlide : int {
  keep,        ///< nothing: the air alone gives way
  reduce,      ///< its torque goes and comes back; the friction brake does not fill what is missing
  switch_off,  ///< its torque goes until the brake is released; the friction brake takes over
  control  ///< what wheel-slip control admits, whatever the valve does; the friction brake does not fill what is missing
};

struct ElectrodynamicBrake {
  AnyElectrodynamicBrake characteristic{};
  double wheel_radius{}, share{}, time_constant{}, blending_delay{};
  int on_slide{};  ///< OnSlide
  double reduction_rate{}, restoring_rate{};

  static constexpr auto fields() {
    using P = ElectrodynamicBrake;
    return members(
        Member{"characteristic", &P::characteristic},
        Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheels, r", positive},
        Member{"share", &P::share, "1", "largest share of the axle's torque demand, s", fraction},
        Member{"time_constant", &P::time_constant, "s", "time constant of the torque, T", positive},
        Member{"blending_delay", &P::blending_delay, "s",
               "delay from the machine's torque to the pneumatic demand that takes it into account, t_b", not_negative},
        Member{"on_slide", &P::on_slide, Range{0.0, 3.0, "0 to 3"}},
        Member{"reduction_rate", &P::reduction_rate, "1/s",
               "reduction rate of the factor k while the cylinder is vented", not_negative},
        Member{"restoring_rate", &P::restoring_rate, "1/s",
               "restoring rate of the factor k while the cylinder is filled", not_negative});
  }

  /// Largest torque [N m], not negative, at an axle speed [rad/s].
  template <Scalar T>
  T largest(T const& axle_speed) const {
    T const speed = wheel_radius * select(axle_speed < 0.0, -axle_speed, axle_speed);
    return wheel_radius * std::visit([&](auto const& law) { return law.force(speed); }, characteristic);
  }

  /// Of one axle.
  struct State {
    double able{};       ///< a: what the machine has come to [N m]
    double factor{1.0};  ///< k
    bool off{false};     ///< until the brake is released
    double torque{};     ///< on the axle, against its turning [N m]
    double counted{};    ///< what the friction brake need not give [N m]
    void state(auto& archive) { archive(able, factor, off, torque, counted); }
  };

  /// @param asked     D [N m], not negative
  /// @param admitted  by wheel-slip control, 0 to 1
  void step(State& s, double asked, double axle_speed, DumpValve valve, double admitted, double h) const {
    double const most = largest(axle_speed);
    double const wanted = std::fmin(share * asked, most);
    s.able = wanted + (s.able - wanted) * std::exp(-h / time_constant);
    if (reaction() == OnSlide::control)
      s.factor = admitted;
    else
      give_way(s, asked, valve, h);
    double const within = std::fmin(s.able, most), given = s.factor * within;
    s.torque = axle_speed < 0.0 ? given : -given;
    s.counted = reaction() == OnSlide::reduce || reaction() == OnSlide::control ? within : given;
  }

  OnSlide reaction() const { return static_cast<OnSlide>(on_slide); }

 private:
  void give_way(State& s, double asked, DumpValve valve, double h) const {
    if (reaction() == OnSlide::keep) return;
    bool const vents = valve == DumpValve::vent;
    bool const stays_off = reaction() == OnSlide::switch_off && asked > 0.0;
    s.off = stays_off && (s.off || vents);
    if (vents || s.off) s.factor = std::fmax(0.0, s.factor - reduction_rate * h);
    if (valve == DumpValve::fill && !s.off) s.factor = std::fmin(1.0, s.factor + restoring_rate * h);
  }
};

// Brakes that act on the rail, not on a wheel:
//
//   demand, speed of the train -> [delay, straight rise] -> excitation, 0 to 1 -> force on each bogie, against running
//
// On track the force acts on what carries the magnets, in the line of its centre; on a rig there is no rail beside the rollers: it
// acts on the virtual train alone, by the same law.

/// Magnets that are lowered to the rail and rub on it.
///
///     F(v) = N mu(|v|) v/sqrt(v^2 + v_r^2)        (A20)
///
/// The attraction N stands between magnet and rail: it loads no wheel and unloads none. mu falls with speed as the law says that
/// the case names; what lies on the rail, and what rubbing magnets clean of it, is not part of it.
struct MagneticTrackBrake {
  static constexpr char const* name = "magnetic";

  double attraction{};
  FrictionLaw friction{};  ///< mu of pole shoes on the rail, over speed
  double regularisation_speed{};

  static constexpr auto fields() {
    using P = MagneticTrackBrake;
    return members(
        Member{"attraction", &P::attraction, "N", "attraction of all magnets of a bogie together, N", not_negative},
        Member{"friction", &P::friction},
        Member{"regularisation_speed", &P::regularisation_speed, "m/s",
               "speed below which friction turns into viscous drag, v_r", positive});
  }

  /// Against running [N], at a speed over the rail [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    using std::sqrt;
    T const fast = select(speed < 0.0, -speed, speed);
    return attraction * friction_at(friction, fast) * speed /
           sqrt(speed * speed + regularisation_speed * regularisation_speed);
  }
};

/// Magnets over the rail that do not touch it: eddy currents in the rail brake.
///
///     F(v) = 2 F_k / (v/v_k + v_k/v)        (A21)
///
/// Source  J.H. Wouterse, Critical torque and speed of eddy current brake with widely separated soft iron poles, IEE Proc. B 138
///         (1991): the curve over a critical speed. Its numbers for rails are the case's.
struct EddyCurrentTrackBrake {
  static constexpr char const* name = "eddy_current";

  double largest_force{}, critical_speed{};

  static constexpr auto fields() {
    using P = EddyCurrentTrackBrake;
    return members(Member{"largest_force", &P::largest_force, "N",
                          "largest force of all magnets of a bogie together, F_k", not_negative},
                   Member{"critical_speed", &P::critical_speed, "m/s",
                          "speed at which the largest force is reached, v_k", positive});
  }

  /// Against running [N], at a speed over the rail [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    return 2.0 * largest_force * critical_speed * speed / (speed * speed + critical_speed * critical_speed);
  }
};

using AnyTrackBrake = OneOf<MagneticTrackBrake, EddyCurrentTrackBrake>;

struct TrackBrake {
  AnyTrackBrake law{};  ///< of one bogie
  double bogies{};
  TimeTable demand{};
  double delay{}, rise_time{}, release_speed{};

  static constexpr auto fields() {
    using P = TrackBrake;
    return members(Member{"law", &P::law},
                   Member{"bogies", &P::bogies, "1", "number of bogies under test that have it", not_negative},
                   Member{"demand", &P::demand, "1", "demanded excitation, 0 to 1", fraction},
                   Member{"delay", &P::delay, "s", "delay from the demand to the first force: lowering", not_negative},
                   Member{"rise_time", &P::rise_time, "s", "rise time of the excitation, from none to full", positive},
                   Member{"release_speed", &P::release_speed, "m/s", "train speed below which the magnets are lifted",
                          not_negative});
  }

  /// Of one bogie in full excitation, against running [N], at a speed over the rail [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    return std::visit([&](auto const& one) { return one.force(speed); }, law);
  }

  double next(double excitation, double t, double train_speed, double h) const {
    double const wanted = train_speed < release_speed ? 0.0 : demand.at(t - delay);
    return std::clamp(wanted, excitation - h / rise_time, excitation + h / rise_time);
  }
};

}  // namespace rollerrig
