#include "rollerrig/simulate/held_speed.hpp"

#include <algorithm>

#include "rollerrig/math/least_norm.hpp"
#include "rollerrig/simulate/linear_model.hpp"

namespace rollerrig {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int load_steps = 4;          ///< by which the pressures grow: creep is bent
constexpr int most_iterations = 20;    ///< at each
constexpr double accuracy = 1e-8;      ///< of all rates of the states [m/s, m/s^2, rad/s, rad/s^2]
constexpr double torque_scale = 1e4;   ///< of a roller's torque beside a state of about 1 [N m]
constexpr double longest_step = 10.0;  ///< of what is searched, so scaled: beyond, wheels slide

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

class Search {
 public:
  Search(Dynamics& dynamics, double t, std::vector<double> x)
      : dynamics_{dynamics}, t_{t}, x_{std::move(x)}, torque_(dynamics.model().roller_torques.size(), 0.0) {
    std::vector<bool> held(x_.size(), false);
    for (RollerTorque const& one : dynamics.model().roller_torques)
      if (int const rate = dynamics.map().rate[static_cast<std::size_t>(one.roller)][coord_pitch]; rate >= 0)
        held[static_cast<std::size_t>(rate)] = true;
    for (std::size_t i = 0; i < x_.size(); ++i)
      if (!held[i]) free_.push_back(static_cast<Index>(i));
  }

  bool run(std::span<double const> pressure) {
    for (int k = 1; k <= load_steps; ++k) {
      inputs_.cylinder.clear();
      for (double p : pressure) inputs_.cylinder.push_back({t_, p * k / load_steps, 0.0});
      if (!solve()) return false;
    }
    return true;
  }

  std::vector<double> const& x() const { return x_; }
  std::vector<double> const& torque() const { return torque_; }

 private:
  bool solve() {
    std::vector<double> z(static_cast<std::size_t>(dynamics_.sizes().quadratures));
    VectorXd rate(static_cast<Index>(x_.size()));
    for (int i = 0; i < most_iterations; ++i) {
      inputs_.roller_torque.clear();
      for (double torque : torque_) inputs_.roller_torque.push_back({t_, torque, 0.0});
      if (dynamics_.derivative(t_, x_.data(), rate.data(), z.data(), inputs_) != Status::ok || !rate.allFinite())
        return false;
      if (rate.cwiseAbs().maxCoeff() < accuracy) return true;
      if (!step(rate)) return false;
    }
    return false;
  }

  /// The least change that takes the rates away, to first order: what is free to stay anywhere stays.
  bool step(VectorXd const& rate) {
    auto const linear = linear_model(dynamics_, t_, x_.data(), inputs_);
    auto const states = static_cast<Index>(free_.size()), torques = static_cast<Index>(torque_.size());
    auto const first = static_cast<Index>(dynamics_.model().axle_torques.size());
    MatrixXd by(rate.size(), states + torques);
    for (Index k = 0; k < states; ++k) by.col(k) = linear.a.col(free_[at(k)]);
    for (Index k = 0; k < torques; ++k) by.col(states + k) = torque_scale * linear.b.col(first + k);
    VectorXd const change = LeastNorm(by).solve(-rate);
    if (!change.allFinite() || change.cwiseAbs().maxCoeff() > longest_step) return false;
    for (Index k = 0; k < states; ++k) x_[at(free_[at(k)])] += change[k];
    for (Index k = 0; k < torques; ++k) torque_[at(k)] += torque_scale * change[states + k];
    return true;
  }

  Dynamics& dynamics_;
  double t_;
  std::vector<double> x_, torque_;
  std::vector<Index> free_;  ///< states that are searched
  Inputs inputs_;
};

}  // namespace

HeldSpeed hold_speed(Dynamics& dynamics, double t, double const* x, std::span<double const> pressure) {
  Search search(dynamics, t, {x, x + dynamics.sizes().states});
  bool const found = search.run(pressure);
  return {search.x(), search.torque(), found};
}

}  // namespace rollerrig
