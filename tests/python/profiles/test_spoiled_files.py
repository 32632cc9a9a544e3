"""Files of points that are spoiled: each is refused in one line that says what is wrong where, or gives a profile."""

import random
import warnings

import numpy as np
import pytest

from catalogued import profile_table
from rollerrig.config import ConfigError, load_profile
from rollerrig.config.errors import show_value
from rollerrig.profiles import ProfileError, profile_from_spec

from .test_measured import PLAIN, SIMPACK, rail_points, simpack, wheel_points, write

POINTS = {"wheel": wheel_points(0.5), "rail": rail_points(0.5)}


def problem_of(path, kind="wheel", **keys):
    with pytest.raises(ProfileError) as error:
        profile_from_spec({"kind": "file", "path": str(path), **keys}, kind)
    assert "\n" not in str(error.value)
    return str(error.value)


def spoiled(kind, deed):
    points = POINTS[kind].copy()
    middle = len(points) // 2
    match deed:
        case "spike":
            points[middle, 1] += 100.0
        case "kilometre":
            points[middle, 1] += 1e6
        case "sideways":
            points[middle, 0] += 100.0
        case "kink":
            points[middle:, 1] += 0.3 * (points[middle:, 0] - points[middle, 0])
        case "step":
            points[middle:, 1] += 8.0
        case "half":
            points = points[:middle]
        case "other half":
            points = points[middle:]
        case "closed":
            points = np.vstack([points, points[::-1] - [0.0, 30.0]])
        case "shuffled":
            points = np.random.default_rng(1).permutation(points)
    return points


@pytest.mark.parametrize("kind", ["wheel", "rail"])
@pytest.mark.parametrize(
    "deed", ["spike", "kilometre", "sideways", "kink", "step", "half", "other half", "closed", "shuffled"]
)
def test_a_spoiled_profile_is_refused_with_what_is_wrong(tmp_path, kind, deed):
    problem = problem_of(write(tmp_path / "points.txt", spoiled(kind, deed)), kind)
    place = "tape circle" in problem or "no flange" in problem  # half a wheel: what is missing has no line
    assert "line " in problem or place, problem
    if deed in ("spike", "kilometre", "sideways"):
        assert f"line {len(POINTS[kind]) // 2 + 1}, " in problem
        assert "a stray point" in problem


@pytest.mark.parametrize(
    ("size", "words"),
    [
        (0.1, ("not smooth: the direction jumps by", "near line 13", "round the edge off, or remove stray points")),
        (2.0, ("steeper than 5 at line 13", "is there a step or a stray point")),
    ],
)
@pytest.mark.parametrize("deed", ["spike", "step"])
def test_a_small_spike_or_step_is_named_with_its_line(tmp_path, deed, size, words):
    points = POINTS["wheel"].copy()  # every 0.46 mm
    points[slice(135, 136 if deed == "spike" else None), 1] += size
    problem = problem_of(write(tmp_path / "points.txt", points))
    assert all(word in problem for word in words), problem


def test_of_a_closed_rail_section_only_the_head_is_used(tmp_path):
    points = POINTS["rail"]
    section = np.vstack([points, points[::-1] - [0.0, 30.0], points[:1]])
    closed, alone = (
        profile_from_spec({"kind": "file", "path": str(write(tmp_path / name, rows))}, "rail")
        for name, rows in (("closed.txt", section), ("open.txt", points))
    )
    y = np.linspace(-38e-3, 25e-3, 200)
    assert np.max(np.abs(closed.evaluate(y) - alone.evaluate(y))) < 1e-7  # they end otherwise: the smoothing feels it


def test_a_spoiled_profile_of_a_case_names_the_case_too(tmp_path):
    path = write(tmp_path / "points.txt", spoiled("rail", "closed"))
    with pytest.raises(ConfigError) as error:
        load_profile(str(path), "rail")
    assert str(error.value).startswith(f"{path}: {show_value(str(path))}; ")


@pytest.mark.parametrize(("separator", "shown"), [(" ", " "), (";", ";"), ("\t", "\\t")])
def test_decimal_commas_are_recognised(tmp_path, separator, shown):
    path = tmp_path / "points.txt"
    path.write_text("\n".join(f"{y:.2f}{separator}{z:.2f}".replace(".", ",") for y, z in POINTS["wheel"]))
    assert f"line 1: '-62,00{shown}25,75' has decimal commas; allowed: decimal points" in problem_of(path)


def test_semicolons_between_columns_are_told(tmp_path):
    assert "a semicolon begins a comment" in problem_of(write(tmp_path / "p.txt", POINTS["wheel"], ";"))


def test_a_header_in_another_unit_names_the_key_that_leaves_no_points(tmp_path):
    path = simpack(tmp_path / "wheel.prw", POINTS["wheel"] / 1e3, low=-60, high=-20)
    assert "bound.y.min = -60 and bound.y.max = -20 leaves 0 of 269 points of points from -0.062 to 0.06" in problem_of(
        path
    )
    path.write_text(path.read_text().replace("    point.begin", "    point.dist.min = 0.5\n    point.begin"))
    problem = problem_of(path)
    assert "point.dist.min = 0.5, in the unit of the points, leaves 1 of 269 points" in problem
    assert "are header and points in the same unit?" in problem


@pytest.mark.slow
def test_many_points_are_averaged_and_said_and_very_many_refused(tmp_path):
    table = profile_from_spec(
        {"kind": "file", "path": str(write(tmp_path / "wheel.txt", wheel_points(0.003)))}, "wheel"
    )
    assert "44879 points averaged by 3" in table.source
    s = np.linspace(-50e-3, 50e-3, 101)
    assert np.max(np.abs(table.evaluate(s) - profile_table("s1002", "wheel").evaluate(s))) < 5e-7
    path = tmp_path / "points.txt"
    path.write_text("0.1 0.2\n" * 200_000)
    assert "200000 lines; allowed: 100000" in problem_of(path)


def spoiled_once(rng, p):
    """Points (n, 2) after one deed of many."""
    i, j = sorted(rng.sample(range(len(p)), 2))
    size = rng.choice([1e-3, 1.0, 30.0, 1e4, 1e300, 1e308]) * rng.choice([-1.0, 1.0])
    deeds = (
        lambda: p[i:j],
        lambda: np.delete(p, np.s_[i:j], axis=0),
        lambda: np.vstack([p[:i], p[i:j][::-1], p[j:]]),
        lambda: np.vstack([p, p[::-1] + [0.0, size]]),
        lambda: np.vstack([p, p]),
        lambda: p + np.eye(len(p), 1, -i) * [[0.0, size]],
        lambda: p + np.eye(len(p), 1, -i) * [[size, 0.0]],
        lambda: p + (np.arange(len(p)) >= i)[:, None] * [0.0, size],
        lambda: p * [1.0, size],
        lambda: p * [0.0, 1.0],
        lambda: p[np.argsort(p[:, 1])],
        lambda: np.repeat(p, 2, axis=0),
    )
    with np.errstate(all="ignore"):
        return rng.choice(deeds)()


def mutant(rng, kind):
    """A file of points, spoiled in one to four ways, and keys to read it with."""
    points = POINTS[kind][:: rng.choice([1, 2, 4])] * rng.choice([1.0, 1e-3])
    for _ in range(rng.randint(0, 2)):
        points = spoiled_once(rng, points) if len(points) > 2 else points
    head, columns = rng.choice([("", " "), ("S z\n", ", "), ("# x\n", "\t")])
    text = head + "\n".join(columns.join(f"{x:.7g}" for x in row) for row in points) + "\n"
    if rng.random() < 0.3:
        header = {**PLAIN, rng.choice(list(PLAIN)): rng.choice([0, 1, -1, 1e9, 1e-9, "x", "", "nan"])}
        text = SIMPACK.format(**header, factor=rng.choice([1.0, 1e3, 0, 1e300, 1e-300]), points=text)
    for _ in range(rng.choice([0, 0, 1, 2])):
        at = rng.randrange(len(text))
        text = (
            text[:at]
            + rng.choice(["", ",", ";", "-", "e9", "\n", "nan", "\x00", "point.end\n", "1 2 3", "é"])
            + text[at + rng.randint(0, 3) :]
        )
    keys = {
        "units": rng.choice(["auto", "auto", "mm", "m"]),
        "inner_side": rng.choice(["auto", "auto", "negative", "positive"]),
        "z_positive": rng.choice(["auto", "auto", "up", "down"]),
        "tape_circle": rng.choice([0.0, 0.0, 0.07, -1.0]),
        "require_flange": rng.random() < 0.5,
        "smoothing": rng.choice(["auto", "auto", 1e-5, 0.05]),
        "step": rng.choice([0.05e-3, 1e-3]),
    }
    return text, keys if kind == "wheel" else {**keys, "inclination": rng.choice([0.0, 0.2, -0.2])}


@pytest.mark.parametrize("seed", range(6))
def test_any_file_gives_a_profile_or_a_profile_error(tmp_path, seed):
    rng = random.Random(seed)
    path = tmp_path / "points.txt"
    for _ in range(40):
        kind = rng.choice(["wheel", "rail"])
        text, keys = mutant(rng, kind)
        path.write_text(text)
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            try:
                table = profile_from_spec({"kind": "file", "path": str(path), **keys}, kind)
            except ProfileError:
                continue
        assert np.all(np.isfinite(table.coefficients))
        # cut off where it is steeper than 5; knots 1 mm apart overshoot by a twelfth at such an end
        assert np.all(np.abs(table.evaluate(np.linspace(*table.domain, 200), 1)) <= 5.5)
