#include "rollerrig/contact/normal/strip_tables.hpp"

#include "rollerrig/contact/normal/strip_patch.hpp"

namespace rollerrig {
namespace {

/// What Hertz' theory says of a parabola with A = 1 over what the strips make of it.
struct Ratios {
  double force, a, b, peak, width;
};

Ratios exact_over_strips(StripTables const& tables, double x) {
  HertzTable const& hertz = hertz_table();
  double const depth = 1e-4, across = std::exp(-x), sum = 1.0 + across;
  Strips<double> s;
  StripPlaces<double> places;
  lay_over_paraboloid(tables, 1.0, 0.0, across, depth, s, places);
  StripRow<double> all;
  all.fill(1.0);
  solve_strips(tables, s, strip_passes);
  auto const part = part_of(tables, s, places, all);
  double const root = std::sqrt(depth / sum);
  double const a = hertz.semi_axis.at(x).value * root, b = hertz.semi_axis.at(-x).value * root;
  double const force = hertz.stiffness.at(x).value / std::sqrt(sum) * depth * std::sqrt(depth) / pi;  // Q = pi here
  return {force / part.normal, a / part.a, b / part.b, 1.5 * force / (pi * a * b) / part.peak_pressure,
          2.0 * b / part.width};
}

}  // namespace

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

StripTables::StripTables() {
  HertzTable const& hertz = hertz_table();
  auto const square_axis = [&](double x) { return square(hertz.semi_axis.at(x).value); };
  tabulate(StartFunction::length, square_axis);
  tabulate(StartFunction::breadth, [&](double x) { return square_axis(-x); });
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
