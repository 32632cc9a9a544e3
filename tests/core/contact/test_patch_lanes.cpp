// Patches of several wheels side by side against the same patches one by one.
#include <doctest/doctest.h>

#include <random>

#include "rollerrig/contact/patch.hpp"

using namespace rollerrig;

#if ROLLERRIG_LANES
namespace {

std::shared_ptr<CreepTable const> random_table() {
  CreepTable table{2.302585092994046, 1.5, 3, {2, 3, 2}, {}};
  std::mt19937 random(7);
  std::uniform_real_distribution<float> any(-0.1f, 0.1f);
  for (std::size_t i = 0; i < table.size(); ++i) table.coefficients.push_back(any(random));
  return std::make_shared<CreepTable const>(table);
}

std::vector<ContactLaws> laws() {
  std::vector<ContactLaws> all;
  for (CreepLaw const& creep :
       {CreepLaw(KalkerLinear{}), CreepLaw(KalkerSaturated{}), CreepLaw(Coefficients{7e6, 6e6, 1e4, 9.0, true}),
        CreepLaw(Fastsim{}), CreepLaw(ModifiedFastsim{0.5, 0.4, 0.2}), CreepLaw(Polach{0.8, 0.4}),
        CreepLaw(TableLaw{random_table()}), CreepLaw(StripTheory{random_table()})}) {
    ContactLaws one;
    one.kalker = std::make_shared<KalkerTable const>(one.material.poisson_ratio);
    one.creep = creep;
    all.push_back(one);
  }
  return all;
}

/// Patches of wheels that roll, slide and lift, from stick to full sliding, of any aspect, on surfaces of their own.
struct AnyPatches {
  static constexpr std::size_t most = 11;
  std::vector<Patch<double>> patch{most};
  std::vector<ContactMotion<double>> motion{most};
  std::vector<Vec3<double>> wheelset{most};
  std::vector<Friction> friction{most};
  std::mt19937_64 random{5};

  double any() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); }
  explicit AnyPatches(std::shared_ptr<AdhesionMap const> const& map = {}) {
    for (std::size_t k = 0; k < most; ++k) {
      double const tilt = 0.6 * any(), slide = std::pow(10.0, 2.0 * any() - 2.0), V = 30.0 * any();
      wheelset[k] = {1e-3 * any(), 0.0, 0.46};
      patch[k].point.p = {2e-3 * any(), 0.75 + 0.03 * any(), 1e-3 * any()};
      patch[k].point.n = {1e-2 * any(), -std::sin(tilt), std::cos(tilt)};
      patch[k].elastic = 6e4 * (1.01 + any());
      patch[k].a = 5e-3 * std::exp(1.5 * any());
      patch[k].b = 5e-3 * std::exp(1.5 * any());
      patch[k].log_aspect = std::log(patch[k].a / patch[k].b);
      patch[k].weight = 0.5 + 0.5 * any();
      patch[k].damper = 0.5 + 0.5 * any();
      patch[k].pressure_moment = {any(), any(), any()};
      motion[k] = {{slide * any(), slide * any(), 0.1 * any()},
                   {any(), V / 0.46, 0.1 * any()},
                   {-V, 0.0, 0.0},
                   {0.0, -V, 0.1 * any()}};
      motion[k].arc_length = 10.0 * any();
      motion[k].dissipated_energy = 1e5 * (1.0 + any());
      friction[k].law =
          any() > 0.0 ? FrictionLaw(ConstantFriction{0.3 + 0.1 * any()}) : FrictionLaw(FallingFriction{0.4, 0.3, 0.7});
      friction[k].map = map;
    }
  }
  std::vector<MovingPatch<double>> all() {
    std::vector<MovingPatch<double>> out;
    for (std::size_t k = 0; k < most; ++k) out.push_back({&patch[k], &wheelset[k], &motion[k], &friction[k]});
    return out;
  }
};

using Numbers = std::array<double, sizeof(PatchForces<double>) / sizeof(double)>;
Numbers numbers(Patch<double> const& patch) {
  return std::bit_cast<Numbers>(static_cast<PatchForces<double> const&>(patch));
}

/// Largest difference over the size of each number among all patches.
double difference(std::vector<Patch<double>> const& a, std::vector<Patch<double>> const& b, std::size_t count) {
  double worst = 0.0;
  for (std::size_t f = 0; f < Numbers{}.size(); ++f) {
    double size = 0.0, apart = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
      size = std::max(size, std::abs(numbers(b[k])[f]));
      apart = std::max(apart, std::abs(numbers(a[k])[f] - numbers(b[k])[f]));
    }
    worst = std::max(worst, apart / size);
  }
  return worst;
}

std::shared_ptr<AdhesionMap const> wet_rail() {
  AdhesionMap map;
  RailAdhesion piece;
  piece.degraded = {FallingFriction{0.12, 0.4, 0.6}, 0.5, 0.2};
  piece.recovery_constant = 1e-5;
  map.pieces = {RailAdhesion{}, piece};
  map.borders = {1.0};
  map.blend = 2.0;
  return std::make_shared<AdhesionMap const>(map);
}

template <int W>
void check_lanes() {
  for (auto const& map : {std::shared_ptr<AdhesionMap const>{}, wet_rail()})
    for (ContactLaws const& law : laws())
      for (std::size_t count = 2; count <= W; ++count) {
        CAPTURE(law.creep.index());
        CAPTURE(count);
        AnyPatches beside(map), apart(map);
        auto const some = beside.all();
        add_creep_forces_in_lanes<W>(law, 1.0, std::span(some).first(count));
        for (auto const& one : apart.all()) add_creep_force(law, 1.0, one);
        // Round-off only: of velocities that nearly cancel, multiplied by a creep curve's slope.
        CHECK(difference(beside.patch, apart.patch, count) < 1e-12);
      }
}

}  // namespace

TEST_CASE("patches side by side get the forces that each gets alone") {
  check_lanes<2>();
  check_lanes<4>();
  check_lanes<8>();
}

TEST_CASE("any number of patches: each gets the force that it gets alone") {
  ContactLaws const law = laws().back();
  for (std::size_t count = 0; count <= AnyPatches::most; ++count) {
    CAPTURE(count);
    AnyPatches together, apart;
    auto const all = together.all();
    add_creep_forces<double>(law, 0.0, std::span(all).first(count));
    for (auto const& one : apart.all()) add_creep_force(law, 0.0, one);
    if (count > 0) CHECK(difference(together.patch, apart.patch, count) < 1e-12);
  }
}
#endif
