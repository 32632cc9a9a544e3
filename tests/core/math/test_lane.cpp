#include "rollerrig/math/lane.hpp"

#include <doctest/doctest.h>

#include "rollerrig/contact/creep/creep_query.hpp"
#include "rollerrig/math/vector.hpp"

using namespace rollerrig;

namespace {

template <int W>
Lanes<W> ramp(double start, double step) {
  std::array<double, static_cast<std::size_t>(W)> x;
  for (int i = 0; i < W; ++i) x[static_cast<std::size_t>(i)] = start + step * i;
  if constexpr (W == 1)
    return x[0];
  else
    return Lanes<W>::load(x.data());
}

}  // namespace

static_assert(std::same_as<Lanes<1>, double>);

#if ROLLERRIG_LANES
static_assert(Scalar<Lanes<2>> && Scalar<Lanes<4>> && Scalar<Lanes<8>>);
static_assert(!std::convertible_to<double, Lanes<4>>);

TEST_CASE_TEMPLATE("arithmetic acts on every lane as on a double", L, Lanes<2>, Lanes<4>, Lanes<8>) {
  constexpr int W = lanes_of<L>;
  L const a = ramp<W>(-1.3, 0.7);
  L const b = ramp<W>(2.1, -0.45);
  L c = a;
  c += b;
  L d = a;
  d -= b;
  for (int i = 0; i < W; ++i) {
    double const x = a[i], y = b[i];
    CHECK((a + b)[i] == x + y);
    CHECK((a - b)[i] == x - y);
    CHECK((a * b)[i] == x * y);
    CHECK((a / b)[i] == x / y);
    CHECK((-a)[i] == -x);
    CHECK((2.0 * a)[i] == 2.0 * x);
    CHECK((a * 2.0)[i] == 2.0 * x);
    CHECK((2.0 / a)[i] == 2.0 / x);
    CHECK((a / 3.0)[i] == x / 3.0);
    CHECK((1.0 - a)[i] == 1.0 - x);
    CHECK((a - 1.0)[i] == x - 1.0);
    CHECK((1.0 + a)[i] == 1.0 + x);
    CHECK((a + 1.0)[i] == x + 1.0);
    CHECK(c[i] == x + y);
    CHECK(d[i] == x - y);
    CHECK(abs(a)[i] == std::abs(x));
    CHECK(sqrt(abs(a))[i] == std::sqrt(std::abs(x)));
    CHECK(min(a, b)[i] == std::min(x, y));
    CHECK(max(a, b)[i] == std::max(x, y));
    CHECK(exp(a)[i] == std::exp(x));
    CHECK(log(abs(a))[i] == std::log(std::abs(x)));
    CHECK(sin(a)[i] == std::sin(x));
    CHECK(cos(a)[i] == std::cos(x));
    CHECK(atan2(a, b)[i] == std::atan2(x, y));
  }
}

TEST_CASE_TEMPLATE("select chooses in each lane, and masks combine", L, Lanes<2>, Lanes<4>, Lanes<8>) {
  constexpr int W = lanes_of<L>;
  L const a = ramp<W>(-1.0, 1.25);
  auto const negative = a < 0.0;
  auto const small = !(a > 0.5);
  L const chosen = select(negative, L(1.0), select(small && !negative, L(2.0), L(3.0)));
  for (int i = 0; i < W; ++i) CHECK(chosen[i] == (a[i] < 0.0 ? 1.0 : a[i] > 0.5 ? 3.0 : 2.0));
  CHECK(any(negative));
  CHECK_FALSE(all(negative));
  CHECK(all(negative || a > -1.0));
}

TEST_CASE_TEMPLATE("tables are read lane by lane", L, Lanes<2>, Lanes<4>, Lanes<8>) {
  constexpr int W = lanes_of<L>;
  std::array<double, 16> table;
  for (std::size_t i = 0; i < 16; ++i) table[i] = 1.0 / (1.0 + static_cast<double>(i));
  L const place = ramp<W>(1.9, 1.7);
  auto const i = truncated(place);
  L const read = gather(table.data(), i);
  for (int k = 0; k < W; ++k) {
    CHECK(index_in(i, static_cast<std::size_t>(k)) == static_cast<int>(std::floor(place[k])));
    CHECK(read[k] == table[static_cast<std::size_t>(place[k])]);
  }
  CHECK(gather(table.data(), truncated(3.9)) == table[3]);
  CHECK(truncated(3.9) == 3);
}

TEST_CASE_TEMPLATE("a formula of the contact runs in lanes as it stands", L, Lanes<2>, Lanes<4>, Lanes<8>) {
  constexpr int W = lanes_of<L>;
  L const tau = ramp<W>(0.2, 1.1);  // both branches of (23)
  L const force = johnson_vermeulen(tau);
  for (int i = 0; i < W; ++i) CHECK(force[i] == doctest::Approx(johnson_vermeulen(tau[i])).epsilon(1e-15));
}
#endif
