#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <utility>

#include "models.hpp"
#include "rollerrig/plant/byte_stream.hpp"
#include "rollerrig/plant/plant.hpp"

using namespace rollerrig;

namespace {

using Method = integrate::Method;

/// All variables at every multiple of 1 ms between two times; inputs change on the way.
std::vector<double> drive(Plant& plant, int from, int to) {
  std::vector<double> course;
  int const friction = plant.find("body_0_left.friction_change"), demand = plant.find("axle_1.brake_demand");
  for (int k = from; k < to; ++k) {
    if (k % 10 == 5) REQUIRE(plant.set_input(friction, -0.8 + 0.1 * (k / 10 % 3)));
    if (k % 20 == 7 && demand >= 0) REQUIRE(plant.set_input(demand, 1e4 * (k / 20 % 4)));
    REQUIRE(plant.advance(1e-3 * (k + 1)) == Status::ok);
    for (int i = 0; i < static_cast<int>(plant.variables().size()); ++i) course.push_back(plant.get(i));
  }
  return course;
}

bool same_bits(std::vector<double> const& a, std::vector<double> const& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

AssembledModel with_method(AssembledModel assembled, Method method) {
  assembled.options.method = method;
  bool const free = method == Method::dormand_prince || method == Method::rodas4;
  assembled.options.step = free ? 0.0 : method == Method::exponential_adams ? 1e-3 : 1e-4;
  return assembled;
}

}  // namespace

TEST_CASE("going on from a saved state gives the same bits as never having stopped, with every method") {
  for (AssembledModel const& model : {test::assembled(test::small_parts(false)), test::braked()})
    for (Method const method :
         {Method::rk4, Method::exponential_rk4, Method::exponential_adams, Method::dormand_prince, Method::rodas4}) {
      CAPTURE(static_cast<int>(method));
      AssembledModel const assembled = with_method(model, method);
      Plant whole(assembled);
      REQUIRE(whole.start(1.0) == Status::ok);
      drive(whole, 0, 37);
      auto const state = whole.save();
      auto const expected = drive(whole, 37, 80);

      REQUIRE(whole.restore(state));  // back in the same plant
      CHECK(whole.time() == doctest::Approx(0.037));
      CHECK(same_bits(drive(whole, 37, 80), expected));

      Plant other(assembled);  // in one that has not begun
      REQUIRE(other.restore(state));
      CHECK(same_bits(drive(other, 37, 80), expected));

      Plant busy(assembled);  // in one that is elsewhere
      REQUIRE(busy.start(1.0) == Status::ok);
      drive(busy, 0, 11);
      REQUIRE(busy.restore(state));
      CHECK(same_bits(drive(busy, 37, 80), expected));
    }
}

TEST_CASE("a state that is cut, changed or of another model is refused and changes nothing") {
  Plant plant(test::braked());
  CHECK(plant.save().empty());
  REQUIRE(plant.start(1.0) == Status::ok);
  drive(plant, 0, 10);
  auto state = plant.save();
  Plant untouched(test::braked());
  REQUIRE(untouched.restore(state));
  for (std::size_t size = 0; size < state.size(); size += 1 + size / 64)
    REQUIRE_FALSE(plant.restore(std::span(state).first(size)));
  for (std::size_t i = 0; i < state.size(); i += 1 + i / 64) {
    state[i] ^= std::byte{0x10};
    REQUIRE_FALSE(plant.restore(state));
    state[i] ^= std::byte{0x10};
  }
  Plant another(test::assembled(test::small_parts(true)));
  CHECK_FALSE(another.restore(state));
  CHECK(same_bits(drive(plant, 10, 20), drive(untouched, 10, 20)));
}

TEST_CASE("a state that was changed and given the right checksum is refused, or goes on; refused, it changes nothing") {
  Plant plant(test::braked());
  REQUIRE(plant.start(1.0) == Status::ok);
  drive(plant, 0, 10);
  auto const sound = plant.save();
  constexpr std::size_t head = 2 * sizeof(std::uint64_t);
  std::uint64_t model = 0;
  std::memcpy(&model, sound.data(), sizeof model);
  int refused = 0, taken = 0;
  for (std::uint64_t const number : {std::uint64_t{1} << 40, ~std::uint64_t{0}, std::uint64_t{0x7FF8000000000000}})
    for (std::size_t i = head; i + sizeof number <= sound.size(); i += 8 + sound.size() / 512) {
      auto changed = sound;
      std::memcpy(changed.data() + i, &number, sizeof number);
      std::uint64_t const crc = crc64(std::span(std::as_const(changed)).subspan(head), model);
      std::memcpy(changed.data() + sizeof crc, &crc, sizeof crc);
      bool const good = plant.restore(changed);
      ++(good ? taken : refused);
      if (good)
        plant.advance(0.012);
      else
        REQUIRE(plant.save() == sound);
      REQUIRE(plant.restore(sound));
    }
  CHECK(refused > 100);
  CHECK(taken > 10);
}

TEST_CASE("after a step of next to nothing the next one does not take for ever") {
  Plant plant(with_method(test::assembled(test::small_parts(false)), Method::exponential_adams));
  REQUIRE(plant.start(1.0) == Status::ok);
  REQUIRE(plant.set_input(plant.find("body_0_left.friction_change"), -0.5));
  REQUIRE(plant.advance(1e-300) == Status::ok);
  REQUIRE(plant.advance(0.002) == Status::ok);
  CHECK(plant.driver().statistics().steps < 1000);
}
