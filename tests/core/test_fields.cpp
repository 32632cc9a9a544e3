#include "rollerrig/fields.hpp"

#include <doctest/doctest.h>

#include <string>

using namespace rollerrig;

namespace {

struct Complete {
  double gain{1.0}, mass{2.0};
  std::optional<double> limit{};
  int steps{3};

  static constexpr auto fields() {
    return members(
        Member{"gain", &Complete::gain, "1", "gain"}, Member{"mass", &Complete::mass, "kg", "mass", positive},
        Member{"limit", &Complete::limit, "N", "largest force; absent: no limit"}, Member{"steps", &Complete::steps});
  }
};

struct Forgotten {
  double gain{};
  static constexpr auto fields() { return members(Member{"gain", &Forgotten::gain}); }
};

struct ForgottenOptional {
  std::optional<double> gain{};
  static constexpr auto fields() { return members(Member{"gain", &ForgottenOptional::gain, "1", ""}); }
};

// What the parameters of a plant demand of every struct that they are taken from.
static_assert(every_number_has_a_unit<Complete>);
static_assert(!every_number_has_a_unit<Forgotten>);
static_assert(!every_number_has_a_unit<ForgottenOptional>);

std::string refusal(Complete const& told) {
  try {
    check_fields(told, "Complete");
    return "";
  } catch (std::invalid_argument const& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("a refused number is named with its unit") {
  CHECK(refusal({}).empty());
  CHECK(refusal({.mass = -2.5}) == "Complete: mass must be positive, got -2.5 kg");
  CHECK(refusal({.gain = 1e70}) == "Complete: gain must be finite, got 1e+70");
}
