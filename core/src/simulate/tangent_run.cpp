#include "rollerrig/simulate/tangent_run.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace rollerrig {
namespace {

using Place = Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double deviation = 1e-7;     ///< of displacements in a difference [m, rad]: contacts are 1e-4 m deep
constexpr double rate = 100.0;         ///< that turns the error of a displacement into that of its rate [1/s]
constexpr double shortest = 1e-12;     ///< no time is told apart from another within it [s]
constexpr double first_length = 1e-3;  ///< of a step; it is halved as often as it needs [s]
constexpr int most_halvings = 10;
constexpr double negligible = 1e-12;  ///< change of displacements that no step need resolve [m, rad]

void need_alike(Driver const& run, Driver const& changed) {
  auto const of = [](Driver const& d) {
    return std::tuple{d.plant().sizes().states, d.plant().sizes().quadratures, d.width()};
  };
  if (!run.started() || !changed.started())
    throw std::invalid_argument("TangentRun: a simulation has not been started");
  bool const in_step = run.system() == nullptr || changed.system() == nullptr ||
                       run.system()->setup().step == changed.system()->setup().step;
  if (of(run) != of(changed) || (run.system() == nullptr) != (changed.system() == nullptr) || !in_step)
    throw std::invalid_argument("TangentRun: the changed simulations have other states, outputs or sampling steps");
}

}  // namespace

TangentRun::TangentRun(Driver& run, std::vector<ChangedRuns> changed, MatrixXd const& directions, double tolerance,
                       std::vector<double> breakpoints)
    : run_{run},
      changed_{std::move(changed)},
      tolerance_{tolerance},
      breakpoints_{std::move(breakpoints)},
      dynamics_{std::shared_ptr<Model const>(std::shared_ptr<void>{}, &run.plant().model())},  // the run's own
      time_{run.time()},
      length_{first_length} {
  auto const [states, quadratures] = dynamics_.sizes();
  need_alike(run_, run_);
  for (ChangedRuns const& one : changed_) need_alike(run_, *one.above), need_alike(run_, *one.below);
  if (directions.rows() != states && directions.cols() > 0)
    throw std::invalid_argument("TangentRun: directions need one row per state");
  auto const numbers = static_cast<Place>(changed_.size()), columns = numbers + directions.cols();
  x_ = Eigen::Map<VectorXd const>(run.states(), states);
  z_ = VectorXd::Zero(quadratures);
  s_.setZero(states, columns);
  z_tangents_.setZero(quadratures, columns);
  for (Place i = 0; i < numbers; ++i) {
    auto const& [above, below, half_width] = changed_[static_cast<std::size_t>(i)];
    s_.col(i) =
        (Eigen::Map<VectorXd const>(above->states(), states) - Eigen::Map<VectorXd const>(below->states(), states)) /
        (2.0 * half_width);
  }
  if (directions.cols() > 0) s_.rightCols(directions.cols()) = directions;
  largest_.setZero(columns);
  for (Place i = 0; i < numbers; ++i) largest_[i] = negligible / changed_[static_cast<std::size_t>(i)].half_width;
  weight_.setConstant(states, 1.0 / rate);
  weight_.head(dynamics_.kinematic_states()).setOnes();
  std::ranges::sort(breakpoints_);
}

Status TangentRun::advance(double t_stop) {
  double const tolerance = 1e-9 * shortest;
  while (true) {
    double const end = next_end(t_stop);
    if (end > t_stop + tolerance || end <= time_ + tolerance) return Status::ok;
    if (Status const status = step(end); status != Status::ok || time_ < end) return status;
  }
}

double TangentRun::next_end(double t_stop) const {
  if (run_.system() != nullptr) return run_.next_sample() + run_.system()->setup().step;
  auto const corner = std::ranges::upper_bound(breakpoints_, time_ + shortest);
  double const limit = corner != breakpoints_.end() ? std::min(*corner, t_stop) : t_stop;
  double const rest = limit - time_, steps = std::ceil(rest / length_ * (1.0 - 1e-9));
  return steps > 1.0 ? time_ + rest / steps : limit;
}

/// The changed drivers' sensors and controllers at this instant, in states that deviate by the tangents.
void TangentRun::reach_samples() {
  for (std::size_t i = 0; i < changed_.size(); ++i) {
    auto const& [above, below, half_width] = changed_[i];
    auto const column = static_cast<Place>(i);
    for (auto const& [driver, width] : {std::pair{above, half_width}, std::pair{below, -half_width}}) {
      VectorXd const x = x_ + width * s_.col(column), z = z_ + width * z_tangents_.col(column);
      driver->reach_sample(x.data(), z.data());
    }
  }
}

/// The derivatives over a step of the run with sampled blocks, or over as long a time as one step of theirs serves.
Status TangentRun::step(double end) {
  bool const sampled = run_.system() != nullptr;
  if (sampled) reach_samples();
  auto const keep = [this](double t, double const* x, double const* z) {
    Output& output = outputs_.emplace_back();
    output.t = t;
    output.x = Eigen::Map<VectorXd const>(x, x_.size());
    output.z = Eigen::Map<VectorXd const>(z, z_.size());
    output.row.resize(width());
    run_.record(t, x, z, output.row.data());
  };
  double const middle_time = 0.5 * (time_ + end);
  VectorXd x_middle(x_.size()), x_end(x_.size());
  Status status = Status::ok;
  if (!sampled) {
    status = run_.advance(middle_time, keep);
    if (run_.time() < middle_time) return status;  // the run has ended
    run_.sample_states(middle_time, x_middle.data(), nullptr);
  }
  if (status == Status::ok) status = run_.advance(end, keep);
  if (run_.time() < end - shortest) return status;
  run_.sample_states(end, x_end.data(), z_.data());
  if (sampled) {
    differentiate_outputs(0.5 * (time_ + end));
    for (auto const& [above, below, width] : changed_) above->act_on_sample(), below->act_on_sample();
  }
  if (!std::exchange(joined_, !sampled)) start_ = look(time_, x_);  // sampled inputs have another slope from here on
  Point last = look(std::nextafter(end, time_), x_end);
  last.t = end;
  Point const middle = sampled ? between(start_, last) : look(middle_time, x_middle);
  knots_.clear();
  solve(start_, middle, last, most_halvings);
  x_ = x_end;
  time_ = end;
  if (sampled && !outputs_.empty() && outputs_.back().derivatives.empty()) reach_samples();  // the run's last instant
  differentiate_outputs(end);
  if (std::ranges::binary_search(breakpoints_, end)) joined_ = false, length_ = first_length;
  if (joined_) start_ = std::move(last);
  return status;
}

/// From one point to another with a third between them: in two steps, or, where one step of both lengths shows that they are too
/// long, each half by itself. No evaluation is lost.
void TangentRun::solve(Point const& from, Point const& middle, Point const& to, int halvings) {
  Point const first = between(from, middle), second = between(middle, to);
  Tangents const start{s_, z_tangents_}, half = one_step(from, first, middle, start);
  Tangents const fine = one_step(middle, second, to, half), coarse = one_step(from, middle, to, start);
  double error = 0.0;
  for (Place i = 0; i < s_.cols(); ++i) {
    double const size = fine.s.col(i).cwiseProduct(weight_).lpNorm<Eigen::Infinity>();
    largest_[i] = std::max(largest_[i], size);
    double const off = (fine.s.col(i) - coarse.s.col(i)).cwiseProduct(weight_).lpNorm<Eigen::Infinity>() / 15.0;
    if (largest_[i] > 0.0) error = std::max(error, off / (tolerance_ * largest_[i]));
  }
  if (error > 1.0 && halvings > 0) {
    solve(from, first, middle, halvings - 1);
    solve(middle, second, to, halvings - 1);
    return;
  }
  auto const keep = [this](Point const& at, Tangents const& now) {
    knots_.push_back({at.t, now, {at.j.a * now.s + at.by_number, at.j.g * now.s + at.power}});
  };
  keep(from, start), keep(middle, half), keep(to, fine);
  s_ = fine.s;
  z_tangents_ = fine.z;
  length_ = (to.t - from.t) * std::clamp(0.8 * std::pow(std::max(error, 1e-10), -0.2), 0.5, 2.0);
}

/// Half way between two points, on the Hermite polynomial through them.
TangentRun::Point TangentRun::between(Point const& from, Point const& to) {
  double const h = to.t - from.t;
  return look(0.5 * (from.t + to.t), 0.5 * (from.x + to.x) + (h / 8.0) * (from.slope - to.slope));
}

TangentRun::Point TangentRun::look(double t, VectorXd const& x) {
  auto const sizes = dynamics_.sizes();
  Point point{t,
              x,
              VectorXd(sizes.states),
              JacobianData(sizes),
              MatrixXd::Zero(sizes.states, s_.cols()),
              MatrixXd::Zero(sizes.quadratures, s_.cols())};
  VectorXd z_dot(sizes.quadratures), slope(sizes.states), moved(sizes.states);
  dynamics_.jacobian(t, x.data(), point.j, run_.inputs());
  dynamics_.derivative(t, x.data(), point.slope.data(), nullptr, run_.inputs());
  for (std::size_t i = 0; i < changed_.size(); ++i) {
    auto const& [above, below, half_width] = changed_[i];
    auto by_number = point.by_number.col(static_cast<Place>(i));
    auto power = point.power.col(static_cast<Place>(i));
    // Along with the state: a roller of another radius that turns as before would slip.
    VectorXd const along = share_along(i) * s_.col(static_cast<Place>(i));
    moved = x + half_width * along;
    above->plant().derivative(t, moved.data(), by_number.data(), power.data(), above->inputs());
    moved = x - half_width * along;
    below->plant().derivative(t, moved.data(), slope.data(), z_dot.data(), below->inputs());
    by_number = (by_number - slope) / (2.0 * half_width) - point.j.a * along;
    power = (power - z_dot) / (2.0 * half_width) - point.j.g * along;
  }
  return point;
}

/// How much of S a difference by a number may follow.
double TangentRun::share_along(std::size_t number) const {
  auto const s = s_.col(static_cast<Place>(number));
  double const moves = changed_[number].half_width * s.head(dynamics_.kinematic_states()).lpNorm<Eigen::Infinity>();
  return moves > deviation ? deviation / moves : 1.0;
}

TangentRun::Tangents TangentRun::one_step(Point const& from, Point const& middle, Point const& to,
                                          Tangents const& start) const {
  double const h = to.t - from.t;
  MatrixXd const &a1 = to.j.a, &am = middle.j.a;
  MatrixXd const f0 = from.j.a * start.s + from.by_number;
  MatrixXd matrix = (h * h / 12.0) * (am * a1) - (h / 6.0) * a1 - (h / 3.0) * am;
  matrix.diagonal().array() += 1.0;
  MatrixXd const known = 0.5 * start.s + (h / 8.0) * (f0 - to.by_number);  // of the middle
  MatrixXd right = start.s + (h / 6.0) * (f0 + to.by_number);
  right += (2.0 * h / 3.0) * (am * known + middle.by_number);
  MatrixXd const s1 = matrix.partialPivLu().solve(right);
  MatrixXd const s_middle = known + 0.5 * s1 - (h / 8.0) * (a1 * s1);
  MatrixXd const z1 = start.z + (h / 6.0) * (from.j.g * start.s + from.power + to.j.g * s1 + to.power) +
                      (2.0 * h / 3.0) * (middle.j.g * s_middle + middle.power);
  return {s1, z1};
}

/// S and Z within the last step, on the Hermite polynomials through its knots.
TangentRun::Tangents TangentRun::tangents_at(double t) const {
  auto const next = std::ranges::find_if(knots_, [t](Knot const& knot) { return knot.t >= t; });
  if (next == knots_.end()) return {s_, z_tangents_};
  if (next == knots_.begin()) return next->now;
  Knot const &a = *(next - 1), &b = *next;
  double const h = b.t - a.t, u = (t - a.t) / h, v = 1.0 - u;
  auto const hermite = [&](MatrixXd const& from, MatrixXd const& to, MatrixXd const& leaving, MatrixXd const& coming) {
    return MatrixXd((v * v * (1.0 + 2.0 * u)) * from + (u * u * (1.0 + 2.0 * v)) * to +
                    (h * u * v) * (v * leaving - u * coming));
  };
  return {hermite(a.now.s, b.now.s, a.rate.s, b.rate.s), hermite(a.now.z, b.now.z, a.rate.z, b.rate.z)};
}

void TangentRun::differentiate_outputs(double until) {
  for (Output& output : outputs_)
    if (output.derivatives.empty() && output.t < until + shortest) differentiate(output, tangents_at(output.t));
}

void TangentRun::differentiate(Output& output, Tangents const& tangents) {
  auto const columns = static_cast<Place>(width());
  output.derivatives.resize(width() * changed_.size());
  VectorXd upper(columns), lower(columns);
  for (std::size_t i = 0; i < changed_.size(); ++i) {
    auto const& [above, below, half_width] = changed_[i];
    auto const s = tangents.s.col(static_cast<Place>(i)), z = tangents.z.col(static_cast<Place>(i));
    auto const difference = [&](Driver& plus, Driver& minus, double along, double by) {
      VectorXd x = output.x + along * s, quadratures = output.z + along * z;
      plus.record(output.t, x.data(), quadratures.data(), upper.data());
      x = output.x - along * s, quadratures = output.z - along * z;
      minus.record(output.t, x.data(), quadratures.data(), lower.data());
      return VectorXd((upper - lower) / (2.0 * by));
    };
    double const share = run_.system() != nullptr ? 1.0 : share_along(i);
    Eigen::Map<VectorXd> out(output.derivatives.data() + i * width(), columns);
    out = difference(*above, *below, share * half_width, half_width);
    if (share < 1.0) out += (1.0 - share) * difference(run_, run_, share * half_width, share * half_width);
  }
}

}  // namespace rollerrig
