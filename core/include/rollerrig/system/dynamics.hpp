// system/dynamics.hpp - x' = f(t, x), its Jacobian and its outputs: the one place where bodies and contacts meet.
//
//   model -> [dynamics] -> integrate, equilibrium, linearisation, record
//
// One evaluation: unpack the bodies' motion; suspension; contact search and contact forces per wheel; torques; Newton and
// Euler. The same template runs in double and in JacobianDual; the Jacobian is made of sweeps over groups of bodies, and
// each sweep evaluates only what its bodies touch.
#pragma once
#include <limits>
#include <memory>
#include <vector>

#include "rollerrig/geometry/search.hpp"
#include "rollerrig/integrate/differential_equation.hpp"
#include "rollerrig/math/dual.hpp"
#include "rollerrig/system/contact_placement.hpp"
#include "rollerrig/system/inputs.hpp"
#include "rollerrig/system/model.hpp"
#include "rollerrig/system/rolling_constraint.hpp"

namespace rollerrig {

/// What happened in the contacts of a run, summed over accepted steps.
struct ContactCounters {
  long limited_curvature{0};     ///< patches whose curvatures were outside Hertz' theory
  long clamped_aspect{0};        ///< patches with a/b outside Kalker's table
  long overlapping{0};           ///< pairs of patches of one wheel whose ellipses overlap
  long several_patches{0};       ///< wheels with more than one patch
  long faded{0};                 ///< patches that counted in part, contact/normal/blending_weight.hpp
  long lost{0};                  ///< wheels without contact
  long negative_dissipation{0};  ///< patches whose creep law fed energy in
  long checked{0};               ///< wheels looked at
};

template <Scalar T>
struct Workspace {
  std::vector<BodyMotion<T>> motion;
  std::vector<Wrench<T>> wrench;
  std::vector<std::array<T, 6>> acceleration;
  std::vector<T> constraint_moment;
  std::vector<T> node;
  std::vector<T> node_rate;
  BodyMotion<T> ground_motion;
  std::array<T, account_count> power;
  std::vector<AxleCreep<T>> axle_creep;  ///< per rolling constraint
  std::vector<Vec3<T>> gyroscopic;       ///< per body, body components [N m]
  std::vector<T> coupling_load;          ///< per coupling

  Travel<T> travel;
  std::vector<RailOffset<T>> offset;  ///< per contact, of the irregularity
  bool curved{false};                 ///< some body is in a curve or on cant; else what follows is not used
  std::vector<TrackFrame<T>> frame;   ///< per body
  std::vector<BodyMotion<T>> common;  ///< per body: its motion seen from H, multibody/moving_frame.hpp
  std::vector<Wrench<T>> common_wrench;
};

class Dynamics {
 public:
  static constexpr int max_patches = ContactSearch::max_minima;

  explicit Dynamics(std::shared_ptr<Model const> model);
  Dynamics(Dynamics const&) = delete;
  Dynamics& operator=(Dynamics const&) = delete;

  Sizes sizes() const { return {map_.states(), map_.angles + account_count}; }
  int kinematic_states() const { return map_.coordinates; }
  int velocity_column(int i) const { return map_.velocity_column[static_cast<std::size_t>(i)]; }

  /// Inner nodes of elements, and slips against creep.
  RelaxingDirections relaxing_directions() const;
  bool renew_relaxing_directions(RelaxingDirections const& now, RelaxingDirections& next) const;

  Status derivative(double t, double const* x, double* x_dot, double* z_dot);
  Status jacobian(double t, double const* x, JacobianData& j);
  Status accept(double t, double const* x);

  /// Evaluates the model at (t, x) and leaves motion, forces and patches to be read.
  void evaluate(double t, double const* x);

  /// Evaluate anew next time: to be called after a change of the model.
  void forget() { evaluated_time_ = std::numeric_limits<double>::quiet_NaN(); }

  /// Longitudinal slip at nominal radii of the axle of a rolling constraint, in the last evaluation [m/s].
  double rolling_slip(int constraint) const;
  /// Force of a rolling constraint less the creep forces it replaces, on the wheelset, forward, in the last evaluation [N].
  double rolling_force(int constraint) const { return rolling_force_[static_cast<std::size_t>(constraint)]; }

  /// The contact search of every wheel alone, for benchmarks.
  void search_contacts(double t, double const* x);

  Model const& model() const { return *model_; }
  StateMap const& map() const { return map_; }
  Workspace<double> const& work() const { return work_; }
  /// Patches of one wheel, left-handed mirror removed only in `force` and `moment` of wheel_wrench().
  int patch_count(int contact) const { return patch_count_[static_cast<std::size_t>(contact)]; }
  Patch<double> const& patch(int contact, int k) const {
    return patches_[static_cast<std::size_t>(contact * max_patches + k)];
  }
  double element_force(int element, int direction) const {
    return element_force_[static_cast<std::size_t>(element * 6 + direction)];
  }
  double element_deflection(int element, int direction) const {
    return element_deflection_[static_cast<std::size_t>(element * 6 + direction)];
  }
  ContactCounters const& counters() const { return counters_; }
  void reset_run();
  int failed_contact() const { return failed_contact_; }
  /// Evaluations of the reduced contact equation at cell borders, all wheels: what the warm search saves.
  long search_evaluations() const {
    long sum = 0;
    for (auto const& search : search_) sum += search.node_evaluations();
    return sum;
  }
  Inputs inputs;                  ///< call forget() after a change
  bool exhaustive_search{false};  ///< look at every cell in every evaluation (verification)

  double kinetic_energy() const;
  double gravity_energy() const;
  double element_energy() const;

  /// Where the vehicle's reference point is along the line.
  Travel<double> travel(double t) const { return travel_now(t); }
  /// Force of the contacts on the wheels along the running direction, all together, in the last evaluation [N].
  double longitudinal_contact_force() const { return longitudinal_force_; }
  /// Torque of a friction brake on its axle in the last evaluation [N m].
  double brake_torque(int brake) const { return brake_torque_[static_cast<std::size_t>(brake)]; }
  /// Acceleration of a body's centre of mass and 1 g against gravity, along its own axes: what an accelerometer there feels.
  Vec3<double> felt_acceleration(int body) const;

 private:
  struct Sweep {
    std::vector<int> bodies;         ///< bodies whose coordinates and rates are seeded
    std::vector<int> columns;        ///< state index of each seed
    std::vector<char> touched_body;  ///< per body: seeded
    std::vector<char> touched_element, touched_contact;
    std::vector<char> affected_body;  ///< per body: its acceleration depends on a seed
    int first_node{0}, node_count{0};
  };

  static constexpr std::size_t most_bodies = 3;  ///< of a group: a wheelset and the rollers under it
  static constexpr std::size_t most_velocities = 6 * most_bodies;
  /// A wheelset with the rollers under it, and its contacts: creep of other wheels does not touch them.
  struct CreepGroup {
    std::vector<int> body;
    std::vector<int> contact;
  };
  struct Slips;
  void plan_relaxation();
  std::array<double, 2> viscosity(int contact, int k) const;
  void add_slip(CreepGroup const& group, int contact, int k, ContactPlacement<double> const& placed, bool lateral,
                double viscosity, Slips& slips) const;
  void add_directions(CreepGroup const& group, Slips const& slips, RelaxingDirections& out) const;

  template <Scalar T>
  void resize(Workspace<T>& w) const;
  void unpack(double const* x);
  template <Scalar T>
  Travel<T> travel_now(T const& t) const;
  template <Scalar T>
  void place(Workspace<T>& w, T const& t) const;
  template <Scalar T>
  void see_from_common(Workspace<T>& w, int body) const;
  template <Scalar T>
  ContactPlacement<T> placement(int index, Workspace<T> const& w) const;
  template <Scalar T>
  Vec3<T> moving_frame_wrench(Workspace<T>& w, std::size_t b) const;
  void plan_sweeps();
  template <Scalar T>
  void evaluate_forces(Workspace<T>& w, T const& t, Sweep const* sweep);
  template <Scalar T>
  void apply_element(Workspace<T>& w, int index);
  template <Scalar T>
  void apply_torques(Workspace<T>& w, T const& t);
  template <Scalar T>
  void apply_resistance(Workspace<T>& w);
  template <Scalar T>
  void hold(Workspace<T>& w, std::size_t axle_torque, Vec3<T> const& moment);
  template <Scalar T>
  void apply_couplings(Workspace<T>& w, Sweep const* sweep);
  template <Scalar T>
  void apply_contact(Workspace<T>& w, T const& t, int index);
  void store_sweep(Sweep const& sweep, JacobianData& j) const;
  void time_derivative(double t, JacobianData& j);

  std::shared_ptr<Model const> model_;
  StateMap const& map_;
  Workspace<double> work_;
  Workspace<JacobianDual> dual_;
  std::vector<Sweep> sweeps_;
  Sweep time_sweep_;
  bool on_rails_{false};           ///< some contact is with a rail: the vehicle's frames travel
  double rear_{0.0}, front_{0.0};  ///< places of the last and the first body from the vehicle's reference point [m]
  double foremost_wheel_{0.0};     ///< [m]
  std::vector<ContactSearch> search_;
  std::vector<Patch<double>> patches_;
  std::vector<int> patch_count_;
  std::vector<double> element_force_, element_deflection_;
  std::vector<char> element_rotates_;
  std::vector<double> relaxation_rate_;  ///< of the elements' inner nodes, c s' = k_s (d - s): k_s / c [1/s]
  std::vector<CreepGroup> creep_groups_;
  std::vector<double> rotor_inertia_;  ///< that geared rotors add to the pitch inertia of each body [kg m^2]
  std::vector<double> brake_torque_;
  std::vector<double> rolling_force_;
  double longitudinal_force_{0.0};
  bool has_adhesion_maps_{false};
  std::vector<double> off_since_;
  std::vector<double> flange_tip_;
  double evaluated_time_{std::numeric_limits<double>::quiet_NaN()};  ///< what work_ belongs to
  std::vector<double> evaluated_;
  ContactCounters counters_;
  int failed_contact_{-1};
};

}  // namespace rollerrig
