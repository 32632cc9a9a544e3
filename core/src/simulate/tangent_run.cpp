#include "rollerrig/simulate/tangent_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "rollerrig/integrate/integrator.hpp"
#include "rollerrig/simulate/recorded_rows.hpp"

namespace rollerrig {
namespace {

using Place = Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double move = 1e-8;        ///< of displacements in a difference to one side [m, rad]: round-off is 2e-14 ...
constexpr double deviation = 1e-7;   ///< ... and to both: contacts are 1e-4 m deep
constexpr double rate = 100.0;       ///< that turns a rate into a displacement as large [1/s]
constexpr double same_time = 1e-12;  ///< [s]
constexpr Place many = 12;         ///< columns; J costs as much as 16 evaluations, and is kept for a second correction
constexpr double left_out = 1e-4;  ///< of a tangent: a correction that is smaller is not made
constexpr int looked_at_every = 20;  ///< steps

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

void need_its_steps(Driver& run) {
  if (!run.started() || run.integrator().exponential_adams() == nullptr)
    throw std::invalid_argument("TangentRun: derivatives take the steps of exponential_adams, the run has others");
}

constexpr Place locked = -1, differenced = -2;

/// Of each column of a row its place among states and quadratures, where it is a displacement or rate of a body.
std::vector<Place> places_of(StateMap const& map, std::vector<int> const& columns) {
  std::vector<Place> places;
  for (int const column : columns) {
    auto const body = at(column) / body_columns, c = at(column) % body_columns;
    bool const is_motion = body < map.rate.size() && c < 12;
    Place place = !is_motion ? differenced : c < 6 ? map.coordinate[body][c] : map.rate[body][c - 6];
    if (is_motion && c == coord_pitch && map.angle[body] >= 0) place = map.states() + map.angle[body];
    places.push_back(place);
  }
  return places;
}

/// The backward difference of an order; k: steps ago.
template <class Value>
MatrixXd backward_difference(int order, Value const& value) {
  static constexpr std::array<std::array<double, 5>, 5> coefficient{
      {{1}, {1, -1}, {1, -2, 1}, {1, -3, 3, -1}, {1, -4, 6, -4, 1}}};
  auto const& c = coefficient[at(order)];
  MatrixXd sum = value(0);
  for (int k = 1; k <= order; ++k) sum += c[at(k)] * value(k);
  return sum;
}

}  // namespace

SlopesUnderContacts::SlopesUnderContacts(Model const& model) : model_{model}, evaluation_{model} {
  evaluation_.work.patches_given = true;
}

VectorXd SlopesUnderContacts::operator()(Dynamics const& other, double t, Inputs const& inputs) {
  auto& work = evaluation_.work;
  auto const& given = other.work();
  ForceAssembly<double> const forces(model_, inputs, evaluation_, work);
  for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
    work.motion[b].q = given.motion[b].q;
    work.motion[b].rate = given.motion[b].rate;
    update_motion(model_.bodies[b], work.motion[b]);
  }
  work.node = given.node;
  work.placed = given.placed;
  work.patches = given.patches;
  work.patch_count = given.patch_count;
  forces.place_track(t);
  if (work.curved)
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) forces.see_from_common(b);
  forces.accelerate(t);
  StateMap const& map = model_.map;
  VectorXd out(map.rates + map.nodes + map.angles + account_count);
  int const angles = map.rates + map.nodes;
  for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
    for (std::size_t c = 0; c < 6; ++c)
      if (map.rate[b][c] >= 0) out[map.rate[b][c] - map.coordinates] = work.acceleration[b][c];
    if (map.angle[b] >= 0) out[angles + map.angle[b]] = work.motion[b].rate[coord_pitch];
  }
  std::ranges::copy(work.node_rate, out.data() + map.rates);
  std::ranges::copy(work.power, out.data() + angles + map.angles);
  return out;
}

TangentRun::TangentRun(Driver& run, std::vector<ChangedRuns> changed, MatrixXd const& directions, std::vector<int> kept,
                       std::vector<double> breakpoints)
    : run_{run},
      changed_{std::move(changed)},
      kept_{std::move(kept)},
      direct_{places_of(run.plant().map(), kept_)},
      breakpoints_{std::move(breakpoints)},
      dynamics_{std::shared_ptr<Model const>(std::shared_ptr<void>{}, &run.plant().model())},  // the run's own
      jacobian_{dynamics_.sizes()},
      time_{run.time()},
      start_time_{run.time()},
      past_{MatrixXd{}, MatrixXd{}} {
  auto const [states, quadratures] = dynamics_.sizes();
  need_alike(run_, run_);
  need_its_steps(run_);
  for (ChangedRuns const& one : changed_) need_alike(run_, *one.above), need_alike(run_, *one.below);
  if (directions.rows() != states && directions.cols() > 0)
    throw std::invalid_argument("TangentRun: directions need one row per state");
  auto const numbers = static_cast<Place>(changed_.size()), columns = numbers + directions.cols();
  x_ = Eigen::Map<VectorXd const>(run.states(), states);
  z_ = VectorXd::Zero(quadratures);
  y_.setZero(states + quadratures, columns);
  for (Place i = 0; i < numbers; ++i) {
    auto const& [above, below, half_width, moves_contacts] = changed_[at(i)];
    y_.col(i).head(states) =
        (Eigen::Map<VectorXd const>(above->states(), states) - Eigen::Map<VectorXd const>(below->states(), states)) /
        (2.0 * half_width);
    bool const apart = moves_contacts || run_.system() != nullptr;
    under_contacts_.push_back(apart ? nullptr
                                    : std::make_unique<Pair>(SlopesUnderContacts(above->plant().model()),
                                                             SlopesUnderContacts(below->plant().model())));
  }
  if (directions.cols() > 0) y_.topRightCorner(states, directions.cols()) = directions;
  contraction_.setOnes(columns);
  weight_.setConstant(states, 1.0 / rate);
  weight_.head(dynamics_.kinematic_states()).setOnes();
  std::ranges::sort(breakpoints_);
}

Status TangentRun::advance(double t_stop) {
  need_its_steps(run_);  // it may have been started again
  run_.integrator().watch([this] { step(); });
  Status const status = run_.advance(t_stop, [this](double t, double const* x, double const* z) { keep(t, x, z); });
  run_.integrator().watch({});
  return status;
}

/// The changed drivers' sensors and controllers at this instant, in states that deviate by the tangents.
void TangentRun::reach_samples(VectorXd const& x, VectorXd const& z) {
  if (run_.system() == nullptr || std::exchange(reached_, true)) return;
  for (std::size_t i = 0; i < changed_.size(); ++i) {
    auto const tangent = y_.col(static_cast<Place>(i));
    for (auto const& [driver, width] : {std::pair{changed_[i].above, changed_[i].half_width},
                                        std::pair{changed_[i].below, -changed_[i].half_width}}) {
      VectorXd const moved = x + width * tangent.head(x.size()), quadratures = z + width * tangent.tail(z.size());
      driver->reach_sample(moved.data(), quadratures.data());
    }
  }
}

/// Their actuators, where a step begins at an instant.
void TangentRun::act_on_samples() {
  if (run_.system() == nullptr || changed_.empty()) return;
  if (!reached_ && changed_.front().above->next_sample() > time_ + same_time) return;
  reach_samples(x_, z_);
  for (ChangedRuns const& one : changed_) one.above->act_on_sample(), one.below->act_on_sample();
  reached_ = false;
}

/// The derivatives over the step that the run has just made.
void TangentRun::step() {
  double const end = run_.time(), h = end - time_;
  bool const at_jump = std::ranges::any_of(breakpoints_, [&](double t) { return std::abs(t - end) < same_time; });
  auto const& method = *run_.integrator().exponential_adams();
  auto const states = x_.size();
  act_on_samples();
  auto const remember = [this, states](MatrixXd const& nonlinear) {
    auto& last = past_.add();
    last.x = y_.topRows(states);
    last.nonlinear = nonlinear;
  };
  if (!std::exchange(joined_, true)) {
    MatrixXd const bending = rates(time_, x_, y_, Columns(at(y_.cols()), 1));
    slope_ = whole_slope(y_, bending);
    linear_ = method.linear();
    past_.clear();
    remember(bending - linear_ * y_.topRows(states));
    spacing_ = h;
  }
  fit_spacing(h);
  if (linear_ != method.linear()) {
    past_.add_linear(linear_ - method.linear());
    linear_ = method.linear();
  }
  VectorXd x_end(states);
  run_.sample_states(end, x_end.data(), z_.data());

  // integrate/exponential_adams.hpp; of fewer points a polynomial of lower order.
  auto const& weights = method.weights(h);
  int const known = std::min(past_.known(), 4);
  auto const past = [this](int k) -> MatrixXd const& { return past_[k].nonlinear; };
  MatrixXd sum = weights.slope * slope_;
  for (int m = 1; m < known; ++m) sum += weights.difference[at(m - 1)] * backward_difference(m, past);
  MatrixXd next = y_ + h * sum;
  double const late = at_jump ? std::nextafter(end, time_) : end;
  MatrixXd const predicted = next;
  MatrixXd nonlinear(linear_.rows(), next.cols());
  auto const size_of = [&](MatrixXd const& of) -> Eigen::RowVectorXd {
    return (weight_.asDiagonal() * of.topRows(states)).colwise().norm();
  };
  double const allowed = run_.system() == nullptr ? left_out : 0.1 * left_out;  // samples add up what is left out
  bool const look = known < 4 || ++since_look_ >= looked_at_every;
  Columns corrected(at(next.cols()), 1);  // those that are, in this round
  Eigen::RowVectorXd last;
  for (int round = 0; round < 2; ++round) {
    MatrixXd const bent = rates(late, x_end, next, corrected) - linear_ * next.topRows(states);
    for (Place i = 0; i < next.cols(); ++i)
      if (corrected[at(i)]) nonlinear.col(i) = bent.col(i);
    auto const with_new = [&](int k) -> MatrixXd const& { return k == 0 ? nonlinear : past(k - 1); };
    MatrixXd const better =
        predicted + h * (weights.difference[at(std::min(known, 3) - 1)] * backward_difference(known, with_new));
    Eigen::RowVectorXd const change = size_of(better - next), size = size_of(better);
    next = better;
    for (Place i = 0; i < next.cols(); ++i) {
      if (round == 1 && corrected[at(i)]) contraction_[i] = change[i] / std::max(last[i], 1e-300);
      corrected[at(i)] = look || contraction_[i] * change[i] > allowed * size[i];
    }
    if (std::ranges::none_of(corrected, std::identity{})) break;
    last = change;
  }
  if (look) since_look_ = 0;
  start_time_ = std::exchange(time_, end);
  start_.swap(y_), leave_.swap(slope_);
  y_ = next;
  slope_ = whole_slope(y_, nonlinear + linear_ * y_.topRows(states));
  remember(nonlinear);
  x_ = x_end;
  side_ = -side_;
  joined_ = !at_jump;
}

/// Points as far apart as the step is long: half as far and twice as far are found, else the last one is left.
void TangentRun::fit_spacing(double h) {
  for (; spacing_ > 1.4 * h && past_.enough(); spacing_ *= 0.5) past_.halve_step();
  for (; spacing_ < 0.7 * h && past_.known() == past_.most; spacing_ *= 2.0) past_.double_step();
  if (std::abs(spacing_ - h) < 1e-6 * h) return;
  auto const last = past_[0];
  past_.clear();
  past_.add() = last;
  spacing_ = h;
}

/// Of S and Z, from those of all but the kinematic states.
MatrixXd TangentRun::whole_slope(MatrixXd const& y, MatrixXd const& bending) const {
  MatrixXd slope(y.rows(), y.cols());
  auto const kinematic = static_cast<Place>(dynamics_.kinematic_states());
  for (Place i = 0; i < kinematic; ++i) slope.row(i) = y.row(dynamics_.velocity_column(static_cast<int>(i)));
  slope.bottomRows(y.rows() - kinematic) = bending;
  return slope;
}

/// Of all but the kinematic states, then of the quadratures.
VectorXd TangentRun::bending_slope(Driver& of, Dynamics& by, double t, VectorXd const& x) {
  VectorXd slope(y_.rows());
  by.derivative(t, x.data(), slope.data(), slope.data() + x.size(), of.inputs());
  return slope.tail(y_.rows() - dynamics_.kinematic_states());
}

/// How much of a tangent a difference by a number may follow, by what bodies are displaced.
double TangentRun::share_along(std::size_t number, Eigen::Ref<VectorXd const> s) const {
  double const moves = changed_[number].half_width * s.head(dynamics_.kinematic_states()).lpNorm<Eigen::Infinity>();
  return moves > deviation ? deviation / moves : 1.0;
}

/// J s by a difference to one side.
VectorXd TangentRun::along(double t, VectorXd const& x, Eigen::Ref<VectorXd const> s, VectorXd const& here) {
  double const largest = s.cwiseProduct(weight_).lpNorm<Eigen::Infinity>();
  if (!(largest > 0.0)) return VectorXd::Zero(here.size());
  double const part = side_ * move / largest;
  return (bending_slope(run_, dynamics_, t, x + part * s) - here) / part;
}

/// J S + df/dp and dg/dx S + dg/dp, of all but the kinematic states; of some columns.
MatrixXd TangentRun::rates(double t, VectorXd const& x, MatrixXd const& y, Columns const& wanted) {
  VectorXd const here = bending_slope(run_, run_.plant(), t, x);
  MatrixXd out = MatrixXd::Zero(here.size(), y.cols());
  bool const exact = y.cols() >= many;
  if (exact) {
    if (std::exchange(jacobian_time_, t) != t) dynamics_.jacobian(t, x.data(), jacobian_, run_.inputs());
    auto const moving = x.size() - dynamics_.kinematic_states();
    out.topRows(moving).noalias() = jacobian_.a.bottomRows(moving) * y.topRows(x.size());
    out.bottomRows(jacobian_.g.rows()).noalias() = jacobian_.g * y.topRows(x.size());
  }
  for (Place i = 0; i < y.cols(); ++i) {
    if (!wanted[at(i)]) continue;
    auto const s = y.col(i).head(x.size());
    bool const number = i < static_cast<Place>(changed_.size());
    bool const at_once = number && under_contacts_[at(i)] == nullptr;
    double const width = number ? changed_[at(i)].half_width : 0.0;
    double const share = at_once ? share_along(at(i), s) : 1.0;
    if (!exact && (!at_once || share < 1.0)) out.col(i) = along(t, x, s, here);
    if (!number) continue;
    if (!at_once) {
      auto& [above, below] = *under_contacts_[at(i)];
      VectorXd const slope = (side_ > 0.0 ? above : below)(run_.plant(), t, run_.inputs());
      out.col(i) += (slope - here) / (side_ * width);
      continue;
    }
    auto const slope = [&](Driver& changed, double along) {
      return bending_slope(changed, changed.plant(), t, x + (along * share) * s);
    };
    out.col(i) = share < 1.0 ? VectorXd((1.0 - share) * out.col(i)) : VectorXd::Zero(here.size());
    out.col(i) += (slope(*changed_[at(i)].above, width) - slope(*changed_[at(i)].below, -width)) / (2.0 * width);
  }
  return out;
}

/// S and Z within the last step, on the Hermite polynomial through its ends.
MatrixXd TangentRun::tangents_at(double t) const {
  double const h = time_ - start_time_;
  if (t >= time_ - same_time || !(h > 0.0)) return y_;
  double const u = (t - start_time_) / h, v = 1.0 - u;
  return (v * v * (1.0 + 2.0 * u)) * start_ + (u * u * (1.0 + 2.0 * v)) * y_ + (h * u * v) * (v * leave_ - u * slope_);
}

void TangentRun::keep(double t, double const* x, double const* z) {
  if (kept_.empty()) return;
  reach_samples(x_, z_);
  std::vector<double> row(at(run_.width()));
  run_.record(t, x, z, row.data());
  Output& output = outputs_.emplace_back();
  output.t = t;
  for (int const column : kept_) output.row.push_back(row[at(column)]);
  differentiate(t, x, z, output);
}

void TangentRun::differentiate(double t, double const* x, double const* z, Output& output) {
  MatrixXd const y = tangents_at(t);
  auto const states = x_.size();
  VectorXd const x_now = Eigen::Map<VectorXd const>(x, states), z_now = Eigen::Map<VectorXd const>(z, z_.size());
  VectorXd upper(run_.width()), lower(run_.width()), found(run_.width());
  bool const all_direct = std::ranges::find(direct_, differenced) == direct_.end();
  for (std::size_t i = 0; i < changed_.size(); ++i) {
    auto const& [above, below, half_width, moves_contacts] = changed_[i];
    auto const tangent = y.col(static_cast<Place>(i));
    auto const difference = [&](Driver& plus, Driver& minus, double along, double by) {
      VectorXd moved = x_now + along * tangent.head(states), quadratures = z_now + along * tangent.tail(z_.size());
      plus.record(t, moved.data(), quadratures.data(), upper.data());
      moved = x_now - along * tangent.head(states), quadratures = z_now - along * tangent.tail(z_.size());
      minus.record(t, moved.data(), quadratures.data(), lower.data());
      return VectorXd((upper - lower) / (2.0 * by));
    };
    // A number beside the contacts is differenced in the state of the run.
    double const share = run_.system() != nullptr ? 1.0 : moves_contacts ? share_along(i, tangent.head(states)) : 0.0;
    double const largest = tangent.head(dynamics_.kinematic_states()).lpNorm<Eigen::Infinity>();
    if (!all_direct) found = difference(*above, *below, share * half_width, half_width);
    if (!all_direct && share < 1.0 && largest > 0.0)
      found += (1.0 - share) * difference(run_, run_, deviation / largest, deviation / largest);
    for (std::size_t k = 0; k < kept_.size(); ++k)
      output.derivatives.push_back(direct_[k] >= 0        ? tangent[direct_[k]]
                                   : direct_[k] == locked ? 0.0
                                                          : found[kept_[k]]);
  }
}

}  // namespace rollerrig
