// differential_equation.hpp - what an integrator asks of a system, and nothing more.
//
//   system -> [x' = f(t, x),  z' = g(t, x)] -> integrate
//
// x are the states, z the quadratures: they accumulate (work, heat, wheel angles) and act back on
// nothing, so they cost no row in a linear solve and take no part in the step size control.
#pragma once
#include <Eigen/Core>
#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "rollerrig/integrate/options.hpp"
#include "rollerrig/status.hpp"

namespace rollerrig {

/// Combinations of its states that decay fast, and how fast, for now.
///
///   system -> [s_i = d_i . x,  s_i' = N_i - rate_i s_i,  x moves by u_i where s_i moves by 1] -> exponential methods
///
/// d_i . u_j = 1 for i = j, else 0: the modes are independent of each other. The value that s_i decays to may itself change
/// steadily, as with the speed of a rail under a braking train: at about the trend.
///
/// Rate and trend need not be exact, N takes up the rest. A rate between 0.6 and any multiple of the true one keeps the method
/// stable; the nearer, the more accurate.
class StiffModes {
 public:
  /// One state's part in a mode, or with d = 0 what a quadrature, behind the states, gains when s_i is moved.
  struct Entry {
    int place;  ///< of the state
    double d, u;
    void state(auto& archive) { archive(place, d, u); }
  };
  struct Mode {
    double rate;   ///< [1/s]
    double trend;  ///< of the value it decays to [unit of s_i over s]
    std::size_t first, count;
    void state(auto& archive) { archive(rate, trend, first, count); }
  };

  StiffModes() = default;
  StiffModes(std::size_t most_modes, std::size_t most_entries, std::size_t longest_origin) {
    mode_.reserve(most_modes);
    entry_.reserve(most_entries);
    origin.reserve(longest_origin);
  }

  void clear() {
    mode_.clear();
    entry_.clear();
    origin.clear();
  }
  /// A mode without entries, to be followed by add() for each.
  void begin(double rate, double trend) { mode_.push_back({rate, trend, entry_.size(), 0}); }
  void add(int state, double d, double u) {
    entry_.push_back({state, d, u});
    ++mode_.back().count;
  }

  std::size_t size() const { return mode_.size(); }
  std::size_t capacity() const { return mode_.capacity(); }
  double rate(std::size_t i) const { return mode_[i].rate; }
  double trend(std::size_t i) const { return mode_[i].trend; }
  std::span<Entry const> entries(std::size_t i) const { return {entry_.data() + mode_[i].first, mode_[i].count}; }
  /// s of mode i.
  double along(std::size_t i, double const* x) const {
    double s = 0.0;
    for (Entry const& e : entries(i)) s += e.d * x[e.place];
    return s;
  }
  /// Moves x so that s of mode i grows by `distance` and no other does.
  void move(std::size_t i, double distance, double* x) const {
    for (Entry const& e : entries(i)) x[e.place] += e.u * distance;
  }

  std::vector<double> origin;  ///< what the system made them from, for it to compare

  /// @param states  numbers that a mode may move
  void state(auto& archive, int states) {
    archive.list(origin, origin.capacity());
    archive.list(mode_, mode_.capacity());
    archive.list(entry_, entry_.capacity());
    for (Mode const& mode : mode_)
      archive.need(mode.first <= entry_.size() && mode.count <= entry_.size() - mode.first);
    for (Entry const& entry : entry_) archive.need(entry.place >= 0 && entry.place < states);
  }

 private:
  std::vector<Mode> mode_;
  std::vector<Entry> entry_;
};

struct Sizes {
  int states = 0;       ///< n, length of x
  int quadratures = 0;  ///< m, length of z
};

/// Derivatives of f and g at one (t, x), owned by the integrator and filled by the system.
struct JacobianData {
  Eigen::MatrixXd a;    ///< (n, n) df/dx
  Eigen::MatrixXd g;    ///< (m, n) dg/dx
  Eigen::VectorXd f_t;  ///< (n)    df/dt, from the right where an input has a kink
  Eigen::VectorXd g_t;  ///< (m)    dg/dt, from the right

  JacobianData() = default;
  explicit JacobianData(Sizes sizes)
      : a(Eigen::MatrixXd::Zero(sizes.states, sizes.states)),
        g(Eigen::MatrixXd::Zero(sizes.quadratures, sizes.states)),
        f_t(Eigen::VectorXd::Zero(sizes.states)),
        g_t(Eigen::VectorXd::Zero(sizes.quadratures)) {}

  void state(auto& archive) { archive(a, g, f_t, g_t); }
};

/// x' = f, z' = g, and what the methods know of them.
///
/// derivative()   z_dot may be a null pointer: then only f is wanted.
/// jacobian()     every entry must be written: J keeps its last values.
/// accept()       is called at the start and after each step that is kept, to check validity and to refresh caches; a Status that is
///                not ok ends the integration there.
/// kinematic_states(), velocity_column()
///                x'[i] = x[velocity_column(i)] for i < kinematic_states() <= velocity_column(i): implicit methods factor only the
///                remaining block. 0: there are none.
/// stiff_modes()  combinations of states that decay fast, inner nodes of dampers, or slip against creep forces that grow with it: an
///                exponential method integrates their decay exactly. An empty set with room for all there can be.
/// renew_stiff_modes(now, next)
///                looks at what derivative() evaluated last, and fills `next` and returns true where that asks for others than `now`.
template <class S>
concept DifferentialEquation = requires(S& system, double t, double const* x, double* x_dot, double* z_dot,
                                        JacobianData& j, int i, StiffModes const& now, StiffModes& next) {
  { system.sizes() } -> std::convertible_to<Sizes>;
  { system.derivative(t, x, x_dot, z_dot) } -> std::same_as<Status>;
  { system.jacobian(t, x, j) } -> std::same_as<Status>;
  { system.accept(t, x) } -> std::same_as<Status>;
  { system.kinematic_states() } -> std::convertible_to<int>;
  { system.velocity_column(i) } -> std::convertible_to<int>;
  { system.stiff_modes() } -> std::same_as<StiffModes>;
  { system.renew_stiff_modes(now, next) } -> std::same_as<bool>;
};

}  // namespace rollerrig

namespace rollerrig::integrate {

// The system as the methods see it: one vector y = (x, z), calls counted.

using Vector = Eigen::VectorXd;

/// One attempted step.
struct Step {
  double t;    ///< [s] start
  double h;    ///< [s] length
  double end;  ///< [s] time given to the stages at the end: t + h, or just before a breakpoint, so
               ///< that an input which jumps there is still taken from the left
};

template <class System>
class Evaluator {
 public:
  explicit Evaluator(System& system) : system_{&system}, sizes_{system.sizes()} {}

  Sizes sizes() const { return sizes_; }
  System& system() const { return *system_; }

  /// y_dot = (f, g) at (t, y); the z-part of y is not read.
  Status derivative(double t, Vector const& y, Vector& y_dot) {
    ++statistics.derivative_calls;
    return system_->derivative(t, y.data(), y_dot.data(), y_dot.data() + sizes_.states);
  }

  Status jacobian(double t, Vector const& y, JacobianData& j) {
    ++statistics.jacobian_calls;
    return system_->jacobian(t, y.data(), j);
  }

  Statistics statistics;

 private:
  System* system_;
  Sizes sizes_;
};

}  // namespace rollerrig::integrate
