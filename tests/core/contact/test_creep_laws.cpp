// What every creep law must do, and what each of them does in its limits.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "explicit_real.hpp"
#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/contact/creep/creep_law.hpp"
#include "rollerrig/math/dual.hpp"

using namespace rollerrig;
using test::ExplicitReal;

namespace {

KalkerTable const kalker(0.28);
double const G = 82e9;
double const adhesion = 0.3 * 5e4;

/// A small table of random numbers: what the code does with it must hold whatever they are.
CreepTable random_table() {
  CreepTable table{2.302585092994046, 1.5, 3, {2, 3, 2}, {}};
  std::mt19937 random(7);
  std::uniform_real_distribution<float> any(-0.1f, 0.1f);
  for (std::size_t i = 0; i < table.size(); ++i) table.coefficients.push_back(any(random));
  return table;
}
CreepTable const table = random_table();

Coefficients const coefficients{7e6, 6e6, 1.5e4, 15.0, true}, linear_coefficients{7e6, 6e6, 1.5e4, 15.0, false};

struct Named {
  char const* name;
  CreepLaw law;
};
std::vector<Named> laws() {
  return {{"kalker_linear", KalkerLinear{}},
          {"kalker_saturated", KalkerSaturated{}},
          {"coefficients", coefficients},
          {"linear coefficients", linear_coefficients},
          {"fastsim", Fastsim{}},
          {"modified_fastsim", ModifiedFastsim{}},
          {"wet modified_fastsim", ModifiedFastsim{0.5, 0.4, 0.2}},
          {"polach", Polach{}},
          {"wet polach", Polach{0.8, 0.4}},
          {"table", TableLaw{std::make_shared<CreepTable const>(table)}},
          {"strip_theory", StripTheory{std::make_shared<CreepTable const>(table)}}};
}
template <class Law>
bool is(CreepLaw const& law) {
  return std::holds_alternative<Law>(law);
}
bool is_linear(CreepLaw const& law) {
  auto const* own = std::get_if<Coefficients>(&law);
  return is<KalkerLinear>(law) || (own != nullptr && !own->saturation);
}

template <class T>
CreepQuery<T> query(std::array<T, 3> const& e, T const& a, T const& b, T const& direction) {
  using std::log;
  T const log_aspect = log(a / b);
  return {
      {e[0], e[1], e[2]}, kalker_stiffness(kalker.at(log_aspect), G, a, b, direction), T(adhesion), a, b, log_aspect,
      direction};
}

CreepQuery<double> query(double ex, double ey, double es, double a = 5e-3, double b = 4e-3, double direction = 1.0) {
  return query<double>({ex, ey, es}, a, b, direction);
}

double power(CreepQuery<double> const& q, CreepForce<double> const& f) {
  return -(f.longitudinal * q.creepage.longitudinal + f.lateral * q.creepage.lateral + f.spin_moment * q.creepage.spin);
}

/// Any creepage from stick to full sliding, any ellipse.
struct Any {
  std::mt19937 random{3};
  std::uniform_real_distribution<double> sign{-1.0, 1.0}, exponent{-6.0, -1.5};
  CreepQuery<double> operator()() {
    double const size = std::pow(10.0, exponent(random));
    double const a = 5e-3 * std::pow(3.0, sign(random));
    return query(size * sign(random), size * sign(random), 200.0 * size * sign(random), a, 25e-6 / a);
  }
};

}  // namespace

TEST_CASE("no creepage, no force, for every law") {
  for (auto const& [name, law] : laws()) {
    CAPTURE(name);
    auto const force = creep_force(law, query(0.0, 0.0, 0.0));
    CHECK(std::abs(force.longitudinal) < 1e-9 * adhesion);
    CHECK(std::abs(force.lateral) < 1e-9 * adhesion);
    CHECK(std::abs(force.spin_moment) < 1e-12 * adhesion);
  }
}

TEST_CASE("on a weak rail the creep curve is the law's closed form with the rail's reductions") {
  RailSurface<double> const wet{0.3, 0.3, 0.1};
  for (double e : {1e-5, 3e-4, 2e-3, 1e-2, 5e-2}) {
    auto const q = query(e, 0.0, 0.0);
    CreepLaw const dry = Polach{1.0, 0.4};  // the rail's are in place of them
    double const g = 0.25 * pi * q.stiffness.f11 * e / adhesion;
    double const polach = 2.0 / pi * adhesion * (0.3 * g / (1.0 + 0.09 * g * g) + std::atan(0.1 * g));
    CHECK(creep_force(dry, q, wet).longitudinal == doctest::Approx(-polach).epsilon(1e-9));
    double const tau = 0.2 * q.stiffness.f11 * e / adhesion;  // (k_A + k_S)/2 of Kalker's slope
    double const cubic = tau < 3.0 ? tau * (1.0 - tau / 3.0 + tau * tau / 27.0) : 1.0;
    CHECK(creep_force(KalkerSaturated{}, q, wet).longitudinal == doctest::Approx(-adhesion * cubic).epsilon(1e-9));
    CHECK(creep_force(KalkerLinear{}, q, wet).longitudinal ==
          doctest::Approx(-0.2 * q.stiffness.f11 * e).epsilon(1e-12));
  }
}

TEST_CASE("a weak rail takes the same part of the slope from every law, and none of the friction") {
  RailSurface<double> const wet{0.3, 0.3, 0.1};
  for (auto const& [name, law] : laws()) {
    CAPTURE(name);
    CreepLaw const slope = is<Polach>(law) ? Polach{} : law;
    auto const q = query(2e-7, 0.0, 0.0);
    double const clean = creep_force(slope, q).longitudinal;
    // The random table is no law of contact: its correction is not flat at the origin to more than 1 %.
    CHECK(creep_force(law, q, wet).longitudinal == doctest::Approx(0.2 * clean).epsilon(1e-2));
    if (is_linear(law) || is<TableLaw>(law) || is<StripTheory>(law)) continue;
    CHECK(creep_force(law, query(5.0, 0.0, 0.0), wet).longitudinal == doctest::Approx(-adhesion).epsilon(5e-3));
  }
}

TEST_CASE("coefficients as given make the force, whatever the patch") {
  auto const& f = coefficients;
  for (double a : {2e-3, 12e-3}) {
    auto const q = query(3e-5, -2e-5, 4e-3, a, 25e-6 / a);
    auto const force = creep_force(linear_coefficients, q);
    CHECK(force.longitudinal == doctest::Approx(-f.f11 * 3e-5).epsilon(1e-12));
    CHECK(force.lateral == doctest::Approx(f.f22 * 2e-5 - f.f23 * 4e-3).epsilon(1e-12));
    CHECK(force.spin_moment == doctest::Approx(-f.f23 * 2e-5 - f.f33 * 4e-3).epsilon(1e-12));
  }
}

TEST_CASE("limited coefficients are the cubic of Vermeulen and Johnson over normalised creepages") {
  double const phi = 0.60252, psi = 0.54219, stiffness = 6.563e6;  // pi G a b: Cooperrider's bogie
  CreepLaw const law = Coefficients{stiffness / phi, stiffness / psi, 0.0, 0.0, true};
  for (double size : {1e-5, 3e-4, 2e-3, 1e-2}) {
    double const ex = 0.6 * size, ey = -0.8 * size;
    double const xi = std::hypot(ex / phi, ey / psi), u = stiffness * xi / adhesion;
    double const force = adhesion * (u < 3.0 ? u - u * u / 3.0 + u * u * u / 27.0 : 1.0);
    auto const found = creep_force(law, query(ex, ey, 0.0));
    CHECK(found.longitudinal == doctest::Approx(-force * ex / phi / xi).epsilon(1e-9));
    CHECK(found.lateral == doctest::Approx(-force * ey / psi / xi).epsilon(1e-9));
  }
}

TEST_CASE("small creepages give Kalker's forces") {
  // The strips of FASTSIM, ten of ten elements, miss the integrals by up to 1.3 %; the moment that lateral creepage makes
  // is no parameter of FASTSIM, so the moment is tested with spin alone, where the modified law has C33.
  for (auto const& [law, tolerance] : {std::pair<CreepLaw, double>{Fastsim{}, 0.015},
                                       {ModifiedFastsim{}, 0.015},
                                       {Polach{}, 1e-3},
                                       {KalkerSaturated{}, 1e-3}}) {
    CAPTURE(law.index());
    for (double a : {2e-3, 5e-3, 12e-3}) {
      auto const q = query(2e-7, 0.0, 0.0, a, 25e-6 / a);
      auto const x = creep_force(law, q);
      CHECK(x.longitudinal == doctest::Approx(-q.stiffness.f11 * 2e-7).epsilon(tolerance));
      auto const y = creep_force(law, query(0.0, 2e-7, 0.0, a, 25e-6 / a));
      CHECK(y.lateral == doctest::Approx(-q.stiffness.f22 * 2e-7).epsilon(tolerance));
      auto const s = creep_force(law, query(0.0, 0.0, 2e-5, a, 25e-6 / a));
      CHECK(s.lateral == doctest::Approx(-q.stiffness.f23 * 2e-5).epsilon(tolerance));
      if (!is<Fastsim>(law)) CHECK(s.spin_moment == doctest::Approx(-q.stiffness.f33 * 2e-5).epsilon(2.0 * tolerance));
    }
  }
}

TEST_CASE("in full sliding without spin the force is mu N against the slip") {
  for (CreepLaw const& law : {CreepLaw{Fastsim{}}, CreepLaw{ModifiedFastsim{}}, CreepLaw{Polach{}}}) {
    CAPTURE(law.index());
    for (double angle : {0.0, 0.5, 1.2, 2.5}) {
      auto const force = creep_force(law, query(50.0 * std::cos(angle), 50.0 * std::sin(angle), 0.0));
      CHECK(std::hypot(force.longitudinal, force.lateral) == doctest::Approx(adhesion).epsilon(1e-3));
      CHECK(std::cos(angle) * force.longitudinal + std::sin(angle) * force.lateral ==
            doctest::Approx(-adhesion).epsilon(1e-3));
    }
  }
}

TEST_CASE("FASTSIM in full sliding with spin gives Coulomb's force and moment over the patch") {
  double const a = 6e-3, b = 3e-3;
  auto const q = query(30.0, 20.0, 8000.0, a, b);
  double fx = 0.0, fy = 0.0, m = 0.0, total = 0.0;
  for (int i = 0; i < 400; ++i)
    for (int j = 0; j < 400; ++j) {
      double const x = -1.0 + (i + 0.5) / 200.0, y = -1.0 + (j + 0.5) / 200.0;
      double const p = std::max(0.0, 1.0 - x * x - y * y);  // its limit of traction is a paraboloid
      double const sx = 30.0 - 8000.0 * b * y, sy = 20.0 + 8000.0 * a * x;
      double const size = std::hypot(sx, sy);
      fx -= p * sx / size, fy -= p * sy / size, m -= p * (a * x * sy - b * y * sx) / size, total += p;
    }
  for (CreepLaw const& law : {CreepLaw{Fastsim{}}, CreepLaw{ModifiedFastsim{}}}) {
    auto const force = creep_force(law, q);  // ten by ten elements: 1 % of mu N
    CHECK(force.longitudinal == doctest::Approx(adhesion * fx / total).epsilon(0.01));
    CHECK(force.lateral == doctest::Approx(adhesion * fy / total).epsilon(0.01));
    CHECK(force.spin_moment == doctest::Approx(adhesion * m / total).epsilon(0.02));
  }
}

TEST_CASE("the force never exceeds mu N and the moment stays bounded") {
  Any any;
  for (int i = 0; i < 3000; ++i) {
    auto const q = any();
    for (CreepLaw const& law : {CreepLaw{Fastsim{}}, CreepLaw{ModifiedFastsim{}}}) {
      auto const force = creep_force(law, q);
      CHECK(std::hypot(force.longitudinal, force.lateral) <= adhesion * (1.0 + 1e-12));
      CHECK(std::abs(force.spin_moment) <= adhesion * std::max(q.a, q.b));
    }
    auto const force = creep_force(Polach{}, q);
    CHECK(std::hypot(force.longitudinal, force.lateral) <= 1.35 * adhesion);  // with spin Polach's sum may exceed it
    CHECK(std::abs(force.spin_moment) <= 1.5 * adhesion * std::max(q.a, q.b));
  }
}

TEST_CASE("no law but the paper's with spin feeds energy in") {
  Any any;
  for (int i = 0; i < 3000; ++i) {
    auto const q = any();
    for (auto const& [name, law] : laws()) {
      if (is<KalkerSaturated>(law)) continue;
      CAPTURE(name);
      double const slip =
          std::abs(q.creepage.longitudinal) + std::abs(q.creepage.lateral) + q.a * std::abs(q.creepage.spin);
      CHECK(power(q, creep_force(law, q)) >= -1e-12 * adhesion * slip);
    }
  }
}

TEST_CASE("rolling backward is the mirror image: spin and moment change sign, and so does nothing else") {
  Any any;
  for (int i = 0; i < 100; ++i) {
    auto const q = any();
    auto const& e = q.creepage;
    auto const back = query(e.longitudinal, e.lateral, -e.spin, q.a, q.b, -1.0);
    for (auto const& [name, law] : laws()) {
      CAPTURE(name);
      auto const f = creep_force(law, q), g = creep_force(law, back);
      CHECK(g.longitudinal == doctest::Approx(f.longitudinal).epsilon(1e-10));
      CHECK(g.lateral == doctest::Approx(f.lateral).epsilon(1e-10));
      CHECK(g.spin_moment == doctest::Approx(-f.spin_moment).epsilon(1e-10));
    }
  }
}

TEST_CASE("every law carries derivatives, also with respect to the ellipse") {
  using D = Dual<5>;
  std::array<double, 5> const step{1e-9, 1e-9, 1e-7, 1e-9, 1e-9};
  for (std::array<double, 5> const& at :
       {std::array{3e-4, -5e-4, 0.1, 5e-3, 4e-3}, {1.5e-3, 1e-3, -0.4, 2.5e-3, 6e-3}, {-4e-3, 6e-3, 1.2, 8e-3, 2e-3}}) {
    std::array<D, 5> v;
    for (int k = 0; k < 5; ++k) v[static_cast<std::size_t>(k)] = D::variable(at[static_cast<std::size_t>(k)], k);
    for (auto const& [name, law] : laws()) {
      CAPTURE(name);
      auto const exact = creep_force(law, query<D>({v[0], v[1], v[2]}, v[3], v[4], D(1.0)));
      for (std::size_t k = 0; k < 5; ++k) {
        auto const moved = [&](double by) {
          auto x = at;
          x[k] += by;
          return creep_force(law, query(x[0], x[1], x[2], x[3], x[4]));
        };
        auto const up = moved(step[k]), down = moved(-step[k]);
        double const width = 2.0 * step[k];
        double const scale = adhesion / std::max(std::abs(at[k]), 1e-3);  // rounding of the differences: 1e-6 of it
        int const i = static_cast<int>(k);
        CHECK(std::abs(exact.longitudinal.d[i] - (up.longitudinal - down.longitudinal) / width) < 1e-4 * scale);
        CHECK(std::abs(exact.lateral.d[i] - (up.lateral - down.lateral) / width) < 1e-4 * scale);
        CHECK(std::abs(exact.spin_moment.d[i] - (up.spin_moment - down.spin_moment) / width) < 1e-6 * scale);
      }
    }
  }
}

TEST_CASE("every law holds for a scalar with no implicit conversions") {
  using E = ExplicitReal;
  for (auto const& [name, law] : laws()) {
    CAPTURE(name);
    auto const force = creep_force(law, query<E>({E(1e-3), E(-2e-3), E(0.2)}, E(5e-3), E(4e-3), E(1.0)));
    auto const plain = creep_force(law, query(1e-3, -2e-3, 0.2));
    CHECK(force.longitudinal.x == doctest::Approx(plain.longitudinal).epsilon(1e-14));
    CHECK(force.lateral.x == doctest::Approx(plain.lateral).epsilon(1e-14));
    CHECK(force.spin_moment.x == doctest::Approx(plain.spin_moment).epsilon(1e-14));
  }
}

TEST_CASE("no friction, no load: no force, and nothing that is not a number") {
  for (auto const& [name, law] : laws()) {
    if (is_linear(law)) continue;  // knows no friction
    CAPTURE(name);
    auto q = query(1e-3, -2e-3, 0.2);
    q.adhesion = 1e-9;  // the least that a patch hands over
    auto const force = creep_force(law, q);
    CHECK(std::abs(force.longitudinal) < 1e-8);
    CHECK(std::abs(force.lateral) < 1e-8);
  }
}

TEST_CASE("the table holds its end values outside its range, with slopes of zero there") {
  auto const inside = read_creep_table_slopes(table, {table.log_aspect_end, {0.2, -0.3, 0.1}});
  auto const outside = read_creep_table_slopes(table, {table.log_aspect_end + 1.0, {0.2, -0.3, 0.1}});
  for (auto component :
       {&CreepTableValue<double>::along, &CreepTableValue<double>::across, &CreepTableValue<double>::moment}) {
    CHECK(outside.value.*component == inside.value.*component);
    CHECK(outside.slope[0].*component == 0.0);
  }
  double const nan = std::nan("");
  CHECK(std::isfinite(read_creep_table(table, {nan, {nan, 5.0, -5.0}}).along));  // no access out of bounds
}

TEST_CASE("the table is symmetric as the patch is: mirrored slip, mirrored force") {
  auto const p = read_creep_table(table, {0.3, {0.2, -0.3, 0.1}});
  auto const mirrored = read_creep_table(table, {0.3, {-0.2, -0.3, 0.1}});
  auto const turned = read_creep_table(table, {0.3, {0.2, 0.3, -0.1}});
  CHECK(mirrored.along == -p.along);
  CHECK(mirrored.across == p.across);
  CHECK(mirrored.moment == p.moment);
  CHECK(turned.along == p.along);
  CHECK(turned.across == -p.across);
  CHECK(turned.moment == -p.moment);
}

TEST_CASE("friction falls with slip velocity as Polach's formula says") {
  Friction const wet{FallingFriction{0.3, 0.4, 0.2}};
  CHECK(wet(0.0, 0.0, 0.0, 0.0, 0.0).friction == doctest::Approx(0.3));
  CHECK(wet(0.0, 0.0, 5.0, 0.0, 0.0).friction == doctest::Approx(0.3 * (0.6 * std::exp(-1.0) + 0.4)));
  CHECK(wet(0.0, 0.0, 1e6, 0.0, 0.0).friction == doctest::Approx(0.12));
  CHECK(Friction{ConstantFriction{0.3}}(0.0, 0.0, 7.0, 0.0, 0.0).friction == 0.3);
}

TEST_CASE("on the gauge face a contact has the friction given for it, with a smooth transition from the top") {
  auto const share = [](double degrees) {
    double const angle = degrees * std::numbers::pi / 180.0;
    return share_of_gauge_face(Vec3<double>{0.01, -std::sin(angle), std::cos(angle)});
  };
  for (double angle : {-70.0, -30.0, 0.0, 3.0, 19.9}) CHECK(share(angle) == 0.0);  // of the field side, too
  for (double angle : {40.1, 60.0, 70.0, 88.0}) CHECK(share(angle) == 1.0);
  double const middle = std::asin(0.5 * (std::sin(std::numbers::pi / 9) + std::sin(2 * std::numbers::pi / 9)));
  CHECK(share(middle * 180.0 / std::numbers::pi) == doctest::Approx(0.5).epsilon(1e-12));
  for (double angle = 20.0; angle < 40.0; angle += 0.5) CHECK(share(angle + 0.5) > share(angle));
  for (double border : {20.0, 40.0}) CHECK(std::abs(share(border + 0.01) - share(border - 0.01)) < 1e-5);  // no slope

  using D = Dual<1>;
  D tilted(-0.5);
  tilted.d[0] = 1.0;
  double const h = 1e-6;
  auto const at = [](double y) { return share_of_gauge_face(Vec3<double>{0.0, y, 0.8}); };
  CHECK(share_of_gauge_face(Vec3<D>{D(0.0), tilted, D(0.8)}).d[0] ==
        doctest::Approx((at(-0.5 + h) - at(-0.5 - h)) / (2 * h)).epsilon(1e-6));

  Friction lubricated{ConstantFriction{0.4}};
  Vec3<double> const top{0.0, -0.02, 1.0}, flange{0.0, -0.94, 0.34};
  CHECK(lubricated.where(0.4, flange) == 0.4);  // none is given
  lubricated.gauge_face = 0.15;
  CHECK(lubricated.where(0.4, top) == 0.4);
  CHECK(lubricated.where(0.4, flange) == doctest::Approx(0.15));
  lubricated.gauge_face = 0.4;
  CHECK(lubricated.where(0.4, Vec3<double>{0.0, -0.5, 0.8}) == 0.4);
}
