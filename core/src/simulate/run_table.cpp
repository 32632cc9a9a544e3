#include "rollerrig/simulate/run_table.hpp"

#include <algorithm>

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
  constexpr std::size_t fewest = 4, most = 64;
  double const rest = (driver.time() - last_) / interval_ * (1.0 + 1e-12);
  if (!alone_ || driver.system() != nullptr || !(rest >= fewest)) return;
  std::size_t const room = table_.room - table_.filled;
  std::size_t const count = std::min({static_cast<std::size_t>(std::min(rest, 1e6)), most, room});
  if (count < fewest) return;
  first_ = table_.filled - 1;
  x_.resize(static_cast<std::size_t>(driver.plant().sizes().states));
  z_.resize(static_cast<std::size_t>(driver.plant().sizes().quadratures));
  evaluate(driver, count);
  refine(driver, 0, count);
  ahead_ = count;
}

void Readings::evaluate(Driver& driver, std::size_t k) {
  double const t = table_.times[first_] + static_cast<double>(k) * interval_;
  driver.sample_states(t, x_.data(), z_.data());
  driver.record_reading(t, x_.data(), z_.data(), row(k));
}

/// Readings between two that are evaluated.
void Readings::refine(Driver& driver, std::size_t from, std::size_t to) {
  if (to - from < 2) return;
  std::size_t const middle = (from + to) / 2;
  evaluate(driver, middle);
  if (!is_straight(from, middle, to)) {
    refine(driver, from, middle);
    refine(driver, middle, to);
    return;
  }
  double const a = static_cast<double>(from), b = static_cast<double>(middle), c = static_cast<double>(to);
  for (std::size_t k = from + 1; k < to; ++k) {
    if (k == middle) continue;
    double const t = static_cast<double>(k);
    double const at_a = (t - b) * (t - c) / ((a - b) * (a - c)), at_b = (t - a) * (t - c) / ((b - a) * (b - c)),
                 at_c = (t - a) * (t - b) / ((c - a) * (c - b));
    for (std::size_t i = 0; i < table_.width; ++i)
      row(k)[i] = at_a * row(from)[i] + at_b * row(middle)[i] + at_c * row(to)[i];
  }
}

/// Y and Q over Q, the wear number over itself; the distance, last, is smooth.
bool Readings::is_straight(std::size_t from, std::size_t middle, std::size_t to) const {
  double const share = static_cast<double>(middle - from) / static_cast<double>(to - from);
  auto const off = [&](std::size_t i) {
    return std::abs(row(middle)[i] - (1.0 - share) * row(from)[i] - share * row(to)[i]);
  };
  auto const size = [&](std::size_t i) {
    return std::max({std::abs(row(from)[i]), std::abs(row(middle)[i]), std::abs(row(to)[i])});
  };
  for (std::size_t i = 0; i + 3 < table_.width; i += 3) {
    double const load = straight * size(i + 1), wear = straight * std::max(size(i + 2), least_wear);
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
