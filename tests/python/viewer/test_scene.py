"""What a page is given: frames whose error is the one it states, numbers of sixteen bits, contacts where the run has them."""

from __future__ import annotations

import base64
import gzip
import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.analysis.wheel_rail_forces import filtered, wheel_forces
from rollerrig.results import ResultsError
from rollerrig.viewer import view_text
from rollerrig.viewer.columns import MOST_FRAMES, WHOLE, Columns, interpolated, thinned
from rollerrig.viewer.live import LiveRun
from rollerrig.viewer.parts import outline
from rollerrig.viewer.scene import ALLOWED, mode_scene, model_of, run_scene


def test_a_straight_line_is_drawn_exactly() -> None:
    times = np.linspace(0.0, 1.0, 6)
    at = np.linspace(0.0, 1.0, 51)
    values = np.column_stack([3.0 * times - 1.0, 5.0 - times])
    np.testing.assert_allclose(interpolated(times, values, at), np.column_stack([3.0 * at - 1.0, 5.0 - at]), atol=1e-14)


def test_frames_keep_to_the_allowed_error_and_are_few() -> None:
    times = np.linspace(0.0, 10.0, 10001)
    swing = 5.0 * np.sin(2 * np.pi * 7.0 * times)[:, None]
    index, errors = thinned(times, {"position_mm": swing}, {"position_mm": 0.05})
    assert len(index) < len(times) / 5
    assert errors["position_mm"] <= 0.05
    drawn = interpolated(times[index], swing[index], times)
    assert np.abs(drawn - swing).max() == pytest.approx(errors["position_mm"])
    assert index[-1] == len(times) - 1


def test_no_more_frames_than_a_page_opens_quickly_with_and_their_error_is_said() -> None:
    times = np.linspace(0.0, 60.0, 60001)
    swing = np.sin(2 * np.pi * 200.0 * times)[:, None]
    index, errors = thinned(times, {"position_mm": swing}, {"position_mm": 0.05})
    assert len(index) <= MOST_FRAMES + 1
    assert errors["position_mm"] > 0.5


def test_a_column_is_kept_to_half_a_step_and_gaps_stay_gaps() -> None:
    values = np.array([-3.0, 1.0, np.nan, 7.0, 6.9999])
    columns = Columns()
    columns.add("first", np.arange(5.0), exact=True)
    columns.add("second", values)
    start, count, kind, factor, offset = columns.places["second"]
    assert (kind, start % 4) == ("h", 0)
    raw = np.frombuffer(gzip.decompress(base64.b64decode(columns.text())), "<i2", count, start)
    decoded = np.where(raw == -WHOLE - 1, np.nan, offset + factor * raw)
    np.testing.assert_allclose(decoded, values, atol=10.0 / 2 / WHOLE / 2 * 1.001)


@pytest.mark.parametrize("name", ["on_rig", "in_curve"])
def test_every_recorded_patch_has_its_place(name: str, request: pytest.FixtureRequest) -> None:
    run: xr.Dataset = request.getfixturevalue(name)
    scene = run_scene(run)
    model = model_of(run)
    places = decoded(scene.columns)
    patches = places["w0.p0.normal"]
    assert np.isfinite(places["w0.p0.x"]).mean() > 0.99
    for wheel, side in ((0, 1.0), (1, -1.0)):
        y, rail = places[f"w{wheel}.p0.y"], places[f"w{wheel}.p0.rail_abscissa"]
        there = np.isfinite(y)
        off = np.abs(y - side * (model.rail_origin_y + rail))[there]  # core's point, recorded abscissa
        assert off.max() < 0.2e-3
    assert patches.min() > 0
    peak = places["w0.p0.peak_pressure"]
    assert (peak.min(), peak.max()) > (1e8, 1e8)
    assert peak.max() < 4e9


@pytest.mark.parametrize("name", ["on_rig", "on_track", "in_curve"])
def test_the_stated_errors_are_within_what_is_allowed(name: str, request: pytest.FixtureRequest) -> None:
    head = run_scene(request.getfixturevalue(name)).head
    assert head["frames"] < head["samples"]
    for quantity, allowed in ALLOWED.items():
        assert head["errors"][quantity] <= allowed


CASES = sorted(path.stem for path in (Path(rr.__file__).parent / "catalog" / "cases").glob("*.toml"))


@pytest.mark.parametrize("name", CASES)
def test_every_case_of_the_catalogue_can_be_seen_and_played(name: str) -> None:
    case = rr.load_case(name)
    text = view_text([rr.simulate(case.with_changes({"time.duration": "0.2 s"}))])
    assert "NaN" not in text[text.index("application/json") :].partition("</script>")[0]
    run = LiveRun(case)
    run.advance(0.1)
    frame = json.loads(json.dumps(run.frame(), allow_nan=False))
    assert len(frame["values"]) == len(run.scene["live"]["columns"])


def test_a_run_whose_last_sample_is_not_finite_can_be_seen(on_track: xr.Dataset) -> None:
    broken = on_track.copy(deep=True)
    for name in broken.data_vars:
        if broken[name].dims[:1] == ("time",) and name != "patch_count":
            broken[name][-1] = np.nan
    assert "NaN" not in view_text([broken]).partition('id="scene">')[2].partition("</script>")[0]


@pytest.mark.parametrize("name", ["on_rig", "in_curve"])
def test_plotted_forces_are_those_of_the_report(name: str, request: pytest.FixtureRequest) -> None:
    """Outwards on either side and through 20 Hz, at times at which their extremes lie; said on the axis."""
    run: xr.Dataset = request.getfixturevalue(name)
    scene = run_scene(run, most=500)
    group = next(one for one in scene.head["plots"] if one["title"] == "Guiding force Y")
    assert group["note"] == "outwards, low pass 20 Hz"
    numbers, report = decoded(scene.columns), filtered(wheel_forces(run))["guiding_force"]
    times = numbers[group["times"]]
    assert 2 <= len(times) <= 500
    for (column, _, factor), wheel in zip(group["curves"], report["wheel"].to_numpy(), strict=True):
        known = 1e-3 * report.sel(wheel=wheel).dropna("time")  # not at the ends of the run
        drawn, whole = factor * numbers[column], known.to_numpy()
        step = np.ptp(whole) / (2 * WHOLE)
        assert (np.nanmin(drawn), np.nanmax(drawn)) == (
            pytest.approx(whole.min(), abs=step),
            pytest.approx(whole.max(), abs=step),
        )
        inside = (times >= float(known["time"][0])) & (times <= float(known["time"][-1]))
        assert (np.isfinite(drawn) == inside).all()
        between = np.interp(times[inside], known["time"], whole)
        assert drawn[inside] == pytest.approx(between, abs=0.02 * np.abs(whole).max() + step)


def test_a_simulation_that_goes_on_has_the_same_sign(on_rig: xr.Dataset) -> None:
    head = LiveRun(rr.load_case("bogie_rollers_constant")).scene
    group = next(one for one in head["plots"] if one["title"] == "Guiding force Y")
    assert group["note"] == "outwards, unfiltered"
    assert [factor for _, _, factor in group["curves"]] == [-1e-3, 1e-3, -1e-3, 1e-3]
    assert "times" not in group


def test_a_rig_has_no_line_and_a_curve_has(on_rig: xr.Dataset, in_curve: xr.Dataset) -> None:
    assert run_scene(on_rig).head["line"] is None
    line = run_scene(in_curve).head["line"]
    assert max(line["cant"]) > 0.1  # the right rail is raised in a curve to the left
    assert line["heading"][-1] > 0.1


def test_few_points_draw_the_profile(on_rig: xr.Dataset) -> None:
    profile = model_of(on_rig).wheel_profile
    points = np.array(outline(profile))
    assert 20 < len(points) < 200
    y = profile.outline[:, 0]
    order = np.argsort(y)
    inside = (y[order] > profile.domain[0]) & (y[order] < profile.domain[1])
    drawn = np.interp(y[order][inside], points[:, 0], points[:, 1])
    assert np.abs(drawn - profile.outline[order][inside, 1]).max() < 0.2e-3  # 0.03 mm across, more along steep flanks


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda run: run.drop_vars("lateral"), r"no motion of bodies \(lateral\); view takes the run.nc of a run"),
        (lambda run: run.drop_vars("speed"), r"no motion of bodies \(speed\)"),
        (lambda run: run.drop_vars("patch_normal"), r"no motion of bodies \(patch_normal\)"),
        (lambda run: run.drop_vars("element_force_y"), r"no motion of bodies \(element_force_y\)"),
        (
            lambda run: run.assign(yaw=run["yaw"].where(run["body"] != "wheelset_1", 1e300)),
            "no wheel can stand where these results have one",
        ),
        (lambda run: run.isel(time=[0]), "fewer than two samples"),
        (lambda run: run.assign_attrs(config_toml="[motion"), "the case of these results cannot be read"),
        (lambda run: run.assign_attrs(run_info="{}"), "results of another version of rollerrig"),
    ],
)
def test_results_that_cannot_be_shown_are_refused(change: object, message: str, on_rig: xr.Dataset) -> None:
    with pytest.raises(ResultsError, match=message):
        run_scene(change(on_rig))  # type: ignore[operator]


def decoded(columns: Columns) -> dict[str, np.ndarray]:
    raw = gzip.decompress(base64.b64decode(columns.text()))
    found = {}
    for name, (start, count, kind, factor, offset) in columns.places.items():
        values = np.frombuffer(raw, "<f4" if kind == "f" else "<i2", count, start)
        found[name] = values if kind == "f" else np.where(values == -WHOLE - 1, np.nan, offset + factor * values)
    return found


def test_modes_are_drawn_with_their_amplitudes_and_phases() -> None:
    modes = rr.stability("wheelset_rollers", [60.0, 120.0])
    head = mode_scene(modes).head
    assert [one["name"] for one in head["modes"]] == modes["mode"].to_numpy().tolist()
    for one in head["modes"]:
        found = modes.sel(mode=one["name"]).isel(speed=1)
        shape, largest = one["shapes"][1], float(found["shape_amplitude"].max())
        assert max(amplitude for amplitude, _ in shape.values()) == pytest.approx(1.0)
        for column, (amplitude, phase) in shape.items():
            body, name = column.split(".")
            place = {"body": head["bodies"][int(body[1:])]["name"], "direction": name}
            assert amplitude == pytest.approx(float(found["shape_amplitude"].sel(place)) / largest, abs=1e-5)
            assert phase == pytest.approx(np.radians(float(found["shape_phase"].sel(place))), abs=1e-4)
    with pytest.raises(ResultsError, match="view takes them alone"):
        view_text([modes, modes])


def test_two_runs_of_one_case_are_told_apart(on_rig: xr.Dataset, on_track: xr.Dataset) -> None:
    from rollerrig.viewer.page import _names

    case = rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "10 ms", "motion.speed": "260 km/h"})
    assert _names([on_rig, on_track]) == ["bogie_rollers_constant", "bogie_track"]
    assert _names([on_rig, rr.simulate(case)]) == [f"bogie_rollers_constant, {speed} km/h" for speed in (150, 260)]
    assert _names([on_rig, on_rig]) == ["bogie_rollers_constant, run 1", "bogie_rollers_constant, run 2"]
