// integrate/integrator.hpp - marches a system through time.
//
//   DifferentialEquation + Options -> steps -> outputs on a grid, statistics, a Status
//
// The steps depend on the system and the options alone.  Output times are read off the dense output
// and advance(t) runs on to the first step end at or behind t, so neither the output grid nor the way
// a caller slices a run (progress, interruption) changes a single bit of it.
//
// Everything is allocated by the constructor; stepping neither allocates nor throws.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "rollerrig/integrate/dormand_prince.hpp"
#include "rollerrig/integrate/exponential_adams.hpp"
#include "rollerrig/integrate/exponential_runge_kutta_4.hpp"
#include "rollerrig/integrate/rodas4.hpp"
#include "rollerrig/integrate/step_control.hpp"

namespace rollerrig::integrate {

template <DifferentialEquation System>
class Integrator {
 public:
  /// The system must outlive the integrator.  Throws std::invalid_argument for impossible options.
  Integrator(System& system, Options options)
      : options_{std::move(options)},
        f_{system},
        n_{f_.sizes().states},
        method_{make_method(options_.method, f_)},
        controller_{std::visit([](auto const& m) { return controller_for(m); }, method_)} {
    check_options(options_, n_);
    absolute_.setConstant(n_, options_.absolute_tolerance.front());
    if (options_.absolute_tolerance.size() > 1) std::copy_n(options_.absolute_tolerance.data(), n_, absolute_.data());
    std::sort(options_.breakpoints.begin(), options_.breakpoints.end());
    for (Vector* v : {&y_, &y_old_, &y_new_, &y_out_}) v->setZero(n_ + f_.sizes().quadratures);
  }

  /// Begins a run, with quadratures of zero; a finished or failed integrator may be started again.
  Status start(double t0, double const* x0) {
    t0_ = t_old_ = t_ = t0;
    std::copy_n(x0, n_, y_.data());
    y_.tail(y_.size() - n_).setZero();
    y_old_ = y_;
    f_.statistics = {};
    grid_steps_ = outputs_ = 0;
    crawled_ = 0;
    next_breakpoint_ = 0;
    h_ = 0;
    hold_ = std::numeric_limits<double>::infinity();
    prepared_ = false;
    pending_output_ = true;
    restart();
    skip_passed_breakpoints();
    status_ = y_.allFinite() ? accept() : Status::not_finite;
    return status_;
  }

  /// Steps until time() >= min(t_stop, final time), and shows the observer each output time up to
  /// t_stop: observer(t, x, z).  A Status that is not ok is final.
  template <class Observer>
  Status advance(double t_stop, Observer&& observer) {
    t_stop = std::min(t_stop, options_.final_time);
    serve(t_stop, observer);
    while (status_ == Status::ok && t_ < t_stop) {
      double const start = t_;
      status_ = std::visit([this](auto& m) { return step(m); }, method_);
      if (watcher_ && t_ > start) watcher_();
      serve(t_stop, observer);
    }
    return status_;
  }

  Status advance(double t_stop) {
    return advance(t_stop, [](double, double const*, double const*) {});
  }

  /// A further time that no step crosses, beside the breakpoints; until the next call.
  void hold_until(double t) { hold_ = t; }
  bool is_held() const { return std::isfinite(hold_); }

  /// Called after each step that is kept, before its outputs are shown; empty: nobody.
  void watch(std::function<void()> watcher) { watcher_ = std::move(watcher); }
  ExponentialAdams const* exponential_adams() const { return std::get_if<ExponentialAdams>(&method_); }

  /// The first half of the next step, which looks at the system as it is now: its inputs may then change for the rest.
  Status prepare() {
    if (prepared_) return Status::ok;
    Status const status = std::visit([this](auto& m) { return m.prepare(f_, t_, y_); }, method_);
    prepared_ = status == Status::ok;
    return status;
  }

  /// The system has changed: its slope at time() counts no more.
  void drop_slope() {
    prepared_ = false;
    std::visit([](auto& m) { m.restart(); }, method_);
  }

  /// Back into the last step, step_start() <= t <= time(), along its dense output: the system changes from t on.
  void rewind(double t) {
    interpolate(t);
    y_ = y_out_;
    if (t_ > t && next_breakpoint_ > 0 && options_.breakpoints[next_breakpoint_ - 1] == t_) --next_breakpoint_;
    if (t0_ + static_cast<double>(grid_steps_) * options_.step > t + 1e-9 * options_.step) --grid_steps_;
    t_ = t;
    prepared_ = false;
    restart();
  }

  double time() const { return t_; }                            ///< [s] end of the last accepted step
  double step_start() const { return t_old_; }                  ///< [s] start of the last accepted step
  double const* states() const { return y_.data(); }            ///< x at time()
  double const* quadratures() const { return y_.data() + n_; }  ///< z at time()
  Status status() const { return status_; }
  Statistics const& statistics() const { return f_.statistics; }
  Options const& options() const { return options_; }

  /// Dense output inside the last step, step_start() <= t <= time().  After a step that failed only t = time() is left.
  void sample(double t, double* x, double* z) {
    interpolate(t);
    std::copy_n(y_out_.data(), n_, x);
    std::copy_n(y_out_.data() + n_, y_out_.size() - n_, z);
  }

  template <class Archive>
  void state(Archive& archive) {
    archive(f_.statistics, method_, controller_, y_, y_old_, y_new_, y_out_, t0_, t_, t_old_, h_, step_length_,
            planned_at_, pending_output_, prepared_);
    archive.within(status_, Status::ok, Status::controller_failed);
    archive.time(options_.final_time);
    archive.time(hold_);
    for (std::int64_t* count : {&grid_steps_, &outputs_}) archive.within(*count, std::int64_t{0}, most_counted);
    archive.within(next_breakpoint_, std::size_t{0}, options_.breakpoints.size());
    archive.within(crawled_, 0, longest_crawl);
    if constexpr (Archive::reading) archive.need(status_ != Status::ok || moves_on());
  }

 private:
  static constexpr std::int64_t most_counted = std::int64_t{1} << 60;
  /// Whether times stand in their order and on the grid of steps: what was read may have been written by anyone.
  bool moves_on() const {
    double const round_off = 1e-6 * options_.step;
    auto const near = [&](double from, double length) {
      return t_ >= from - round_off && t_ <= from + length + round_off;
    };
    auto const* adams = std::get_if<ExponentialAdams>(&method_);
    bool const on_grid =
        adams != nullptr
            ? !adams->planned() || (near(grid_time(*adams, 0), 0.0) && adams->tick() <= options_.step)
            : options_.step == 0 || near(t0_ + static_cast<double>(grid_steps_) * options_.step, options_.step);
    return t0_ <= t_old_ && t_old_ <= t_ && t_ < options_.final_time + minimum_step() && hold_ >= t_ && h_ >= 0 &&
           on_grid && (!has_breakpoint() || options_.breakpoints[next_breakpoint_] > t_);
  }
  using AnyMethod = std::variant<ExponentialRungeKutta4, ExponentialAdams, DormandPrince, Rodas4>;
  static constexpr double crawling_step = 1e-9;  ///< [s] thousands of times below any step that a vehicle asks for ...
  static constexpr int longest_crawl = 1'000;    ///< ... so many of them in a row: the run will not end
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  static AnyMethod make_method(Method method, Evaluator<System> const& f) {
    if (method == Method::rk4 || method == Method::exponential_rk4)
      return ExponentialRungeKutta4(f, method == Method::exponential_rk4);
    if (method == Method::exponential_adams) return ExponentialAdams(f);
    if (method == Method::dormand_prince) return DormandPrince(f);
    return Rodas4(f);
  }

  template <class M>
  static StepController controller_for(M const&) {
    return StepController(M::error_order, M::implicit);
  }

  // ------------------------------------------------------------------------------- stepping

  /// The shortest step that still moves time: 16 units in the last place, at least those of 1 s.
  double minimum_step() const { return 16 * epsilon * std::max(1.0, std::abs(t_)); }

  bool has_breakpoint() const { return next_breakpoint_ < options_.breakpoints.size(); }

  /// The next time that a step must not cross.
  double limit() const {
    double const end = std::min(hold_, options_.final_time);
    return has_breakpoint() ? std::min(options_.breakpoints[next_breakpoint_], end) : end;
  }

  void skip_passed_breakpoints() {
    while (has_breakpoint() && options_.breakpoints[next_breakpoint_] <= t_ + minimum_step()) ++next_breakpoint_;
  }

  void restart() {
    controller_.restart();
    if (options_.step == 0) h_ = 0;  // 0: guess anew
    std::visit([](auto& m) { m.restart(); }, method_);
  }

  template <class M>
  Status step(M& method) {
    if (auto e = prepare(); e != Status::ok) return e;
    prepared_ = false;
    Status status;
    if constexpr (std::is_same_v<M, ExponentialAdams>)
      status = grid_step(method);
    else
      status = options_.step > 0 ? fixed_step(method) : adaptive_step(method);
    return status == Status::ok ? accept() : status;
  }

  Status accept() { return f_.system().accept(t_, y_.data()); }

  /// From grid point to grid point t0 + k step; a limit in between splits the step.
  template <class M>
  Status fixed_step(M& method) {
    if (budget_spent()) return Status::too_many_steps;
    double const h = options_.step;
    double const tolerance = 1e-9 * h;  // grid points and limits this close are one
    double const grid = t0_ + static_cast<double>(grid_steps_ + 1) * h;
    bool const whole = std::abs(t_ - (t0_ + static_cast<double>(grid_steps_) * h)) <= tolerance;
    bool const at_limit = limit() <= grid + tolerance;
    double const end = at_limit ? limit() : grid;
    double const length = whole && std::abs(end - grid) <= tolerance ? h : end - t_;

    if (auto e = method.attempt(f_, make_step(length, end), y_, y_new_); e != Status::ok) return e;
    if (!y_new_.allFinite()) return Status::not_finite;
    if (end >= grid - tolerance) ++grid_steps_;
    commit(length, end);
    return Status::ok;
  }

  template <class M>
  Status adaptive_step(M& method) {
    if (h_ == 0) h_ = first_step(method);
    while (true) {
      if (budget_spent()) return Status::too_many_steps;
      double const wanted = std::min(h_, options_.maximum_step);
      double const rest = limit() - t_;
      // A limit within 1 % is hit; one within two steps is reached in two equal ones.
      bool const last = rest <= std::min(1.01 * wanted, options_.maximum_step);
      double const h = last ? rest : std::min(wanted, 0.5 * rest);
      double const end = last ? limit() : t_ + h;

      Status status = method.attempt(f_, make_step(h, end), y_, y_new_);
      double error = 0;
      if (status == Status::ok) {
        error = error_norm(method.error(), y_, y_new_, absolute_, options_.relative_tolerance);
        if (!std::isfinite(error) || !y_new_.allFinite()) status = Status::not_finite;
      }
      if (status == Status::ok && error <= 1) {
        h_ = controller_.accepted(h, error);
        commit(h, end);
        crawled_ = h < crawling_step ? crawled_ + 1 : 0;
        return crawled_ < longest_crawl ? Status::ok : Status::step_too_small;
      }
      ++f_.statistics.rejected_steps;
      bool const failed = status != Status::ok;
      h_ = failed ? controller_.failed(h) : controller_.rejected(h, error);
      if (h_ < minimum_step()) return failed ? status : Status::step_too_small;
    }
  }

  /// Steps of a method with its own grid: a whole number of its steps, none longer than the option, reaches the next limit.
  Status grid_step(ExponentialAdams& method) {
    double const tolerance = 1e-9 * options_.step;
    while (true) {
      if (budget_spent()) return Status::too_many_steps;
      if (!method.planned() || crawls(method) || grid_time(method, method.step_ticks()) > limit() + tolerance)
        if (auto e = plan(method); e != Status::ok) return e;
      double const grid = grid_time(method, method.step_ticks());
      double const end = std::abs(grid - limit()) <= tolerance ? limit() : grid;
      double const h = static_cast<double>(method.step_ticks()) * method.tick();
      auto const norm = [this](Vector const& e, Vector const& y, Vector const& y_new) {
        return error_norm(e, y, y_new, absolute_, options_.relative_tolerance);
      };
      Status status = method.attempt(f_, make_step(h, end), y_, y_new_, norm);
      double const error = norm(method.error(), y_, y_new_);
      if (status == Status::ok && (!std::isfinite(error) || !y_new_.allFinite())) status = Status::not_finite;
      if (status == Status::ok && (error <= 1 || !method.can_halve())) {
        if (error > 1) count_coarse(error);
        Status const accepted = method.accept(f_, end, y_new_, error);
        commit(h, end);
        return accepted;
      }
      ++f_.statistics.rejected_steps;
      if (status == Status::ok && method.stale()) {
        if (auto e = method.renew(f_, t_, y_); e != Status::ok) return e;
        continue;
      }
      if (!method.can_halve()) return status;
      method.halve();
    }
  }

  void count_coarse(double error) {
    ++f_.statistics.coarse_steps;
    f_.statistics.largest_error = std::max(f_.statistics.largest_error, error);
  }

  /// Planned for a limit that came at once: with such steps it would never reach the present one.
  bool crawls(ExponentialAdams const& method) const {
    return 1e5 * method.tick() < std::min(options_.step, limit() - t_);
  }

  double grid_time(ExponentialAdams const& method, std::int64_t ticks) const {
    return planned_at_ + static_cast<double>(method.ticks() + ticks) * method.tick();
  }

  Status plan(ExponentialAdams& method) {
    double const rest = limit() - t_;
    double const h = std::isfinite(rest) ? rest / std::ceil(rest / options_.step * (1 - 1e-9)) : options_.step;
    planned_at_ = t_;
    ++f_.statistics.factorisations;
    return method.plan(f_, t_, y_, h);
  }

  bool budget_spent() const { return f_.statistics.steps + f_.statistics.rejected_steps >= options_.max_steps; }

  Step make_step(double h, double end) const {
    bool const at_breakpoint = has_breakpoint() && end == options_.breakpoints[next_breakpoint_];
    return {t_, h, at_breakpoint ? std::nextafter(end, t_) : end};
  }

  void commit(double h, double end) {
    y_old_.swap(y_);
    y_.swap(y_new_);
    t_old_ = t_;
    t_ = end;
    step_length_ = h;
    pending_output_ = true;
    auto& s = f_.statistics;
    ++s.steps;
    s.smallest_step = std::min(s.smallest_step, h);
    s.largest_step = std::max(s.largest_step, h);
    if (has_breakpoint() && t_ >= options_.breakpoints[next_breakpoint_]) {
      skip_passed_breakpoints();
      restart();
    }
  }

  /// Hairer, Norsett, Wanner I, II.4: a step whose explicit Euler error is about 1 % of the tolerance.
  template <class M>
  double first_step(M& method) {
    if (options_.initial_step > 0) return options_.initial_step;
    auto const norm = [this](auto const& v) { return error_norm(v, y_, y_, absolute_, options_.relative_tolerance); };
    Vector const& slope = method.slope();
    double const d0 = norm(y_.head(n_));
    double const d1 = norm(slope.head(n_));
    double h0 = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1;
    h0 = std::min({h0, options_.maximum_step, limit() - t_});

    y_new_ = y_ + h0 * slope;
    if (f_.derivative(t_ + h0, y_new_, y_out_) != Status::ok) return h0;
    y_out_ -= slope;
    double const largest = std::max(d1, norm(y_out_.head(n_)) / h0);
    double const h1 = largest <= 1e-15 ? std::max(1e-6, 1e-3 * h0) : std::pow(0.01 / largest, 1.0 / (M::order + 1));
    double const h = std::min(100 * h0, h1);
    return std::isfinite(h) ? std::max(h, 2 * minimum_step()) : h0;
  }

  // ------------------------------------------------------------------------------- output

  double round_off(double t) const { return 4 * epsilon * std::max(std::abs(t), std::abs(t_)); }

  void interpolate(double t) {
    if (t >= t_ - round_off(t)) {
      y_out_ = y_;
    } else if (t <= t_old_) {
      y_out_ = y_old_;
    } else {
      double const theta = (t - t_old_) / step_length_;
      std::visit([&](auto& m) { m.interpolate(theta, step_length_, y_old_, y_, y_out_); }, method_);
    }
  }

  /// Shows the outputs that lie in the last step and not behind t_stop.
  template <class Observer>
  void serve(double t_stop, Observer& observer) {
    if (options_.output_step == 0) {
      if (std::exchange(pending_output_, false)) observer(t_, y_.data(), y_.data() + n_);
      return;
    }
    double const tolerance = 1e-9 * options_.output_step;
    while (true) {
      double t = t0_ + static_cast<double>(outputs_) * options_.output_step;
      if (t > std::min(t_stop, t_) + tolerance) return;
      if (std::abs(t - t_) <= round_off(t)) t = t_;  // the system is evaluated there already
      interpolate(t);
      ++outputs_;
      observer(t, y_out_.data(), y_out_.data() + n_);
    }
  }

  Options options_;
  Evaluator<System> f_;
  int n_;
  AnyMethod method_;
  StepController controller_;
  Vector absolute_;
  Vector y_, y_old_, y_new_, y_out_;  // (x, z) now, before the last step, tried, sampled

  Status status_ = Status::ok;
  double t0_ = 0, t_ = 0, t_old_ = 0;  // [s]
  double h_ = 0;                       // [s] next step to try
  double step_length_ = 1;             // [s] of the last accepted step
  double planned_at_ = 0;              // [s] where the grid of a method with its own begins
  std::int64_t grid_steps_ = 0;        // fixed steps: grid points passed
  std::int64_t outputs_ = 0;           // output times shown
  std::size_t next_breakpoint_ = 0;
  int crawled_ = 0;  // tiny steps in a row
  bool pending_output_ = false;
  bool prepared_ = false;                                  // the next step
  double hold_ = std::numeric_limits<double>::infinity();  // [s]
  std::function<void()> watcher_;
};

}  // namespace rollerrig::integrate
