// Dual numbers against complex-step derivatives (exact to round-off) and, where a function is not analytic, differences.
#include <doctest/doctest.h>

#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "rollerrig/math/dual.hpp"

using namespace rollerrig;
using Complex = std::complex<double>;

namespace {

double complex_step(std::function<Complex(Complex)> const& f, double x) { return f({x, 1e-30}).imag() / 1e-30; }

template <int N>
void check(std::string const& name, std::function<Dual<N>(Dual<N>)> const& ours,
           std::function<Complex(Complex)> const& exact) {
  CAPTURE(name);
  for (double x : {0.13, 0.5, 0.97}) {
    int const seed = N - 1;
    Dual<N> const y = ours(Dual<N>::variable(x, seed));
    CHECK(y.value == doctest::Approx(exact({x, 0.0}).real()).epsilon(1e-15));
    // A few operations, each right to the last digit.
    CHECK(y.d[seed] == doctest::Approx(complex_step(exact, x)).epsilon(1e-14));
    if (N > 1) CHECK(y.d[0] == 0.0);
  }
}

template <int N>
void check_all() {
  using D = Dual<N>;
  check<N>("+", [](D x) { return x + x * x + 2.0 + (3.0 + x); }, [](Complex x) { return x + x * x + 2.0 + (3.0 + x); });
  check<N>(
      "-", [](D x) { return -x - x * x - 2.0 - (3.0 - x); }, [](Complex x) { return -x - x * x - 2.0 - (3.0 - x); });
  check<N>("*", [](D x) { return x * x * 1.7 * (0.3 * x); }, [](Complex x) { return x * x * 1.7 * (0.3 * x); });
  check<N>("/", [](D x) { return (x + 1.0) / (x * x + 2.0); }, [](Complex x) { return (x + 1.0) / (x * x + 2.0); });
  check<N>("/ double", [](D x) { return x / 7.0 + 7.0 / x; }, [](Complex x) { return x / 7.0 + 7.0 / x; });
  check<N>("sqrt", [](D x) { return sqrt(x); }, [](Complex x) { return std::sqrt(x); });
  check<N>(
      "sin cos", [](D x) { return sin(x) * cos(2.0 * x); }, [](Complex x) { return std::sin(x) * std::cos(2.0 * x); });
  check<N>("log", [](D x) { return log(x) * x; }, [](Complex x) { return std::log(x) * x; });
  check<N>("asin", [](D x) { return asin(x); }, [](Complex x) { return std::asin(x); });
  check<N>(
      "compound",
      [](D x) {
        D y = x;
        y += D(2.0);
        y -= x * x;
        return y * x;
      },
      [](Complex x) { return (x + 2.0 - x * x) * x; });
}

}  // namespace

TEST_CASE("dual numbers differentiate arithmetic and elementary functions to round-off") {
  check_all<1>();
  check_all<3>();
  check_all<16>();
}

TEST_CASE("the derivative of atan2 in both arguments is that of the angle") {
  for (double angle : {-2.9, -1.0, 0.2, 1.57, 3.0}) {
    double const c = std::cos(angle), s = std::sin(angle);
    auto const a = atan2(Dual<2>::variable(2.0 * s, 0), Dual<2>::variable(2.0 * c, 1));
    CHECK(a.value == doctest::Approx(angle).epsilon(1e-15));
    CHECK(a.d[0] == doctest::Approx(c / 2.0).epsilon(1e-14));   // d angle / dy = x / r^2
    CHECK(a.d[1] == doctest::Approx(-s / 2.0).epsilon(1e-14));  // d angle / dx = -y / r^2
  }
}

TEST_CASE("comparison and selection look at the value only") {
  auto const small = Dual<2>::variable(1.0, 0), large = Dual<2>::variable(2.0, 1);
  CHECK(small < large);
  CHECK(large > small);
  CHECK(small < 1.5);
  CHECK(large > 1.5);
  auto const chosen = select(small < large, small, large);
  CHECK(chosen.d[0] == 1.0);
  CHECK(chosen.d[1] == 0.0);
}

TEST_CASE("a constant has no derivative") {
  Dual<16> const c(3.5);
  CHECK(c.value == 3.5);
  for (int i = 0; i < 16; ++i) CHECK(c.d[i] == 0.0);
  CHECK(value_of(c) == 3.5);
}
