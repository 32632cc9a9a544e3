#include "rollerrig/simulate/run_table.hpp"

#include <algorithm>
#include <utility>

#include "rollerrig/simulate/driver.hpp"

namespace rollerrig {

bool Readings::read(Driver& driver, double t, double const* x, double const* z) {
  bool const whole = shown_++ % every_ == 0;
  alone_ = false;
  interval_ = t - last_;
  last_ = t;
  double* const here = table_.add(t);
  if (here == nullptr) return whole;
  alone_ = ahead_ == 0;
  if (!alone_) --ahead_;
  if (alone_ || whole) driver.record_reading(t, x, z, here);  // at a row it is the row's
  return whole;
}

void Readings::read_ahead(Driver& driver) {
  constexpr std::size_t fewest = 8;
  Model const& model = driver.plant().model();
  bool const follows_place = model.displaces_rails() || model.on_adhesion_map;  // by more than the states show
  double const rest = (driver.time() - last_) / interval_ * (1.0 + 1e-12);
  if (!alone_ || driver.system() != nullptr || follows_place || !(rest >= fewest)) return;
  std::size_t const room = table_.room - table_.filled;
  std::size_t const count = std::min({at(std::min(rest, 1e6)), most, room});
  if (count < fewest) return;
  first_ = table_.filled - 1;
  x_.resize(at(driver.plant().sizes().states));
  z_.resize(at(driver.plant().sizes().quadratures));
  known_.fill(false);
  known_[0] = true;
  evaluate(driver, count);
  refine(driver, 0, count);
  ahead_ = count;
}

void Readings::evaluate(Driver& driver, std::size_t k) {
  if (std::exchange(known_[k], true)) return;
  double const t = table_.times[first_] + static_cast<double>(k) * interval_;
  driver.sample_states(t, x_.data(), z_.data());
  driver.record_reading(t, x_.data(), z_.data(), row(k));
}

/// Readings between two that are evaluated.
void Readings::refine(Driver& driver, std::size_t from, std::size_t to) {
  if (to - from < 2) return;
  std::size_t const middle = (from + to) / 2, before = (from + middle) / 2, behind = (middle + to) / 2;
  for (std::size_t const k : {middle, before, behind}) evaluate(driver, k);
  Parabola const all{from, middle, to};
  if (is_near(all, before) && is_near(all, behind)) {
    fill({from, before, middle});
    fill({middle, behind, to});
  } else {
    refine(driver, from, middle);
    refine(driver, middle, to);
  }
}

double Readings::on(Parabola const& p, std::size_t k, std::size_t i) const {
  auto const [a, b, c] =
      std::array{static_cast<double>(p.from), static_cast<double>(p.middle), static_cast<double>(p.to)};
  double const t = static_cast<double>(k);
  return (t - b) * (t - c) / ((a - b) * (a - c)) * row(p.from)[i] +
         (t - a) * (t - c) / ((b - a) * (b - c)) * row(p.middle)[i] +
         (t - a) * (t - b) / ((c - a) * (c - b)) * row(p.to)[i];
}

void Readings::fill(Parabola const& p) {
  for (std::size_t k = p.from + 1; k < p.to; ++k)
    for (std::size_t i = 0; !known_[k] && i < table_.width; ++i) row(k)[i] = on(p, k, i);
}

/// Y and Q over Q, the wear number over itself; the distance, last, is smooth.
bool Readings::is_near(Parabola const& p, std::size_t k) const {
  if (k == p.from || k == p.middle) return true;
  for (std::size_t i = 0; i + 3 < table_.width; i += 3) {
    double const load = allowed * std::abs(row(p.middle)[i + 1]);
    double const wear = allowed * std::max(std::abs(row(p.middle)[i + 2]), least_wear);
    auto const off = [&](std::size_t column) { return std::abs(row(k)[column] - on(p, k, column)); };
    if (off(i) > load || off(i + 1) > load || off(i + 2) > wear) return false;
  }
  return true;
}

Status advance(Driver& driver, double t_stop, TimedRows& rows, Readings* readings) {
  return driver.advance(t_stop, [&](double t, double const* x, double const* z) {
    if (readings == nullptr || readings->read(driver, t, x, z))
      if (double* const row = rows.add(t)) driver.record(t, x, z, row);
    if (readings != nullptr) readings->read_ahead(driver);  // x and z are those of another time from here on
  });
}

}  // namespace rollerrig
