#include "rollerrig/contact/normal/strip_tables.hpp"

#include "rollerrig/contact/normal/strip_patch.hpp"
#include "rollerrig/math/dual.hpp"

namespace rollerrig {
namespace {

std::array<double, 4> hermite(double step, double f0, double f1, double m0, double m1) {
  double const jump = (f1 - f0) / step;
  return {f0, m0, (3.0 * jump - 2.0 * m0 - m1) / step, (m0 + m1 - 2.0 * jump) / (step * step)};
}

/// Column entry k over a/h, with its slope.
Dual<1> entry(StripKernel const& kernel, StripColumns::Kind kind, std::size_t k, double over_width) {
  auto const read = [&](double distance) {
    Dual<1> const x = distance / Dual<1>::variable(over_width, 0);
    return kind == StripColumns::Kind::deflection ? kernel.deflection(x) : kernel.curvature(x);
  };
  if (k == 0) return 2.0 * read(0.5);
  double const distance = static_cast<double>(k);
  return read(distance + 0.5) - read(distance - 0.5);
}

/// What Hertz' theory says of a parabola with A = 1 over what the strips make of it.
struct Ratios {
  double force, a, b, peak, width;
};

Ratios exact_over_strips(StripTables const& tables, double x) {
  HertzTable const& hertz = hertz_table();
  double const depth = 1e-4, across = std::exp(-x), sum = 1.0 + across;
  double const half = std::sqrt(depth / across);
  Strips<double> s;
  StripPlaces<double> places;
  s.compliance = 1.0;
  s.curvature.fill(1.0);
  auto const lay = [&](double from, double to) {
    s.width = (to - from) / strip_count;
    for (std::size_t i = 0; i < strip_count; ++i) {
      double const y = places.across[i] = from + (static_cast<double>(i) + 0.5) * s.width;
      s.interpenetration[i] = depth - across * y * y;
      places.point[i] = {0.0, y, 0.0};
    }
  };
  lay(-half, half);
  auto const loaded = range_of_load(tables, 1.0, s);
  double const first = s.width;
  lay(-half + loaded.from * first, -half + loaded.to * first);
  places.along.fill(0.0);
  places.wheel_s.fill(0.0);
  places.rail_y.fill(0.0);
  places.normal.fill({0.0, 0.0, 1.0});
  StripRow<double> all;
  all.fill(1.0);
  solve_strips(tables, s, false);
  auto const part = part_of(tables, s, places, all);
  double const root = std::sqrt(depth / sum);
  double const a = hertz.semi_axis.at(x).value * root, b = hertz.semi_axis.at(-x).value * root;
  double const force = hertz.stiffness.at(x).value / std::sqrt(sum) * depth * std::sqrt(depth) / pi;  // Q = pi here
  return {force / part.normal, a / part.a, b / part.b, 1.5 * force / (pi * a * b) / part.peak_pressure,
          2.0 * b / part.width};
}

}  // namespace

StripColumns::StripColumns(StripKernel const& kernel, Kind kind) {
  for (int octave = lowest_octave; octave < lowest_octave + octaves; ++octave)
    for (int part = 0; part < 1 << bits; ++part) {
      double const step = std::ldexp(1.0, octave - bits);
      double const x0 = std::ldexp(1.0, octave) + part * step;
      Cell cell;
      for (std::size_t k = 0; k < strip_count; ++k) {
        auto const f0 = entry(kernel, kind, k, x0), f1 = entry(kernel, kind, k, x0 + step);
        auto const c = hermite(step, f0.value, f1.value, f0.d[0], f1.d[0]);
        for (std::size_t j = 0; j < 4; ++j) cell.c[j][k] = c[j];
      }
      cells_.push_back(cell);
    }
}

/// Cubic pieces through f, slopes from differences.
template <class F>
void StripTables::tabulate(StartFunction function, F const& f) {
  double const end = std::log(HertzTable::limit), step = 2.0 * end / pieces;
  std::vector<double> value;
  for (int i = 0; i <= pieces; ++i) value.push_back(f(std::clamp(-end + step * i, -end, end)));
  auto const slope = [&](std::size_t i) {
    std::size_t const low = i == 0 ? 0 : i - 1, high = std::min(i + 1, value.size() - 1);
    return (value[high] - value[low]) / (step * static_cast<double>(high - low));
  };
  for (std::size_t i = 0; i < pieces; ++i)
    pieces_[i][static_cast<std::size_t>(function)] = hermite(step, value[i], value[i + 1], slope(i), slope(i + 1));
}

StripTables::StripTables()
    : deflection(strip_kernel(), StripColumns::Kind::deflection),
      curvature(strip_kernel(), StripColumns::Kind::curvature) {
  HertzTable const& hertz = hertz_table();
  auto const a = [&](double x) { return hertz.semi_axis.at(x).value; };
  tabulate(StartFunction::conformity, [&](double x) {  // Q p0 / (a A)
    return 1.5 / pi * hertz.stiffness.at(x).value * (1.0 + std::exp(-x)) / (a(x) * a(x) * a(-x));
  });
  tabulate(StartFunction::length, [&](double x) { return a(x) * a(x); });
  tabulate(StartFunction::edge, [&](double x) { return 1.0 - a(-x) * a(-x) / (1.0 + std::exp(x)); });
  constexpr StartFunction corrections[] = {StartFunction::force, StartFunction::half_length, StartFunction::half_width,
                                           StartFunction::peak_pressure, StartFunction::width};
  constexpr double Ratios::* ratios[] = {&Ratios::force, &Ratios::a, &Ratios::b, &Ratios::peak, &Ratios::width};
  for (auto f : corrections) tabulate(f, [](double) { return 1.0; });
  // Each knot once, with corrections of one still in place.
  double const end = std::log(HertzTable::limit), step = 2.0 * end / pieces;
  std::vector<Ratios> at_knot;
  for (int i = 0; i <= pieces; ++i) at_knot.push_back(exact_over_strips(*this, std::clamp(-end + step * i, -end, end)));
  for (std::size_t k = 0; k < std::size(corrections); ++k)
    tabulate(corrections[k],
             [&](double x) { return at_knot[static_cast<std::size_t>(std::lround((x + end) / step))].*ratios[k]; });
}

StripTables const& strip_tables() {
  static StripTables const tables;
  return tables;
}

}  // namespace rollerrig
