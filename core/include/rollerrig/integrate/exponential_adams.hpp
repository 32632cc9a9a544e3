// integrate/exponential_adams.hpp - exponential Adams method of order 4 in predictor-corrector form, with a kept Jacobian.
//
//     y' = f(t, y) = L y + N(t, y);      y(t + h) = e^(hL) y + h integral over theta of e^((1 - theta) hL) N
//
// What L = df/dy of an earlier state holds is integrated exactly: stiff contacts, dampers, creep. N is what the forces bend away
// from it, a cubic of time through its values in the last four points. y holds states and quadratures: what the drives work on
// momentum, say, balances to round-off.
//
//     predict    y_p   = y + h [phi_1 f + A_1 DN + A_2 D2N + A_3 D3N]           D^m: backward differences at t
//     evaluate   N_p   = f(t + h, y_p) - L y_p
//     correct    y_new = y_p + h A_3 D4N_p                                      the cubic through N_p instead of the oldest
//     evaluate   f(t + h, y_new), the next step's first
//
// Two evaluations a step and no Jacobian while N stays smooth. The correction shows the error: a step that is too long is repeated
// with half of it, down to a 32nd, and doubled where it would serve. Where the error is below a thousandth of what is allowed, the
// prediction is kept as it is, and its evaluation is the next step's first: one a step. Its error is the correction itself, still
// below a seventieth of what is allowed.
//
// Whether L is too old shows in the second evaluation: the correction that it would make, over the one before it, is what is left
// of df/dy - L over a step. L is renewed where that is above 0.3, looked at every twentieth step once it has served for 200 (from
// about 0.5 on corrections grow from step to step, as with Adams methods without L; as a train slows, creep stiffens); and above
// 0.1 where a step fails. A step that fails at a kink of the forces, where it is small, is halved at once: a new L costs as much
// as 50 steps.
//
// The first three steps after a start or a break are of the exponential Runge-Kutta method of Krogstad, order 4. Dense output:
// cubic Hermite polynomial, order 3.
// Source  Cox, Matthews, J. Comput. Phys. 176 (2002); Krogstad, J. Comput. Phys. 203 (2005); Hochbruck, Ostermann, Exponential
//         multistep methods of Adams-type, BIT 51 (2011). Error: Milne's, Hairer, Norsett, Wanner, Solving ODEs I (1993), III.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "rollerrig/integrate/matrix_phi_functions.hpp"
#include "rollerrig/integrate/past_points.hpp"

namespace rollerrig::integrate {

class ExponentialAdams {
 public:
  static constexpr int order = 4;
  static constexpr int error_order = 5;
  static constexpr bool implicit = false;

  template <class System>
  explicit ExponentialAdams(Evaluator<System> const& f)
      : n_{f.sizes().states},
        kinematic_{f.system().kinematic_states()},
        jacobian_(f.sizes()),
        past_(Vector::Zero(n_), Vector::Zero(n_ + f.sizes().quadratures - kinematic_)),
        phi_(n_, kinematic_, f.sizes().quadratures),
        weights_(halvings + 2) {
    auto const size = n_ + f.sizes().quadratures;
    auto const bending = size - kinematic_;
    for (Vector* v : {&f_start_, &f_end_, &stage_, &slope_, &sum_}) v->setZero(size);
    for (Vector* v : {&d1_, &d2_, &d3_}) v->setZero(bending);
    error_.setZero(n_);
    linear_.setZero(bending, n_);
    for (StepWeights& w : weights_) {
      w.slope.setZero(size, size);
      for (auto& m : w.difference) m.setZero(size, bending);
    }
  }

  void restart() { has_end_slope_ = planned_ = false; }

  template <class System>
  Status prepare(Evaluator<System>& f, double t, Vector const& y) {
    if (std::exchange(has_end_slope_, false)) {
      f_start_.swap(f_end_);
      return Status::ok;
    }
    return f.derivative(t, y, f_start_);
  }

  Vector const& slope() const { return f_start_; }
  Vector const& error() const { return error_; }

  /// For others that take the same steps: L, of all but the kinematic states, by the states; weights of a step of h [s].
  Eigen::MatrixXd const& linear() const { return linear_; }
  StepWeights const& weights(double h) const {
    return weights_[at(std::clamp<long>(std::lround(std::log2(h_ / h)), 0, halvings))];
  }

  /// Whether plan() holds: the steps stand on a grid of their own.
  bool planned() const { return planned_; }
  /// Steps of h [s] and its halves from (t, y) on, whose slope is known.
  template <class System>
  Status plan(Evaluator<System>& f, double t, Vector const& y, double h) {
    h_ = h;
    level_ = first_level;
    ticks_ = 0;
    since_ = 0;
    past_.clear();
    if (auto e = f.jacobian(t, y, jacobian_); e != Status::ok) return e;
    linearise();
    planned_ = true;
    remember(y, f_start_);
    return Status::ok;
  }
  /// [s] of which every step is a multiple.
  double tick() const { return h_ / (1 << halvings); }
  /// Of the next step, and from plan() to its start.
  std::int64_t step_ticks() const { return std::int64_t{1} << (halvings - level_); }
  std::int64_t ticks() const { return ticks_; }

  /// @param norm  of error(), 1: exactly the tolerance
  template <class System, class Norm>
  Status attempt(Evaluator<System>& f, Step const& s, Vector const& y, Vector& y_new, Norm&& norm) {
    bool const several = past_.enough();
    Status const status = several ? multistep(f, s, y, y_new) : single_step(f, s, y, y_new);
    if (status != Status::ok) return status;
    if (several && !checks_jacobian(since_ + 1) && norm(error_, y, y_new) < predictor_only_below) {
      y_new.swap(stage_);
      f_end_.swap(slope_);
      return Status::ok;
    }
    return f.derivative(s.end, y_new, f_end_);
  }

  /// Ends an attempt that is kept.
  ///
  /// @param error  norm of error(), 1: exactly the tolerance
  template <class System>
  Status accept(Evaluator<System>& f, double t, Vector const& y, double error) {
    has_end_slope_ = true;
    ticks_ += step_ticks();
    bool const old = checks_jacobian(++since_) && past_.enough() && std::ldexp(contraction(), level_) > refresh_above;
    remember(y, f_end_);
    if (level_ > 0 && past_.known() == PastPoints<>::most && error < allowed_to_double &&
        ticks_ % (2 * step_ticks()) == 0) {
      past_.double_step();
      --level_;
    }
    return old ? renew(f, t, y) : Status::ok;
  }

  bool can_halve() const { return level_ < halvings; }
  void halve() {
    ++level_;
    past_.halve_step();
  }

  /// Whether the step that has just failed should be repeated with a new L rather than halved.
  bool stale() { return since_ >= looked_at_every && past_.enough() && contraction() > worn; }

  /// L of the state (t, y) in which a step starts.
  template <class System>
  Status renew(Evaluator<System>& f, double t, Vector const& y) {
    since_ = 0;
    if (auto e = f.jacobian(t, y, jacobian_); e != Status::ok) return e;
    linear_.topRows(n_ - kinematic_) -= jacobian_.a.bottomRows(n_ - kinematic_);
    linear_.bottomRows(jacobian_.g.rows()) -= jacobian_.g;
    past_.add_linear(linear_);
    linearise();
    return Status::ok;
  }

  /// y(t + theta h) of the last attempted step; HNW I (6.7).
  void interpolate(double theta, double h, Vector const& y, Vector const& y_new, Vector& out) const {
    double const rest = 1 - theta;
    out = rest * y + theta * y_new -
          (theta * rest) * ((1 - 2 * theta) * (y_new - y) - (rest * h) * f_start_ + (theta * h) * f_end_);
  }

  /// Everything that changes in a run, for plant/state_archive.hpp; the weights follow from the Jacobian.
  template <class Archive>
  void state(Archive& archive) {
    archive(jacobian_, linear_, past_, f_start_, f_end_, stage_, slope_, sum_, error_, d1_, d2_, d3_);
    archive(h_, has_end_slope_, planned_);
    archive.within(level_, 0, halvings);
    for (std::int64_t* count : {&ticks_, &since_}) archive.within(*count, std::int64_t{0}, std::int64_t{1} << 60);
    archive.need(h_ >= 0.0 && (!planned_ || (h_ > 0.0 && past_.known() > 0)));
    if constexpr (Archive::reading)
      if (h_ > 0.0) phi_.compute(jacobian_, h_, weights_);
  }

 private:
  static constexpr int halvings = 5;
  static constexpr int first_level = 3;          // an eighth: the first steps see what a start from anywhere lets loose
  static constexpr double milne = 19.0 / 270.0;  // error of the corrected over the correction
  static constexpr double allowed_to_double = 0.5 / 32.0;  // error that twice the step makes 0.5
  static constexpr double predictor_only_below = 1e-3;  // error of a step whose prediction, 14 times as far off, serves
  static constexpr double worn = 0.1, refresh_above = 0.3;  // contraction() of a step that fails, of the longest step
  static constexpr int steps_before_check = 200, looked_at_every = 20;  // steps

  /// Whether the contraction of the corrections is looked at in this step since L was renewed.
  static bool checks_jacobian(std::int64_t step) { return step >= steps_before_check && step % looked_at_every == 0; }

  void linearise() {
    linear_.topRows(n_ - kinematic_) = jacobian_.a.bottomRows(n_ - kinematic_);
    linear_.bottomRows(jacobian_.g.rows()) = jacobian_.g;
    phi_.compute(jacobian_, h_, weights_);
  }

  /// A second correction of the step that multistep() has attempted, over the first.
  double contraction() {
    double const first = sum_.head(n_).norm();
    d1_ = (f_end_ - slope_).tail(d1_.size());
    d1_.noalias() -= linear_ * (std::ldexp(h_, -level_) * sum_.head(n_));
    error_.noalias() = weights_[at(level_)].difference[2].topRows(n_) * d1_;
    return error_.norm() / first;
  }

  void remember(Vector const& y, Vector const& y_dot) {
    auto& p = past_.add();
    p.x = y.head(n_);
    nonlinear_part(y, y_dot, p.nonlinear);
  }

  /// N = y' - L y, of all but the kinematic states: their rates are states, there N = 0.
  void nonlinear_part(Vector const& y, Vector const& y_dot, Vector& out) const {
    out = y_dot.tail(out.size());
    out.noalias() -= linear_ * y.head(n_);
  }

  template <class System>
  Status multistep(Evaluator<System>& f, Step const& s, Vector const& y, Vector& y_new) {
    StepWeights const& w = weights_[at(level_)];
    Vector const &n0 = past_[0].nonlinear, &n1 = past_[1].nonlinear, &n2 = past_[2].nonlinear, &n3 = past_[3].nonlinear;
    d1_ = n0 - n1;
    d2_ = n0 - 2 * n1 + n2;
    d3_ = n0 - 3 * n1 + 3 * n2 - n3;
    sum_.noalias() = w.slope * f_start_;
    sum_.noalias() += w.difference[0] * d1_;
    sum_.noalias() += w.difference[1] * d2_;
    sum_.noalias() += w.difference[2] * d3_;
    stage_ = y + s.h * sum_;
    if (auto e = f.derivative(s.end, stage_, slope_); e != Status::ok) return e;
    nonlinear_part(stage_, slope_, d1_);
    d1_ += -4 * n0 + 6 * n1 - 4 * n2 + n3;
    sum_.noalias() = w.difference[2] * d1_;
    y_new = stage_ + s.h * sum_;
    error_ = (milne * s.h) * sum_.head(n_);
    return Status::ok;
  }

  /// Krogstad's method, its stages in differences D of N to that at the start:
  ///
  ///     y + h phi_1 f + h phi_2 (2 S - D_c) + 4 h phi_3 (D_c - S),   S = D_a + D_b,   phi_2 = A_1,   phi_3 = A_2 - A_1 / 2.
  template <class System>
  Status single_step(Evaluator<System>& f, Step const& s, Vector const& y, Vector& y_new) {
    double const h = s.h, middle = s.t + 0.5 * s.h;
    StepWeights const& w = weights_[at(level_)];
    StepWeights const& half = weights_[at(level_) + 1];
    Vector const& n0 = past_[0].nonlinear;
    sum_.noalias() = half.slope * f_start_;
    stage_ = y + (0.5 * h) * sum_;
    if (auto e = f.derivative(middle, stage_, slope_); e != Status::ok) return e;
    nonlinear_part(stage_, slope_, d1_);
    d1_ -= n0;
    stage_.noalias() += h * (half.difference[0] * d1_);
    if (auto e = f.derivative(middle, stage_, slope_); e != Status::ok) return e;
    nonlinear_part(stage_, slope_, d2_);
    d2_ -= n0;
    sum_.noalias() = w.slope * f_start_;
    stage_ = y + h * sum_;
    stage_.noalias() += (2.0 * h) * (w.difference[0] * d2_);
    if (auto e = f.derivative(s.end, stage_, slope_); e != Status::ok) return e;
    nonlinear_part(stage_, slope_, d3_);
    d3_ -= n0;
    d1_ += d2_;
    d2_ = 4.0 * d1_ - 3.0 * d3_;
    d3_ -= d1_;
    sum_.noalias() += w.difference[0] * d2_;
    sum_.noalias() += 4.0 * (w.difference[1] * d3_);
    y_new = y + h * sum_;
    error_.setZero();
    return Status::ok;
  }

  int n_, kinematic_;  // states; of them those with x' = another state
  JacobianData jacobian_;
  Eigen::MatrixXd linear_;  // rows of L that are not kinematic, columns of the states
  PastPoints<> past_;
  MatrixPhiFunctions phi_;
  std::vector<StepWeights> weights_;  // of h_, h_ / 2 ... and for the middle of a shortest single step
  Vector f_start_, f_end_, stage_, slope_, sum_, error_, d1_, d2_, d3_;
  double h_ = 0;   // [s]
  int level_ = 0;  // the step is h_ / 2^level_
  std::int64_t ticks_ = 0;
  std::int64_t since_ = 0;  // steps since L was renewed
  bool has_end_slope_ = false, planned_ = false;
};

}  // namespace rollerrig::integrate
