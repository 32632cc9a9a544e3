#include <doctest/doctest.h>

#include <set>
#include <string>

#include "rollerrig/simulate/recorder.hpp"
#include "system/models.hpp"

using namespace rollerrig;

namespace {

std::size_t place(std::span<Field const> fields, std::string_view name) {
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (fields[i].name == name) return i;
  FAIL("no field " << name);
  return 0;
}

}  // namespace

TEST_CASE("a row has one number per field of each body, wheel, patch and element") {
  auto const model = test::wheelset_model({});
  Recorder const recorder(*model);
  auto const expected = 2 * Recorder::body_fields().size() + 2 * Recorder::wheel_fields().size() +
                        2 * Recorder::patches * Recorder::patch_fields().size() +
                        2 * Recorder::element_fields().size() + Recorder::run_fields().size();
  CHECK(recorder.width() == static_cast<int>(expected));
}

TEST_CASE("names are unique, and every field says its unit and meaning") {
  for (auto fields : {Recorder::body_fields(), Recorder::wheel_fields(), Recorder::patch_fields(),
                      Recorder::element_fields(), Recorder::run_fields()}) {
    std::set<std::string_view> names;
    for (auto const& f : fields) {
      CHECK(names.insert(f.name).second);
      CHECK_FALSE(f.unit.empty());
      CHECK(f.meaning.size() > 3);
    }
  }
}

TEST_CASE("the recorded wheel forces are those of the equilibrium, and the patches add up to the wheel") {
  auto const model = test::wheelset_model({.speed = 20.0});
  Dynamics dynamics(model);
  Recorder const recorder(*model);
  auto const e = solve_equilibrium(dynamics, 20.0, 0.0);
  REQUIRE(e.converged);
  std::vector<double> z(static_cast<std::size_t>(dynamics.sizes().quadratures), 0.0),
      row(static_cast<std::size_t>(recorder.width()));
  z[0] = 1234.5;  // the wheelset's angle
  recorder.record(dynamics, 0.0, e.x.data(), z.data(), row.data());
  auto const body = Recorder::body_fields();
  auto const wheel = Recorder::wheel_fields();
  auto const patch = Recorder::patch_fields();
  CHECK(row[place(body, "pitch")] == 1234.5);
  CHECK(row[place(body, "pitch_rate")] == doctest::Approx(20.0 / 0.46).epsilon(1e-3));
  double const* wheels = row.data() + 2 * body.size();
  double const* patches = wheels + 2 * wheel.size();
  double vertical = 0.0;
  for (std::size_t w = 0; w < 2; ++w) {
    double const* own = wheels + w * wheel.size();
    vertical += own[place(wheel, "vertical_force")];
    double normal = 0.0;
    auto const count = static_cast<std::size_t>(own[place(wheel, "patch_count")]);
    for (std::size_t k = 0; k < Recorder::patches; ++k) {
      double const value = patches[(w * Recorder::patches + k) * patch.size() + place(patch, "normal")];
      CHECK(std::isnan(value) == (k >= count));
      if (k < count) normal += value;
    }
    CHECK(normal == doctest::Approx(own[place(wheel, "normal_force")]));
  }
  CHECK(vertical == doctest::Approx(11000.0 * 9.81));
  // Left and right alike, but for the sign of what points sideways.
  double const* left = wheels;
  double const* right = wheels + wheel.size();
  CHECK(left[place(wheel, "lateral_force")] == doctest::Approx(-right[place(wheel, "lateral_force")]));
  CHECK(left[place(wheel, "rolling_radius")] == doctest::Approx(right[place(wheel, "rolling_radius")]));
  CHECK(row[row.size() - 1] == doctest::Approx(20.0));  // running speed
}
