// simulate/tangent_run.hpp - how a run would change with numbers of its model or of its start: derivatives carried beside it.
//
//   Driver, two changed ones per number -> [J S + df/dp at each step of the run] -> states and outputs by each number
//
// The states x of a run obey x' = f(t, x, p), its quadratures z' = g(t, x, p). Their derivatives by a number p obey
//
//     S' = J S + df/dp,   Z' = dg/dx S + dg/dp,   S(0) = dx0/dp                                  J = df/dx, along the run
//
// A step of S and Z is that of the run: of exponential_adams, with the run's L and its weights, from the same earlier points, so
// that S is the derivative of what the run computes. A column needs one value of J S + df/dp a step, at its end; a second one, for
// a second correction, where that is expected to be more than 1e-4 of it: such a part of the first as every 20th step shows.
//
//   J S     in few columns the difference of the slopes in x + a S and in x, a = 1e-8 m over the largest displacement in S, in
//           turns above and below: what bends changes its sign from step to step, and a step sums over four; what it shakes of
//           contacts grows with a, to 4e-5 of their normal forces with 3e-8 m. In many columns J S, J by the sweeps in dual
//           numbers.
//   df/dp   the number enters by two drivers whose models are assembled with p + h and p - h; they are never integrated. Where
//           their contacts are those of the run, by the slopes of the two in turns, in its state and under its contact forces.
//           Otherwise J S + df/dp by their central difference, in the states x + h S and x - h S: a roller of another radius that
//           turned as before would slip.
//
// Sampled blocks in the changed drivers pass their instants in the states x + h S and x - h S, so that what controllers and
// actuators do enters df/dp with it. A column without drivers is a direction of the starting state.
//
// Displacements and rates of bodies are read off S. Other outputs follow the states by a central difference along S within
// 1e-7 m, and the number by that of the two drivers; with sampled blocks, and where the number moves contacts, both at once.
// Source  Bock, Numerical treatment of inverse problems in chemical reaction kinetics, in Modelling of Chemical Reaction Systems
//         (1981): internal differentiation; integrate/exponential_adams.hpp.
#pragma once
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "rollerrig/integrate/past_points.hpp"
#include "rollerrig/simulate/driver.hpp"

namespace rollerrig {

/// Slopes of a model in a state of another one, whose contacts it takes as they are.
class SlopesUnderContacts {
 public:
  explicit SlopesUnderContacts(Model const& model);
  /// Of all but the kinematic states, then of the quadratures.
  Eigen::VectorXd operator()(Dynamics const& other, double t, Inputs const& inputs);

 private:
  Model const& model_;
  Evaluation evaluation_;
};

/// Drivers of the models with a number above and below its own by `half_width`, both started.
struct ChangedRuns {
  Driver* above;
  Driver* below;
  double half_width;    ///< [unit of the number]
  bool moves_contacts;  ///< contact forces in a state depend on the number
};

class TangentRun {
 public:
  /// The drivers must outlive it; what happens in the run does not depend on it. Throws std::invalid_argument where they have
  /// not been started, differ in more than numbers, or the run is not by exponential_adams.
  ///
  /// @param directions   further columns of S(0), of the starting state itself; (states, columns)
  /// @param kept         columns of a row that are wanted
  /// @param breakpoints  times at which something jumps [s]
  TangentRun(Driver& run, std::vector<ChangedRuns> changed, Eigen::MatrixXd const& directions, std::vector<int> kept,
             std::vector<double> breakpoints);

  /// Runs to a time, or to the end of the run; with sampled blocks to the last instant before or at it.
  Status advance(double t_stop);
  double time() const { return time_; }
  std::size_t numbers() const { return changed_.size(); }
  std::size_t width() const { return kept_.size(); }

  auto tangents() const { return y_.topRows(x_.size()); }  ///< S: (states, columns)

  /// What the run has recorded since the last call: at its output times, with the derivatives.
  struct Output {
    double t{};
    std::vector<double> row;
    std::vector<double> derivatives;  ///< one row after the other, for each changed number
  };
  std::vector<Output> take_outputs() { return std::exchange(outputs_, {}); }

 private:
  using Matrix = Eigen::MatrixXd;
  using Vector = Eigen::VectorXd;
  using Columns = std::vector<char>;  ///< which

  void step();
  void fit_spacing(double h);
  Matrix rates(double t, Vector const& x, Matrix const& y, Columns const& wanted);
  Vector along(double t, Vector const& x, Eigen::Ref<Vector const> s, Vector const& here);
  Matrix whole_slope(Matrix const& y, Matrix const& bending) const;
  Vector bending_slope(Driver& of, Dynamics& by, double t, Vector const& x);
  double share_along(std::size_t number, Eigen::Ref<Vector const> s) const;
  void reach_samples(Vector const& x, Vector const& z);
  void act_on_samples();
  Matrix tangents_at(double t) const;
  void keep(double t, double const* x, double const* z);
  void differentiate(double t, double const* x, double const* z, Output& output);

  Driver& run_;
  std::vector<ChangedRuns> changed_;
  struct Pair {
    SlopesUnderContacts above, below;
  };
  std::vector<std::unique_ptr<Pair>> under_contacts_;  ///< per number; none where it moves contacts
  std::vector<int> kept_;
  std::vector<Eigen::Index> direct_;  ///< per kept column: its row in S and Z, or that it is locked or differenced
  std::vector<double> breakpoints_;
  Dynamics dynamics_;  ///< its own, in other states than the run's
  JacobianData jacobian_;
  double jacobian_time_{std::numeric_limits<double>::quiet_NaN()};
  double time_;
  double side_{1.0};      ///< of the next differences
  bool reached_{false};   ///< the changed drivers are at this instant, but have not acted
  bool joined_{false};    ///< slope_ and past_ go on
  Vector x_, z_;          ///< of the run, now
  Vector weight_;         ///< of each state in how far one moves
  Matrix y_, slope_;      ///< S and Z, one below the other, and their rates: (states and quadratures, columns)
  Matrix start_, leave_;  ///< the same before the last step, at start_time_
  double start_time_;
  Matrix linear_;  ///< L that past_ belongs to
  integrate::PastPoints<Matrix> past_;
  double spacing_{0.0};             ///< of past_ [s]
  Eigen::RowVectorXd contraction_;  ///< of the corrections of each column, when last looked at
  int since_look_{0};               ///< steps
  std::vector<Output> outputs_;
};

}  // namespace rollerrig
