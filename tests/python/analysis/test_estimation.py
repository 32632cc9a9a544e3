"""Least squares with intervals: against the closed form of a straight line, and on what cannot be determined."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import linregress, t

from rollerrig.analysis.estimation import Estimate, estimate, widening
from rollerrig.common.free_number import FreeNumber

X = np.linspace(0.0, 2.0, 21)


def line_fit(measured: np.ndarray, error: float = 1.0, *, known: bool = False, **changes: object) -> Estimate:
    """a + b x through measured values."""
    free = [FreeNumber("a", -10.0, 10.0), FreeNumber("b", -10.0, 10.0, **changes)]  # type: ignore[arg-type]

    def residuals(p: np.ndarray) -> np.ndarray:
        return (p[0] + p[1] * X - measured) / error

    return estimate(free, residuals, [0.0, 1.0], known=known)


def noisy(seed: int, error: float = 0.1) -> np.ndarray:
    return 1.0 + 2.0 * X + error * np.random.default_rng(seed).normal(size=len(X))


def test_a_straight_line_has_the_textbook_s_estimate_and_interval() -> None:
    measured = noisy(1)
    found, exact = line_fit(measured), linregress(X, measured)
    assert found.values["b"] == pytest.approx(exact.slope, rel=1e-6)
    assert found.errors["b"] == pytest.approx(exact.stderr, rel=1e-5)
    assert found.errors["a"] == pytest.approx(exact.intercept_stderr, rel=1e-5)
    half = t.ppf(0.975, len(X) - 2) * exact.stderr
    assert found.intervals["b"] == pytest.approx((exact.slope - half, exact.slope + half), rel=1e-5)
    assert found.correlations[0, 1] == pytest.approx(-X.mean() / np.sqrt(np.mean(X**2)), rel=1e-5)


def test_given_errors_decide_the_interval_whatever_is_left() -> None:
    found = line_fit(noisy(1, 0.1), error=0.2, known=True)
    assert found.errors["b"] == pytest.approx(0.2 / np.sqrt(np.sum((X - X.mean()) ** 2)), rel=1e-5)
    left = noisy(1, 0.1) - np.polyval(np.polyfit(X, noisy(1, 0.1), 1), X)
    assert found.deviation == pytest.approx(np.sqrt(np.sum(left**2) / (len(X) - 2)) / 0.2, rel=1e-6)


@pytest.mark.slow
def test_the_interval_has_the_truth_in_95_of_100_trials() -> None:
    """Of 400 trials 380 are expected, with a standard deviation of 4.4."""
    inside = 0
    for seed in range(400):
        low, high = line_fit(noisy(seed)).intervals["b"]
        inside += low <= 2.0 <= high
    assert 366 <= inside <= 394


def test_given_errors_that_cannot_be_widen_the_interval() -> None:
    """Errors of a fifth of the true ones: what is left decides."""
    found = line_fit(noisy(1, 0.1), error=0.02, known=True)
    assert found.errors["b"] == pytest.approx(line_fit(noisy(1, 0.1)).errors["b"], rel=1e-5)


def autoregressive(rng: np.random.Generator, follows: float, count: int) -> np.ndarray:
    """A series of standard deviation 1 in which neighbours are correlated."""
    return lfilter([np.sqrt(1.0 - follows**2)], [1.0, -follows], rng.normal(size=count + 1000))[1000:]


def test_residuals_that_follow_each_other_widen_the_interval() -> None:
    """About a line, 100 trials, of which 94 are expected; taken as independent the truth would be within in a third of them."""
    x, inside = np.linspace(0.0, 1.0, 100), {True: 0, False: 0}
    for seed in range(100):
        series = autoregressive(np.random.default_rng(seed), 0.9, len(x))
        for aware in inside:
            found = estimate(
                [FreeNumber("a", -10.0, 10.0), FreeNumber("b", -10.0, 10.0)],
                lambda p, series=series: p[0] + p[1] * x - 1.0 - 2.0 * x - series,
                [0.5, 2.5],
                known=False,
                widenings=(lambda left: np.full(len(left), widening(left, 2))) if aware else np.ones_like,
            )
            low, high = found.intervals["b"]
            inside[aware] += low <= 2.0 <= high
    assert inside[True] >= 88
    assert inside[False] <= 45


@pytest.mark.parametrize("follows", [0.0, 0.3, 0.6, 0.9, 0.97])
@pytest.mark.parametrize("count", [50, 300])
def test_the_interval_of_a_slope_holds_for_any_correlation(count: int, follows: float) -> None:
    """1000 series about a line in closed form; where they are short, a small correlation is not told from chance."""
    x = np.column_stack([np.ones(count), np.linspace(0.0, 1.0, count)])
    inverse, rng, inside = np.linalg.inv(x.T @ x), np.random.default_rng(0), 0
    for _ in range(1000):
        series = autoregressive(rng, follows, count)
        found = inverse @ x.T @ series
        left = series - x @ found
        factor = widening(left, 2)
        freedom = max(count / factor**2 - 2.0, 1.0)
        error = factor * np.sqrt(left @ left / count * (count / factor**2) / freedom * inverse[1, 1])
        inside += abs(found[1]) <= t.ppf(0.975, freedom) * error
    assert inside >= (840 if count == 50 and follows == 0.3 else 900)
    assert follows > 0.0 or inside <= 970


def test_a_prior_is_one_more_measurement() -> None:
    """Two measurements of b, each with its standard deviation: their mean weighted by 1/s²."""
    error = 0.5
    free_of_it = line_fit(noisy(3, error), error, known=True)
    spread, own = 0.1, free_of_it.errors["b"]
    found = line_fit(noisy(3, error), error, known=True, prior=(2.2, spread))
    weights = 1.0 / own**2, 1.0 / spread**2
    expected = (weights[0] * free_of_it.values["b"] + weights[1] * 2.2) / sum(weights)
    assert found.values["b"] == pytest.approx(expected, rel=1e-5)
    assert found.errors["b"] == pytest.approx(sum(weights) ** -0.5, rel=1e-5)


def test_a_logarithmic_number_has_an_interval_of_factors() -> None:
    """y = k: the logarithm's standard error is s/k."""
    free = [FreeNumber("k", 1.0, 1e4, logarithmic=True)]
    found = estimate(free, lambda p: np.full(4, (p[0] - 200.0) / 2.0), [50.0])
    assert found.values["k"] == pytest.approx(200.0, rel=1e-6)
    known = estimate(free, lambda p: np.array([-1, 1, -1, 1]) + (p[0] - 200.0) / 2.0, [50.0])
    low, high = known.intervals["k"]
    assert low * high == pytest.approx(known.values["k"] ** 2, rel=1e-6)
    assert known.errors["k"] == pytest.approx(1.0, rel=1e-3)
    assert known.values["k"] == pytest.approx(200.0, rel=1e-5)


def test_what_only_a_product_shows_is_named() -> None:
    free = [FreeNumber("a", 0.1, 10.0, True), FreeNumber("b", 0.1, 10.0, True), FreeNumber("c", -5.0, 5.0)]
    rng = np.random.default_rng(1)
    measured = 6.0 * X + 1.0 + 0.01 * rng.normal(size=len(X))
    found = estimate(free, lambda p: (p[0] * p[1] * X + p[2] - measured) / 0.01, [1.0, 1.0, 0.0])
    (text,) = found.undetermined
    assert text.startswith(("a with b: standard deviation", "b with a: standard deviation"))
    assert found.values["a"] * found.values["b"] == pytest.approx(6.0, rel=0.01)
    low, high = found.intervals["a"]
    assert high / low > 30.0  # not told from the range
    assert found.intervals["c"][1] - found.intervals["c"][0] < 0.05


def test_a_few_wrong_points_do_not_pull_with_a_robust_loss() -> None:
    measured = noisy(5, 0.02)
    measured[[3, 11]] += 5.0
    free = [FreeNumber("a", -10.0, 10.0), FreeNumber("b", -10.0, 10.0)]

    def residuals(p: np.ndarray) -> np.ndarray:
        return (p[0] + p[1] * X - measured) / 0.02

    assert abs(estimate(free, residuals, [0.0, 0.0]).values["a"] - 1.0) > 0.2
    assert estimate(free, residuals, [0.0, 0.0], loss="cauchy").values["a"] == pytest.approx(1.0, abs=0.03)


def test_an_estimate_at_the_end_of_its_range_is_named() -> None:
    free = [FreeNumber("a", 0.0, 0.5), FreeNumber("b", -10.0, 10.0)]
    found = estimate(free, lambda p: p[0] + p[1] * X - noisy(1), [0.1, 1.0])
    assert found.at_an_end == ["a"]


def test_fewer_points_than_numbers_are_refused() -> None:
    free = [FreeNumber(name, 0.0, 1.0) for name in "abc"]
    with pytest.raises(ValueError, match="2 points cannot determine 3 numbers"):
        estimate(free, lambda p: p[:2], [0.5] * 3)
