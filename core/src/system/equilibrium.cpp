#include "rollerrig/system/equilibrium.hpp"

#include <algorithm>
#include <cmath>

#include "rollerrig/math/lu.hpp"

namespace rollerrig {
namespace {

bool is_roller(Model const& model, int body) {
  return std::ranges::any_of(model.contacts, [body](auto const& c) { return c.roller == body; });
}
bool is_wheelset(Model const& model, int body) {
  return std::ranges::any_of(model.contacts, [body](auto const& c) { return c.wheelset == body; });
}

bool is_held(std::vector<FixedCoordinate> const& fixed, int body, int coordinate) {
  return std::ranges::any_of(fixed, [&](auto const& h) { return h.body == body && h.coordinate == coordinate; });
}

/// Which states are unknown, which rows must vanish, and the factor that turns a row into a force or moment.
struct Problem {
  std::vector<int> columns, rows;
  std::vector<double> weight;
};

Problem set_up(Dynamics const& dynamics, std::vector<FixedCoordinate> const& fixed) {
  Model const& model = dynamics.model();
  StateMap const& map = dynamics.map();
  Problem problem;
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b) {
    Body const& body = model.bodies[at(b)];
    double const inertia[6] = {body.mass, body.mass, body.mass, body.inertia.x, body.inertia.y, body.inertia.z};
    for (int c = 0; c < 6; ++c) {
      int const rate = map.rate[at(b)][at(c)];
      int const coordinate = map.coordinate[at(b)][at(c)];
      if (rate < 0 || is_held(fixed, b, c)) continue;
      if (coordinate >= 0) {
        problem.columns.push_back(coordinate);
      } else {
        if (is_roller(model, b)) continue;  // turns at the running speed
        problem.columns.push_back(rate);
      }
      problem.rows.push_back(rate);
      problem.weight.push_back(inertia[c]);
    }
  }
  for (std::size_t node = 0; node < model.nodes.size(); ++node) {
    problem.columns.push_back(map.coordinates + map.rates + static_cast<int>(node));
    problem.rows.push_back(map.coordinates + map.rates + static_cast<int>(node));
    problem.weight.push_back(model.nodes[node].damping);
  }
  return problem;
}

double vertical_force_on(Dynamics& dynamics, double t, std::vector<double> const& x, int body) {
  dynamics.evaluate(t, x.data());
  return dynamics.work().wrench[at(body)].force.z;
}

bool is_hanging(Dynamics const& dynamics, int body) {
  Model const& model = dynamics.model();
  for (int c = 0; c < static_cast<int>(model.contacts.size()); ++c)
    if (model.contacts[at(c)].wheelset == body && dynamics.patch_count(c) == 0) return true;
  return false;
}

/// Stands a wheelset on its rollers; where only one wheel stands then, turns it about its running direction until both do.
void stand(Dynamics& dynamics, double t, std::vector<double>& x, int body, bool may_turn) {
  double const size = dynamics.model().contacts.front().pair.size;
  double const resolution = 2e-6 * size;  // [m] an approach is about 100e-6 of it
  double const widest = 20e-3;            // [rad], times the size [m]
  set_down(dynamics, t, x, body, widest * size, resolution);
  int const roll = dynamics.map().coordinate[at(body)][coord_roll];
  if (!may_turn || roll < 0 || !is_hanging(dynamics, body)) return;
  double const start = x[at(roll)];
  bool const left_carries = dynamics.work().wrench[at(body)].moment.x > 0.0;  // it is turned to the left side up
  double inner = 0.0, outer = 0.2e-3;                                         // angles from the start [rad]
  bool found = false;                                                         // an angle beyond which the other carries
  while (is_hanging(dynamics, body) && (found ? outer - inner > 1e-7 : outer < 2.0 * widest)) {
    double const angle = found ? 0.5 * (inner + outer) : outer;
    x[at(roll)] = left_carries ? start + angle : start - angle;
    set_down(dynamics, t, x, body, widest * size, resolution);
    bool const beyond = (dynamics.work().wrench[at(body)].moment.x > 0.0) != left_carries;
    found = found || beyond;
    if (beyond)
      outer = angle;
    else
      inner = angle, outer = found ? outer : 2.0 * angle;
  }
}

/// Held coordinates at their values, wheels and rollers at the rates of pure rolling.
void fix_and_roll(Dynamics const& dynamics, double speed, std::vector<FixedCoordinate> const& fixed,
                  std::vector<double>& x) {
  Model const& model = dynamics.model();
  StateMap const& map = dynamics.map();
  for (auto const& h : fixed)
    if (int const i = map.coordinate[at(h.body)][at(h.coordinate)]; i >= 0) x[at(i)] = h.value;
  for (auto const& contact : model.contacts) {
    if (int const i = map.rate[at(contact.wheelset)][coord_pitch]; i >= 0) x[at(i)] = speed / contact.pair.wheel_radius;
    if (contact.roller == ground) continue;
    if (int const i = map.rate[at(contact.roller)][coord_pitch]; i >= 0) x[at(i)] = -speed / contact.roller_radius;
  }
}

/// Wheels roll at the running speed, fixed coordinates are where they belong, and wheelsets stand on their wheels: all are set
/// down, or those alone of which a wheel hangs in the air.
void fix_and_stand(Dynamics& dynamics, double speed, double t, std::vector<FixedCoordinate> const& fixed, bool all,
                   std::vector<double>& x) {
  Model const& model = dynamics.model();
  fix_and_roll(dynamics, speed, fixed, x);
  if (!all) dynamics.evaluate(t, x.data());
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b) {
    if (is_wheelset(model, b) && (all || is_hanging(dynamics, b)) && !is_held(fixed, b, coord_z))
      stand(dynamics, t, x, b, !is_held(fixed, b, coord_roll));
  }
}

/// First guess: everything else where it was designed.
std::vector<double> first_guess(Dynamics& dynamics, double speed, double t, std::vector<FixedCoordinate> const& fixed) {
  std::vector<double> x(at(dynamics.map().states()), 0.0);
  fix_and_stand(dynamics, speed, t, fixed, true, x);
  return x;
}

/// The same state, in which wheelsets turn so that their loaded wheels do not creep along, on the mean: where a steep profile
/// touches far from the nominal radius, the rates of pure rolling with that radius are beyond all friction.
std::vector<double> without_creep(Dynamics& dynamics, double t, std::vector<double> x) {
  Model const& model = dynamics.model();
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b) {
    int const spin = dynamics.map().rate[at(b)][coord_pitch];
    if (!is_wheelset(model, b) || spin < 0 || x[at(spin)] == 0.0) continue;
    auto const slip = [&] {
      dynamics.evaluate(t, x.data());
      double load = 0.0, sum = 0.0;
      for (int c = 0; c < static_cast<int>(model.contacts.size()); ++c)
        for (int k = 0; model.contacts[at(c)].wheelset == b && k < dynamics.patch_count(c); ++k) {
          load += dynamics.patch(c, k).normal.total();
          sum += dynamics.patch(c, k).normal.total() * dynamics.patch(c, k).slip_longitudinal;
        }
      return load > 0.0 ? sum / load : 0.0;
    };
    double const turns = x[at(spin)], change = 1e-3 * turns, before = slip();
    x[at(spin)] = turns + change;
    double const gained = slip() - before;  // in proportion: no contact has moved
    x[at(spin)] = gained != 0.0 ? turns - change * before / gained : turns;
  }
  return x;
}

/// Unbalanced forces and moments in one state; false where a wheel has no contact or a number is not finite.
bool unbalanced(Dynamics& dynamics, Problem const& problem, double t, std::vector<double> const& x,
                Eigen::VectorXd& residual) {
  std::vector<double> x_dot(x.size());
  dynamics.derivative(t, x.data(), x_dot.data(), nullptr);
  for (std::size_t i = 0; i < problem.rows.size(); ++i)
    residual[static_cast<Eigen::Index>(i)] = problem.weight[i] * x_dot[at(problem.rows[i])];
  for (int c = 0; c < static_cast<int>(dynamics.model().contacts.size()); ++c)
    if (dynamics.patch_count(c) == 0) return false;
  return residual.allFinite();
}

/// The equations of a state made linear, and decomposed: they serve for as many steps as gain by them.
class LinearEquations {
 public:
  LinearEquations(Dynamics& dynamics, Problem const& problem, double t, std::vector<double> const& x, JacobianData& j)
      : LinearEquations(matrix_of(dynamics, problem, t, x, j)) {}

  Eigen::VectorXd step(Eigen::VectorXd const& residual) const {
    return scale_.asDiagonal() * decomposed_.solve(residual);
  }

  /// Largest force that no change of the unknowns can balance, where a motion is neutral [N].
  double out_of_reach(Eigen::VectorXd const& residual, Eigen::VectorXd const& step) const {
    return decomposed_.rank() < step.size() ? (residual - matrix_ * step).cwiseAbs().maxCoeff() : 0.0;
  }

 private:
  explicit LinearEquations(Eigen::MatrixXd matrix)
      : matrix_(std::move(matrix)),
        scale_(matrix_.colwise().norm().cwiseMax(floor).cwiseInverse()),
        decomposed_(matrix_ * scale_.asDiagonal(), 1e-10) {}

  static Eigen::MatrixXd matrix_of(Dynamics& dynamics, Problem const& problem, double t, std::vector<double> const& x,
                                   JacobianData& j) {
    auto const n = static_cast<Eigen::Index>(problem.rows.size());
    dynamics.jacobian(t, x.data(), j);
    Eigen::MatrixXd matrix(n, n);
    for (Eigen::Index r = 0; r < n; ++r)
      for (Eigen::Index c = 0; c < n; ++c)
        matrix(r, c) = problem.weight[at(r)] * j.a(problem.rows[at(r)], problem.columns[at(c)]);
    return matrix;
  }

  // Unknowns of very different size (m, rad, rad/s): scale the columns. Least norm where a motion is neutral, as the
  // spin of a wheelset without friction is: forces that change by less than a hundred newton per unit do not count.
  static constexpr double floor = 1e2;
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd scale_;
  LeastNorm decomposed_;
};

/// State, what is unbalanced there, and room for a trial of both.
struct Iterate {
  std::vector<double> x, trial_x;
  Eigen::VectorXd residual, trial_residual;

  /// Whether the state less a part of a step leaves less unbalanced.
  bool gains(Dynamics& dynamics, Problem const& problem, double t, Eigen::VectorXd const& step, double fraction) {
    for (std::size_t i = 0; i < problem.columns.size(); ++i)
      trial_x[at(problem.columns[i])] = x[at(problem.columns[i])] - fraction * step[static_cast<Eigen::Index>(i)];
    return unbalanced(dynamics, problem, t, trial_x, trial_residual) && trial_residual.norm() < residual.norm();
  }
  void accept() {
    x = trial_x;
    residual = trial_residual;
  }
};

/// Newton's method from a state. A Jacobian costs fifteen evaluations of the forces: the last one serves on as long as each
/// step with it leaves less than a tenth.
Equilibrium newton(Dynamics& dynamics, double t, std::vector<FixedCoordinate> const& fixed, std::vector<double> start) {
  Problem const problem = set_up(dynamics, fixed);
  JacobianData j(dynamics.sizes());
  auto const n = static_cast<Eigen::Index>(problem.rows.size());
  Iterate now{start, start, Eigen::VectorXd(n), Eigen::VectorXd(n)};
  unbalanced(dynamics, problem, t, now.x, now.residual);
  Equilibrium result;
  double out_of_reach = 0.0;
  double const enough = 1e-7;    // unbalanced [N, N m], far below anything a result shows; rounding leaves 1e-8
  double const accepted = 1e-3;  // [N, N m]
  for (result.iterations = 1; result.iterations <= 60; ++result.iterations) {
    LinearEquations const equations(dynamics, problem, t, now.x, j);
    Eigen::VectorXd step = equations.step(now.residual);
    out_of_reach = equations.out_of_reach(now.residual, step);
    double fraction = 1.0;
    bool gains = now.gains(dynamics, problem, t, step, fraction);
    for (int halving = 1; !gains && halving < 12; ++halving)
      gains = now.gains(dynamics, problem, t, step, fraction *= 0.5);
    if (!(now.trial_residual.norm() < now.residual.norm())) break;  // rounding level, or stuck
    // Newton's method squares the error: less than half of it gained this near to the end is rounding.
    bool const rounding = now.residual.norm() < accepted && now.trial_residual.norm() > 0.5 * now.residual.norm();
    now.accept();
    bool quick = fraction == 1.0;
    while (quick) {  // beyond what is enough too, where it costs one evaluation
      double const before = now.residual.norm();
      if (!now.gains(dynamics, problem, t, equations.step(now.residual), 1.0)) break;
      now.accept();
      quick = now.residual.norm() < 0.1 * before;
    }
    if (rounding || now.residual.norm() < enough) break;
  }
  unbalanced(dynamics, problem, t, now.x, now.residual);
  result.x = std::move(now.x);
  result.residual = now.residual.cwiseAbs().maxCoeff();
  // A vehicle that is free along its track keeps its rolling resistance, newtons: steady but for a slow coasting.
  bool const coasting = out_of_reach > 0.0 && out_of_reach < 10.0 && result.residual < 1.001 * out_of_reach + 1e-3;
  result.converged = result.residual < accepted || coasting;
  return result;
}

/// Lets the system run towards its equilibrium in heavily damped motion: linearly implicit Euler steps, which grow while they
/// move it little and shrink where they move it far (pseudo-transient continuation: Kelley, Keyes (1998), SIAM J. Numer.
/// Anal. 35). Goes where Newton's method does not, across contacts that come and go.
std::vector<double> relaxed(Dynamics& dynamics, double t, std::vector<FixedCoordinate> const& fixed,
                            std::vector<double> x) {
  StateMap const& map = dynamics.map();
  std::vector<char> is_fixed(x.size(), 0);
  auto const fix = [&](int i) {
    if (i >= 0) is_fixed[at(i)] = 1;
  };
  for (auto const& h : fixed) {
    fix(map.coordinate[at(h.body)][at(h.coordinate)]);
    fix(map.rate[at(h.body)][at(h.coordinate)]);
  }
  for (int b = 0; b < static_cast<int>(dynamics.model().bodies.size()); ++b)
    if (is_roller(dynamics.model(), b)) fix(map.coordinate[at(b)][coord_pitch] < 0 ? map.rate[at(b)][coord_pitch] : -1);
  std::vector<int> free;
  for (int i = 0; i < map.states(); ++i)
    if (!is_fixed[at(i)]) free.push_back(i);

  auto const n = static_cast<Eigen::Index>(free.size());
  JacobianData j(dynamics.sizes());
  Eigen::MatrixXd matrix(n, n);
  Eigen::VectorXd rates(n);
  std::vector<double> x_dot(x.size());
  double h = 1e-3;                   // [s]
  double const longest = 10.0;       // a step this long is one of Newton's
  double const largest_move = 1e-3;  // of a coordinate in one step [m, rad]
  for (int k = 0; k < 500 && h < longest; ++k) {
    dynamics.derivative(t, x.data(), x_dot.data(), nullptr);
    dynamics.jacobian(t, x.data(), j);
    for (Eigen::Index r = 0; r < n; ++r) {
      rates[r] = x_dot[at(free[at(r)])];
      for (Eigen::Index c = 0; c < n; ++c) matrix(r, c) = -j.a(free[at(r)], free[at(c)]);
      matrix(r, r) += 1.0 / h;
    }
    Eigen::VectorXd const step = matrix.partialPivLu().solve(rates);
    double move = 0.0;
    for (Eigen::Index i = 0; i < n; ++i)
      if (int const index = free[at(i)]; index < map.coordinates) move = std::max(move, std::abs(step[i]));
    if (!step.allFinite() || move > largest_move) {
      h *= 0.3;
      continue;
    }
    for (Eigen::Index i = 0; i < n; ++i) x[at(free[at(i)])] += step[i];
    h *= move < 0.1 * largest_move ? 2.0 : 1.2;
  }
  for (std::size_t b = 0; b < map.rate.size(); ++b)
    for (std::size_t c = 0; c < 6; ++c)
      if (map.coordinate[b][c] >= 0) x[at(map.rate[b][c])] = 0.0;
  return x;
}

}  // namespace

// In steps that double, then by halving: a search of contacts that begins near the last one costs least.
bool set_down(Dynamics& dynamics, double t, std::vector<double>& x, int body, double reach, double resolution) {
  int const z = dynamics.map().coordinate[at(body)][coord_z];
  if (z < 0) return true;
  double const start = x[at(z)];
  bool const in_air = !(vertical_force_on(dynamics, t, x, body) > 0.0);
  double inner = 0.0, outer = 16.0 * resolution;  // distances from the start, on this and on the other side [m]
  auto const beyond = [&](double distance) {
    x[at(z)] = in_air ? start - distance : start + distance;
    return (vertical_force_on(dynamics, t, x, body) > 0.0) == in_air;
  };
  bool found = beyond(outer);
  for (; !found && outer < reach; found = beyond(outer)) inner = outer, outer *= 2.0;
  while (outer - inner > resolution) {
    double const middle = 0.5 * (inner + outer);
    (beyond(middle) ? outer : inner) = middle;
  }
  return found;
}

Equilibrium solve_equilibrium(Dynamics& dynamics, double speed, double t, std::vector<FixedCoordinate> const& fixed,
                              std::vector<double> const& near, bool only_near) {
  if (!near.empty()) {
    std::vector<double> x = near;
    if (!only_near) fix_and_stand(dynamics, speed, t, fixed, false, x);
    if (auto result = newton(dynamics, t, fixed, std::move(x)); result.converged || only_near) return result;
  }
  auto result = newton(dynamics, t, fixed, first_guess(dynamics, speed, t, fixed));
  if (result.converged) return result;
  auto rolling = newton(dynamics, t, fixed, without_creep(dynamics, t, first_guess(dynamics, speed, t, fixed)));
  if (rolling.converged) return rolling;
  auto second = newton(dynamics, t, fixed, relaxed(dynamics, t, fixed, first_guess(dynamics, speed, t, fixed)));
  return second.converged ? second : result;
}

}  // namespace rollerrig
