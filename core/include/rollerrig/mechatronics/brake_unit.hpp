// mechatronics/brake_unit.hpp - the pneumatic brake as a machine: from demand and dump valve of each axle to its cylinder's pressure.
//
//   pressure asked for, dump valves -> [brake unit: the cylinders of each reservoir together] -> cylinder pressures
//
// As a rule it is a part of the plant, without a sample time: simulate/actuator_states.hpp. As a controller it stands alone, in an
// FMU, or leaves its place to somebody else's.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/mechatronics/pneumatics.hpp"

namespace rollerrig {

/// Cylinders of all axles and the reservoirs that feed them.
class BrakeCylinders {
 public:
  BrakeCylinders() = default;
  /// @param reservoir    number of the reservoir that feeds each axle; empty: one feeds all
  /// @param relay_valve  number of each axle's relay valve; empty: one for each reservoir
  BrakeCylinders(Pneumatics const& pneumatics, std::span<int const> reservoir, std::span<int const> relay_valve,
                 std::size_t axles)
      : axles_{axles} {
    auto const number = [](std::span<int const> of, std::size_t axle) { return of.empty() ? 0 : at(of[axle]); };
    for (std::size_t i = 0; i < axles_; ++i) {
      fed_by_[i] = number(reservoir, i);
      supplies_ = std::max(supplies_, fed_by_[i] + 1);
    }
    supply_.fill(std::visit([](auto const& air) { return air.start(); }, pneumatics.air));
    std::size_t next = 0, relays = 0;
    for (std::size_t k = 0; k < supplies_; ++k) {
      first_[k] = next, first_relay_[k] = relays;
      for (std::size_t r = 0; r < at(most_axles); ++r) {
        std::size_t const before = next;
        for (std::size_t i = 0; i < axles_; ++i)
          if (fed_by_[i] == k && number(relay_valve, i) == r) place_[i] = next++, relay_of_[i] = relays;
        if (next > before) relay_[relays++].cylinders = next - before;
      }
    }
    first_[supplies_] = next, first_relay_[supplies_] = relays;
  }

  Cylinder const& cylinder(std::size_t axle) const { return cylinder_[place_[axle]]; }
  /// The reservoir that feeds an axle's cylinder.
  AirSupply const& supply(std::size_t axle) const { return supply_[fed_by_[axle]]; }
  /// In the pipe between an axle's relay valve and its dump valve [Pa]; 0 where the air has no pipe.
  double pipe_pressure(std::size_t axle) const { return relay_[relay_of_[axle]].pressure; }
  /// Air that all reservoirs have drawn from the main pipe since the start [m^3].
  double drawn() const {
    double sum = 0.0;
    for (std::size_t k = 0; k < supplies_; ++k) sum += supply_[k].drawn;
    return sum;
  }

  /// Over a time h [s]; the cylinders of a reservoir share its air.
  ///
  /// @param valve   command of each axle's dump valve
  /// @param demand  pressure asked of each axle [Pa]
  void step(Pneumatics const& pneumatics, PerAxle<double> const& valve, PerAxle<double> const& demand, double h) {
    PerAxle<DumpValve> command{};
    PerAxle<double> asked{};  // both in the order of the cylinders
    for (std::size_t i = 0; i < axles_; ++i) {
      command[place_[i]] = valve_of(valve[i]);
      asked[place_[i]] = demand[i];
    }
    auto const all = [&](auto const& air) {
      for (std::size_t k = 0; k < supplies_; ++k) {
        std::size_t const from = first_[k], count = first_[k + 1] - from;
        auto const relays = std::span{relay_}.subspan(first_relay_[k], first_relay_[k + 1] - first_relay_[k]);
        air.step(pneumatics.control_valve, std::span{cylinder_}.subspan(from, count), relays, supply_[k],
                 std::span{command}.subspan(from, count), std::span{asked}.subspan(from, count), h);
      }
    };
    std::visit(all, pneumatics.air);
  }

  /// Pressures that a brake unit outside has made [Pa]. What air that takes is known at the cylinder, not in reservoirs.
  void take(ControlValve const& measures, PerAxle<double> const& valve, PerAxle<double> const& pressure) {
    for (std::size_t i = 0; i < axles_; ++i) {
      Cylinder& own = cylinder_[place_[i]];
      double const rise = pressure[i] - own.pressure;
      (rise > 0.0 ? own.air : own.exhausted) += measures.air(std::fabs(rise));
      own.pressure = pressure[i];
      own.move_valves(valve_of(valve[i]) == DumpValve::fill, valve_of(valve[i]) == DumpValve::vent);
    }
  }

  void state(auto& archive) { archive(cylinder_, supply_, relay_); }

 private:
  std::size_t axles_{0}, supplies_{1};
  PerAxle<Cylinder> cylinder_{};                           ///< reservoir by reservoir, relay valve by relay valve
  PerAxle<std::size_t> place_{};                           ///< of each axle's cylinder in that order
  PerAxle<std::size_t> fed_by_{};                          ///< reservoir of each axle
  PerAxle<std::size_t> relay_of_{};                        ///< relay valve of each axle
  PerAxle<AirSupply> supply_{};                            ///< of each reservoir
  PerAxle<RelayValve> relay_{};                            ///< reservoir by reservoir
  std::array<std::size_t, most_axles + 1> first_{};        ///< cylinder of each reservoir, and the end
  std::array<std::size_t, most_axles + 1> first_relay_{};  ///< relay valve of each reservoir, and the end
};

struct BrakeUnit {
  static constexpr char const* name = "brake_unit";
  static constexpr Command command = Command::cylinder_pressure;

  Pneumatics pneumatics{};
  std::vector<int> reservoir{};    ///< number of the reservoir that feeds each axle; empty: one feeds all
  std::vector<int> relay_valve{};  ///< number of each axle's relay valve; empty: one for each reservoir

  static constexpr auto fields() {
    return members(Member{"pneumatics", &BrakeUnit::pneumatics}, Member{"reservoir", &BrakeUnit::reservoir},
                   Member{"relay_valve", &BrakeUnit::relay_valve});
  }

  using State = BrakeCylinders;

  State start(Measurements const& now, double /*train_speed*/, double /*period*/) const {
    return {pneumatics, reservoir, relay_valve, at(now.axles)};
  }

  /// One sample: cylinder pressures at the end of the period that begins.
  void step(State& s, Measurements const& now, double period, PerAxle<double>& pressure) const {
    s.step(pneumatics, now.dump_valve, now.brake_demand, period);
    for (std::size_t i = 0; i < at(now.axles); ++i) pressure[i] = s.cylinder(i).pressure;
  }
};

}  // namespace rollerrig
