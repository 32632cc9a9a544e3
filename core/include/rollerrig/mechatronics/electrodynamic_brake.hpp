// mechatronics/electrodynamic_brake.hpp - traction motors that brake, and what they leave to the friction brake of their axle.
//
//   torque asked of an axle -> [share, characteristic, lag, slide protection] -> torque of the motor -> [after a delay] -> the rest,
//   as cylinder pressure, for pneumatics.hpp
//
//     a' = (min(s D, r F(v)) - a)/T,   C_e = k min(a, r F(v)),   p = p(D - C_e(t - t_b))        (A18)
//
// D is the torque of the friction brake under the full demand at the axle's speed, k the factor that slide protection or
// wheel-slip control leaves. The machine never drives: its torque is against the turning, and within the characteristic whatever
// its lag remembers.
//
// To add a characteristic: a struct here, its line in AnyElectrodynamicBrake, its table in
// python/rollerrig/config/schema/brakes.py. Source  ours; docs/theory/adhesion.md.
#pragma once
#include <cmath>
#include <variant>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/piecewise_linear.hpp"
#include "rollerrig/mechatronics/dump_valve.hpp"

namespace rollerrig {

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

  /// One step.
  ///
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
    s.off = (s.off && stays_off) || (vents && stays_off);
    if (vents || s.off) s.factor = std::fmax(0.0, s.factor - reduction_rate * h);
    if (valve == DumpValve::fill && !s.off) s.factor = std::fmin(1.0, s.factor + restoring_rate * h);
  }
};

}  // namespace rollerrig
