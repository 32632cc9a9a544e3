// simulate/tangent_run.hpp - how a run would change with numbers of its model or of its start: derivatives carried beside it.
//
//   Driver, two changed ones per number -> [J by duals, df/dp and g_p by differences] -> states and outputs by each number
//
// The states x of a run obey x' = f(t, x, p), its quadratures z' = g(t, x, p). Their derivatives by a number p obey
//
//     S' = J S + df/dp,   Z' = dg/dx S + dg/dp,   S(0) = dx0/dp                                  J = df/dx, along the run
//
// J and dg/dx are exact, by the sweeps in dual numbers. The number enters by two drivers whose models are assembled with p + h
// and p - h: df/dp is the central difference of their slopes in the state of the run, S(0) that of their starting states. They
// are never integrated: sampled blocks in them pass their instants in the states x + h S and x - h S, so that what controllers
// and actuators do enters df/dp with it. A column without drivers is a direction of the starting state.
//
// A step is of Lobatto's method IIIA with three stages, order 4, A-stable, whose stages are the state of the run at both ends and
// the Hermite polynomial between them; S_1 is the solution of one linear system for all columns:
//
//     S_m = (S_0 + S_1) / 2 + h / 8 (F_0 - F_1),   S_1 = S_0 + h / 6 (F_0 + 4 F_m + F_1),   F = J S + df/dp
//
// Outputs follow the states by a central difference along S within 1e-7 m, and the number by that of the two drivers; with
// sampled blocks both at once.
// Source  Maly, Petzold, Numerical methods and software for sensitivity analysis of DAEs, Appl. Numer. Math. 20 (1996);
//         Hairer, Wanner, Solving Ordinary Differential Equations II (1996), IV.5.
#pragma once
#include <utility>
#include <vector>

#include "rollerrig/simulate/driver.hpp"

namespace rollerrig {

/// Drivers of the models with a number above and below its own by `half_width`, both started.
struct ChangedRuns {
  Driver* above;
  Driver* below;
  double half_width;  ///< [unit of the number]
};

class TangentRun {
 public:
  /// The drivers must outlive it; what happens in the run does not depend on it. Throws std::invalid_argument where they have
  /// not been started, or differ in more than numbers.
  ///
  /// @param directions   further columns of S(0), of the starting state itself; (states, columns)
  /// @param tolerance    error of a step over the largest derivative of a displacement, by the same number, until then
  /// @param breakpoints  times that no step crosses [s]
  TangentRun(Driver& run, std::vector<ChangedRuns> changed, Eigen::MatrixXd const& directions, double tolerance,
             std::vector<double> breakpoints);

  /// Runs to a time, or to the end of the run; with sampled blocks to the last instant before or at it.
  Status advance(double t_stop);
  double time() const { return time_; }
  std::size_t numbers() const { return changed_.size(); }
  std::size_t width() const { return static_cast<std::size_t>(run_.width()); }

  Eigen::MatrixXd const& tangents() const { return s_; }  ///< S: (states, columns)

  /// What the run has recorded since the last call: at its output times, with the derivatives.
  struct Output {
    double t{};
    Eigen::VectorXd x, z;
    std::vector<double> row;
    std::vector<double> derivatives;  ///< one row after the other, for each changed number
  };
  std::vector<Output> take_outputs() { return std::exchange(outputs_, {}); }

 private:
  /// Everything that a step needs to know of an instant.
  struct Point {
    double t;           ///< [s]
    Eigen::VectorXd x;  ///< of the run
    Eigen::VectorXd slope;
    JacobianData j;
    Eigen::MatrixXd by_number;  ///< df/dp: (states, columns)
    Eigen::MatrixXd power;      ///< dg/dp: (quadratures, columns)
  };
  struct Tangents {
    Eigen::MatrixXd s, z;
  };
  struct Knot {
    double t;
    Tangents now, rate;
  };

  double next_end(double t_stop) const;
  void reach_samples();
  Status step(double end);
  void solve(Point const& from, Point const& middle, Point const& to, int halvings);
  Point between(Point const& from, Point const& to);
  Point look(double t, Eigen::VectorXd const& x);
  double share_along(std::size_t number) const;
  Tangents tangents_at(double t) const;
  void differentiate_outputs(double until);
  void differentiate(Output& output, Tangents const& tangents);
  Tangents one_step(Point const& from, Point const& middle, Point const& to, Tangents const& start) const;

  Driver& run_;
  std::vector<ChangedRuns> changed_;
  double tolerance_;
  std::vector<double> breakpoints_;
  Dynamics dynamics_;  ///< its own: what the run has evaluated last stays so
  double time_;
  double length_;       ///< of the next step [s]
  bool joined_{false};  ///< start_ holds the present instant
  Eigen::VectorXd x_, z_;
  Eigen::MatrixXd s_, z_tangents_;
  Eigen::VectorXd weight_, largest_;  ///< of each state in an error; of each column of S until now
  Point start_;
  std::vector<Knot> knots_;  ///< of the last step
  std::vector<Output> outputs_;
};

}  // namespace rollerrig
