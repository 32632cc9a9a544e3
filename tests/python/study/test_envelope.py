"""The envelope map: limits told apart, borders where closed forms put them, runs that survive whatever ends the program."""

from __future__ import annotations

import csv
import json
import math
import shutil
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from called import called
from reported import unexplained
from rollerrig import ConfigError, StartError, _core, envelope, load_case, simulate
from rollerrig.analysis.envelope_borders import Border, borders, slides
from rollerrig.analysis.rig_limits import NUMBERS, assess_limits, closed_forms, persists_since, rig_limits
from rollerrig.analysis.virtual_rail import Patch, creep_curve, creep_peak, grip_slip, patch_of
from rollerrig.assembly.model import assemble
from rollerrig.config import Case
from rollerrig.results.run_info import describe
from rollerrig.study.checkpoint import NAME
from rollerrig.study.envelope import EnvelopeStudy
from rollerrig.study.runs import envelope as envelope_points
from rollerrig.study.runs.envelope import BEGIN, RISE, Point, point_case

COULOMB = {"adhesion": {"rail": {"friction": 0.1}}}
ELLIPSES = {"contact.normal": "hertz"}
SMALL = {"torques": [-4e3, -2e3], "adhesions": [0.05, 0.3], "loads": [1.0], "duration": 0.8, "refine": 0}


@pytest.fixture(scope="module")
def case() -> Case:
    return load_case("adhesion_brake")


@pytest.fixture(scope="module")
def small(case: Case, tmp_path_factory: pytest.TempPathFactory) -> tuple[xr.Dataset, Path]:
    """A map of four runs with ellipses, none of its keeping is the contact's; and the folder with them, to be copied."""
    folder = tmp_path_factory.mktemp("small")
    return envelope(case.with_changes(ELLIPSES), **SMALL, folder=folder), folder


@pytest.fixture(scope="module")
def coulomb(case: Case) -> Case:
    """On a rail whose friction does not fall with slip the closed forms hold at any slip."""
    return case.with_changes(COULOMB)


# ------------------------------------------------------------------------------------------ what limited a run

SPEED, RADIUS, GRIPS = 30.0, 0.46, 0.03


def test_the_creep_curve_of_low_peaks_where_the_pages_say(case: Case) -> None:
    """docs/theory/adhesion.md and docs/studies/adhesion.md: 0.068 of the load at 2.2 % slip, 98 % of it from 1.4 to 3.7 %."""
    slip = np.linspace(1e-3, 0.06, 5901)
    for law, peak, at in (("polach", 0.068, 0.022), ("kalker_saturated", 0.079, 0.005)):
        one = case if law == case.contact.creep.kind else case.with_changes({"contact.creep": law})
        force = creep_curve(one, patch_of(assemble(one)), 0.08, slip)[1]
        assert (round(float(force.max()), 3), round(float(slip[force.argmax()]), 3)) == (peak, at)
        if law == "polach":
            near = slip[force >= 0.98 * force.max()]
            assert [round(float(end), 3) for end in near[[0, -1]]] == [0.014, 0.037]


def made_up_run(status: str = "ok", **values: object) -> xr.Dataset:
    """A run of 1 s that does nothing but what is given: a number, or a function of time, for the leading axle."""
    t = np.arange(0.0, 1.0001, 0.005)

    def over_time(name: str, otherwise: float) -> np.ndarray:
        value = values.get(name, otherwise)
        return np.stack([value(t) if callable(value) else np.full_like(t, value), np.full_like(t, otherwise)], axis=1)

    slip, error = over_time("slip", 0.0), over_time("error", 0.0)
    axle = {
        "virtual_speed": SPEED / RADIUS * (1.0 + slip),
        "axle_speed": SPEED / RADIUS * (1.0 + slip + error),
        "roller_command": over_time("command", 0.0),
        "roller_torque": over_time("command", 0.0),
        "roller_speed": np.full((len(t), 2), SPEED / 0.725),
        "real_sliding": np.zeros((len(t), 2)),
        "contact_force": np.full((len(t), 2), -1e4),
        "brake_torque": over_time("brake", -5e3),
        "virtual_force": np.full((len(t), 2), -1e4),
        "traction_torque": np.zeros((len(t), 2)),
    }
    normal = np.full((len(t), 4, 1), 5e4)
    used = np.repeat(over_time("used", 0.1), 2, axis=1)[..., None]
    wheel = ("time", "wheel", "patch")
    variables = {name: (("time", "axle"), value) for name, value in axle.items()}
    variables |= {
        "train_speed": ("time", np.full_like(t, SPEED)),
        "vertical_force": (("time", "wheel"), normal[..., 0]),
    }
    variables |= {
        "patch_normal": (wheel, normal),
        "patch_creep_force_x": (wheel, 0.3 * used * normal),
        "patch_creep_force_y": (wheel, 0.0 * normal),
    }
    info = describe(assemble(load_case("adhesion_brake"))).to_json()
    attributes = {"status": status, "status_message": "", "stopped_at_s": 1.0, "run_info": info}
    wheelsets = ["wheelset_1", "wheelset_2"]
    return xr.Dataset(variables, {"time": t, "axle": wheelsets, "body": ["front_frame", *wheelsets]}, attributes)


def between(begin: float, end: float, value: float, otherwise: float = 0.0):
    return lambda t: np.where((t > begin - 1e-9) & (t < end - 1e-9), value, otherwise)


@pytest.mark.parametrize(
    ("values", "region"),
    [
        ({}, "grip"),
        ({"slip": -0.1}, "slide"),
        ({"slip": between(0.5, 0.6, -0.9999)}, "held"),
        ({"slip": between(0.5, 0.52, -0.9999)}, "slide"),  # for less than LEAST_DURATION
        ({"error": 0.02}, "tracking"),
        ({"used": between(0.5, 0.6, 0.99)}, "contact"),
        ({"command": between(0.5, 0.6, -2e4), "slip": -0.1}, "drive_slide"),
        ({"command": between(0.5, 0.6, 2e4), "slip": -0.1}, "drive_recovery"),
        ({"command": between(0.5, 0.6, 2e4)}, "drive_grip"),
        ({"command": between(0.5, 0.52, 2e4), "used": between(0.5, 0.52, 1.0)}, "grip"),  # for less than LEAST_DURATION
        ({"command": between(0.5, 0.9, 2e4), "used": between(0.4, 0.9, 1.0)}, "contact"),  # the first counts
        ({"command": between(0.3, 0.9, 2e4), "used": between(0.4, 0.9, 1.0)}, "drive_grip"),
        ({"status": "rollers_protected"}, "contact"),
        ({"status": "derailed"}, "failed"),
    ],
)
def test_limits_are_told_apart(case: Case, values: dict, region: str) -> None:
    """A brake test: the wheel's torque is negative, and so is a drive's that helps it into its slide."""
    assert assess_limits(made_up_run(**values), case, -5e3, GRIPS)["region"] == region


def test_the_margin_of_a_recovery_is_that_of_a_wheel_that_comes_out_of_a_slide(case: Case) -> None:
    """It slides deeper until 0.5 s and regains speed until 0.8 s; what acts before and after does not count."""
    course = {"slip": lambda t: -0.2 * np.interp(t, [0.2, 0.5, 0.8], [0.0, 1.0, 0.0])}
    brake = {"brake": lambda t: -np.interp(t, [0.0, 0.5, 0.65, 0.8, 0.81], [9e3, 9e3, 6e3, 8e3, 1e3])}
    rig = rig_limits(point_case(case, Point(1.0, -1.0, 0.2), 3.0))
    record = assess_limits(made_up_run(**course, **brake), case, -5e3, GRIPS, rig)
    # (V6) by hand: r T - (U_m - R T) J_w R / (J_r r), T = 10 kN
    asked = 0.46 * 1e4 - (2e4 - 0.725 * 1e4) * 112.0 * 0.725 / (rig.roller_inertia * 0.46)
    assert record["recovery_margin_nm"] == pytest.approx(6e3 - asked, rel=0.01)
    assert assess_limits(made_up_run(), case, -5e3, GRIPS, rig)["recovery_margin_nm"] is None


def test_all_limits_are_recorded_with_their_times(case: Case) -> None:
    run = made_up_run(command=between(0.3, 0.9, 2e4), used=between(0.4, 0.9, 1.0))
    record = assess_limits(run, case, -5e3, GRIPS)
    assert record["limits"] == pytest.approx({"drive_grip": 0.3, "contact": 0.4})
    assert record["friction_used"] == pytest.approx(1.0)
    assert record["roller_torque_nm"] == pytest.approx(2e4)


def test_a_drive_that_is_weaker_at_speed_is_limited_by_its_power(case: Case) -> None:
    """Rollers turn at 41 rad/s: between the rows of the envelope, at 8.6 kN m."""
    envelope_rows = [[0.0, 15e3], [20.0, 15e3], [50.0, 6e3]]
    weak = case.with_changes({"rig_control.motor": {"envelope": envelope_rows}})
    assert assess_limits(made_up_run(command=between(0.5, 0.6, 9e3)), weak, -5e3, GRIPS)["region"] == "drive_power"
    assert assess_limits(made_up_run(command=between(0.5, 0.6, 8e3)), weak, -5e3, GRIPS)["region"] == "grip"


def test_a_limit_counts_where_it_persists() -> None:
    t = np.arange(0.0, 1.0, 0.01)
    met = np.zeros((len(t), 2), dtype=bool)
    met[10:13, 0] = True  # 20 ms
    assert persists_since(t, met) is None
    met[50:54, 1] = True  # 30 ms
    assert persists_since(t, met) == pytest.approx(0.5)
    met[20:40, 0] = True
    assert persists_since(t, met) == pytest.approx(0.2)


def test_a_wheel_slides_beyond_the_peak_of_the_creep_curve(case: Case) -> None:
    """Slippery and weak: creep uses all adhesion at s = 3 mu N / (k G a b c_11), 1 - (1 - x)^3 of it at x s; friction falls."""
    used_up = 1.0 - 0.02 ** (1.0 / 3.0)  # x at 0.98
    patch = Patch(6e-3, 5e-3, 5e4)
    stiffness = 79e9 * 30e-6 * _core.kalker_coefficients(6 / 5, 0.28)[0]
    for adhesion in (0.05, 0.3):
        paper = {"contact.creep": "kalker_saturated", "contact.material": "steel"}
        hard = case.with_changes({"adhesion.rail": {"friction": adhesion}, **paper})
        slip, share = creep_peak(hard, patch, adhesion)
        shear = hard.contact.material.shear_modulus
        assert slip == pytest.approx(
            used_up * 3 * adhesion * 5e4 / (stiffness * shear / 79e9), rel=0.06
        )  # steps of 5.5 %
        assert share == pytest.approx(adhesion, rel=1e-6)
        weak = hard.with_changes({"adhesion.rail": {"friction": adhesion, "k_A": 0.3, "k_S": 0.1}})
        assert creep_peak(weak, patch, adhesion)[0] == pytest.approx(5 * slip, rel=0.06)
        falls = {"friction": {"kind": "falling", "mu_0": adhesion, "A": 0.4, "B": 0.2}, "k_A": 0.3, "k_S": 0.1}
        falling = hard.with_changes({"adhesion.rail": falls})
        at, share = creep_peak(falling, patch, adhesion)
        assert at <= 5 * slip
        assert (
            0.8 * adhesion < share < float(creep_curve(falling, patch, adhesion, np.array([0.9 * at]))[0][0]) < adhesion
        )


# ---------------------------------------------------------------------------------------------------- the points


def test_axle_loads_torques_and_adhesion_are_those_asked_for(case: Case) -> None:
    own = assemble(case).axle_loads
    for load in (0.6, 1.4):
        changed = point_case(case, Point(load, -3e3, 0.2), 3.0)
        loads = assemble(changed).axle_loads
        assert loads == pytest.approx({name: load * force for name, force in own.items()}, rel=1e-9)
    run = simulate(point_case(case, Point(1.0, -3e3, 0.2), 1.0))
    full = run.sel(time=slice(BEGIN + RISE + 0.05, None))
    # Friction of the pads is constant here; the cylinder ends a little below what the valve asks for.
    np.testing.assert_allclose(full["brake_torque"], -3e3, rtol=2e-3)
    pull = simulate(point_case(case, Point(1.0, 3e3, 0.2), 1.0))
    np.testing.assert_allclose(pull["traction_torque"].sel(time=slice(BEGIN + RISE + 0.05, None)), 3e3, rtol=1e-6)
    assert run.attrs["status"] == pull.attrs["status"] == "ok"


def test_the_default_map_reaches_beyond_dry_friction_and_brakes_where_there_is_a_brake(case: Case) -> None:
    plan = EnvelopeStudy(case)
    most = 0.46 * 0.3 * 109e3
    assert plan.torques[0] < -most
    assert plan.torques[-1] < 0
    assert EnvelopeStudy(load_case("adhesion_start")).torques[-1] > most
    assert len(plan.torques) * len(plan.adhesions) * len(plan.loads) >= 300  # before refining


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"torques": [2e3, 1e3]}, r"adhesion_brake: envelope: torques: 2000, 1000; allowed: at least 2 finite numbers"),
        ({"torques": [1e3]}, "at least 2 finite numbers in ascending order"),
        ({"torques": [1e3, float("nan")]}, "at least 2 finite numbers in ascending order"),
        ({"adhesions": [0.1, 1.2]}, r"envelope: adhesions: 0\.1, 1\.2; allowed: above 0 and up to 1"),
        ({"adhesions": [0.0, 0.2]}, "allowed: above 0 and up to 1"),
        (
            {"loads": [0.1, 1.0]},
            r"envelope: loads: 0\.1; allowed: above 0\.28, where nothing is left of the heaviest body",
        ),
        ({"duration": 0.2}, r"envelope: duration: 0\.2 s; allowed: 0\.6 s to 60 s"),
        ({"refine": 9}, "envelope: refine: 9; allowed: 0 to 4"),
        ({"torques": np.arange(1.0, 2e4).tolist()}, "at most 100000"),
    ],
)
def test_ranges_that_cannot_be_run_are_refused(case: Case, options: dict, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        envelope(case, **options)


def test_a_case_that_reproduces_nothing_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"bogie_track: rig_control: missing; needed: a case on rollers"):
        EnvelopeStudy(load_case("bogie_track"))


# ------------------------------------------------------------------------------------------- against closed forms


def test_load_transfer_is_that_of_a_bogie_on_its_rod_and_of_the_runs(case: Case) -> None:
    """Two forces at the crowns, held 0.6 m higher, axles 2.56 m apart: 0.469; the frame's and wheelsets' own inertia add 3 %."""
    rig = rig_limits(point_case(case, Point(1.0, -1.0, 0.3), 3.0))
    assert rig.load_transfer == rig.virtual_transfer == pytest.approx(2 * 0.6 / 2.56, rel=0.04)
    run = simulate(point_case(case, Point(1.0, -5e3, 0.3), 3.0)).sel(time=slice(2.0, None)).mean("time")
    loads = run["vertical_force"].to_numpy().reshape(2, 2).sum(axis=1)
    # On the rig the bogie also gives way behind the crowns, which shifts some of its weight: 2 % here.
    assert 0.5 * (loads[0] - loads[1]) / abs(run["contact_force"].mean().item()) == pytest.approx(
        rig.load_transfer, rel=0.04
    )


@pytest.mark.parametrize(
    ("line", "region", "load", "adhesion"),
    [
        ("line_grip", "slide", 1.0, 0.05),
        ("line_grip", "slide", 0.6, 0.20),
        ("line_drive_slide", "drive_slide", 1.0, 0.05),
        ("line_drive_slide", "drive_slide", 0.6, 0.10),
        ("line_drive_grip", "drive_grip", 1.4, 0.36),
        ("line_contact", "contact", 0.6, 0.36),
    ],
)
def test_limits_begin_where_closed_forms_put_them(
    coulomb: Case, line: str, region: str, load: float, adhesion: float
) -> None:
    """12 % below the line there is no such limit, 12 % above it there is.

    As the torque rises the drives' torque overshoots by 6 %, for lags of estimator and drive and the feedback, and the bogie's
    pitching adds 4 % to the part of the friction that an axle uses; the rest is the time for which a limit must be held.
    """
    model = point_case(coulomb, Point(load, -1.0, adhesion), 1.5)
    patch = patch_of(assemble(model))
    border = float(closed_forms(model, np.array([adhesion]))[line][0])
    found = {
        factor: assess_limits(simulate(point), point, -factor * border, grip_slip(point, patch, adhesion))
        for factor in (0.88, 1.12)
        for point in [point_case(coulomb, Point(load, -factor * border, adhesion), 1.5)]
    }
    met = {factor: {record["region"], *record["limits"]} for factor, record in found.items()}
    assert region not in met[0.88]
    assert region in met[1.12]


def test_out_of_a_slide_the_drive_follows_where_enough_torque_is_left(case: Case) -> None:
    """(V6) at each instant of a run: where wheels regain speed with less torque left, the command is at its limit."""
    point = point_case(case.with_changes({"contact.creep": "kalker_saturated"}), Point(1.0, -16e3, 0.25), 5.0)
    run, rig = simulate(point), rig_limits(point)
    left = rig.recovery_at(np.abs(run["virtual_force"].to_numpy())) - np.abs(run["estimated_torque"].to_numpy())
    slip = RADIUS * run["virtual_speed"] / run["train_speed"] - 1.0
    recovers = ((slip < -0.03) & (run["virtual_speed"].differentiate("time") > 0.0)).to_numpy()
    at_limit = run["roller_command"].to_numpy() >= 0.999 * 2e4
    spare = 1e3  # for the feedback's part of the command: 4 kN m of the roller's torque
    assert (recovers & (left > spare)).sum() > 20
    assert at_limit[recovers & (left > spare)].mean() > 0.95
    assert (recovers & (left < -spare)).sum() > 20
    assert at_limit[recovers & (left < -spare)].mean() < 0.05


@pytest.mark.parametrize(
    ("limit", "predicted", "compared", "agrees"),
    [
        ("contact", 8.1e3, (7.5e3, 8.25e3), True),
        ("contact", 8.9e3, (7.5e3, 8.25e3), True),  # a step of torque beside
        ("contact", 12.6e3, (7.5e3, 8.25e3), False),
        ("drive_recovery", 0.0, (0.4e3, -1.2e3), True),  # left over (V6)
        ("drive_recovery", 0.0, (math.inf, -1.2e3), True),
        ("drive_recovery", 0.0, (5.2e3, 4.6e3), False),
        ("tracking", math.nan, (7.5e3, 8.25e3), False),  # a limit that no closed form knows
        ("", 2e4, (9e3, math.nan), None),
        ("", 5e3, (9e3, math.nan), False),  # predicted, and does not come
    ],
)
def test_a_border_agrees_if_the_torque_does(limit: str, predicted: float, compared: tuple, agrees: bool | None) -> None:
    border = Border("brake", 1.0, 0.3, *compared, limit, predicted, *sorted(compared), 0.75e3)
    assert border.agrees is agrees


@pytest.mark.slow
def test_a_map_agrees_with_its_closed_forms(coulomb: Case) -> None:
    """One load, coarse: at every border the predicted torque is that of the runs, within a step."""
    found = envelope(
        coulomb,
        torques=[-1e3 * t for t in (16, 13, 10, 7, 4, 1.5)],
        adhesions=[0.04, 0.1, 0.2, 0.34],
        loads=[1.0],
        duration=1.2,
        refine=0,
    )
    compared = [border for border in borders(found) if border.agrees is not None]
    assert len(compared) >= 2
    assert all(border.agrees for border in [*compared, *slides(found)])
    assert found["line_contact"].attrs["units"] == "N m"


# ------------------------------------------------------------------------------------------- refining and keeping


def circle(_case: Case, point: Point, _known: object) -> dict[str, Any]:
    """In place of a run: limited beyond a circle."""
    inside = (point.torque / 1e4) ** 2 + (point.adhesion / 0.4) ** 2 < 0.5
    numbers = dict.fromkeys(NUMBERS, 0.001)
    return {"region": "grip" if inside else "contact", "limits": {}, "status": "ok", "message": "", **numbers}


@pytest.mark.slow
def test_cells_are_halved_where_regions_meet_and_nowhere_else(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(envelope_points, "run_point", circle)
    grid = {"torques": [1e3 * t for t in range(1, 11)], "adhesions": [0.04 * m for m in range(1, 11)], "loads": [1.0]}
    coarse, fine = (envelope(case, **grid, refine=refine) for refine in (0, 2))
    assert coarse.attrs["runs"] == 100
    assert 100 < fine.attrs["runs"] < 37 * 37 / 3
    regions = fine["region"].sel(load=1.0).to_numpy()
    row = regions[:, 0]  # at the least torque the border is crossed once, within a quarter of a cell
    last = max(k for k, region in enumerate(row) if region == "grip")
    assert row[last + 1] == "contact"
    assert regions[1, 1] == ""  # far from the border nothing was run


@pytest.mark.slow
def test_stopped_and_taken_up_again_gives_the_same_map(
    case: Case, small: tuple[xr.Dataset, Path], tmp_path: Path
) -> None:
    whole, case = small[0], case.with_changes(ELLIPSES)
    runs = tmp_path / NAME

    def stop_soon(_fraction: float, _text: str) -> None:
        if runs.exists() and runs.read_bytes().count(b"\n") > 2:
            raise KeyboardInterrupt

    part = envelope(case, **SMALL, folder=tmp_path, progress=stop_soon)
    assert part.attrs["interrupted"] == 1
    assert part.attrs["runs"] == 2
    kept = runs.read_bytes().splitlines()
    rest = envelope(case, **SMALL, folder=tmp_path)
    assert set(kept) <= set(runs.read_bytes().splitlines())
    assert rest.attrs["jobs_taken_over"] == 2
    assert rest.attrs["interrupted"] == 0
    assert rest.drop_attrs().identical(whole.drop_attrs())


@pytest.mark.slow
def test_runs_of_another_case_are_refused_by_the_key(
    case: Case, small: tuple[xr.Dataset, Path], tmp_path: Path
) -> None:
    shutil.copytree(small[1], tmp_path, dirs_exist_ok=True)
    case, before = case.with_changes(ELLIPSES), (tmp_path / NAME).read_bytes()
    with pytest.raises(ConfigError) as error:
        envelope(case.with_changes({"rig_control.feedback.largest": 1e4}), **SMALL, folder=tmp_path)
    message = str(error.value)
    assert f"{tmp_path / NAME}: rig_control.feedback.largest: 20000.0 there, 10000.0 now; allowed:" in message
    assert "choose another --out" in message
    with pytest.raises(ConfigError, match=r"duration: 0\.8 there, 1\.0 now"):
        envelope(case, **{**SMALL, "duration": 1.0}, folder=tmp_path)
    with pytest.raises(ConfigError, match=r"motion\.speed"):
        envelope(case.with_changes({"motion.speed": "20 m/s"}), **SMALL, folder=tmp_path)
    assert (tmp_path / NAME).read_bytes() == before


@pytest.mark.slow
def test_another_grid_takes_over_the_runs_it_shares(case: Case, small: tuple[xr.Dataset, Path], tmp_path: Path) -> None:
    shutil.copytree(small[1], tmp_path, dirs_exist_ok=True)
    more = envelope(case.with_changes(ELLIPSES), **{**SMALL, "torques": [-4e3, -3e3, -2e3]}, folder=tmp_path)
    jobs = [json.loads(line)["job"] for line in (tmp_path / NAME).read_text().splitlines()[1:]]
    assert more.attrs["runs"] == len(jobs) == 6  # each once
    assert more.attrs["jobs_taken_over"] >= 4


def test_a_run_that_cannot_begin_is_a_region_of_its_own(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_arguments: object, **_options: object) -> None:
        raise StartError("no equilibrium")

    monkeypatch.setattr(envelope_points, "whole_run", none)
    found = envelope(case, **SMALL)
    assert set(found["region"].to_numpy().ravel()) == {"failed"}
    assert set(found["status"].to_numpy().ravel()) == {"no_start"}


# ----------------------------------------------------------------------------------------------------- the command

GRID = ["--torques-knm=-8,-4,-2", "--adhesions=0.05,0.3", "--loads=1", "--duration=0.8", "--processes=1"]


def invoke(*arguments: object) -> tuple[int, str, str]:
    done = called("envelope", *arguments)
    return done.exit_code, done.stdout, done.stderr


@pytest.mark.slow
def test_the_command_writes_its_files(case: Case, tmp_path: Path) -> None:
    out, file = tmp_path / "out", tmp_path / "brake.toml"
    file.write_text(case.with_changes(ELLIPSES).to_toml())
    code, printed, told = invoke(file, "--out", out, *GRID, "--refine=0")
    assert code == 0, told
    assert printed.splitlines()[-1] == str(out / "report.html")
    names = {path.name for path in out.iterdir()}
    assert names == {
        NAME,
        "figures",
        "envelope.nc",
        "envelope.csv",
        "summary.json",
        "timing.json",
        "report.html",
        "rollerrig.json",
    }
    summary = json.loads((out / "summary.json").read_text())
    assert summary["runs"] == sum(summary["regions"].values()) == 6
    assert summary["vehicle_torque_nm"]["brake"] == pytest.approx(5.5e3, rel=0.02)  # (A6) by hand: 3.8 bar, 17.9 m/s
    assert unexplained(EnvelopeStudy.quantities, summary) == []
    with (out / "envelope.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    assert Counter(row["region"] for row in rows) == {k: v for k, v in summary["regions"].items() if v}
    assert {path.name for path in (out / "figures").iterdir()} == {"map_1.png"}
    stamps = {path: path.read_bytes() for path in out.rglob("*") if path.is_file() and path.name != "timing.json"}
    code, _, told = invoke(file, "--out", out, *GRID, "--refine=0")
    assert code == 0
    assert {path: path.read_bytes() for path in stamps} == stamps


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--torques-knm=1:2"], "has 2 parts"),
        (["--adhesions=0.1,2"], "envelope: adhesions: 0.1, 2; allowed: above 0 and up to 1"),
        (["--loads=0"], "envelope: loads: 0; allowed: above 0.28"),
        (["--speed-kmh=nan"], "not a finite number"),
        (["--speed-kmh=-5"], "motion.speed"),
        (["--torques-knm=1,1"], "ascending order"),
    ],
)
def test_bad_options_end_with_code_2(options: list[str], message: str, tmp_path: Path) -> None:
    code, _, told = invoke("adhesion_brake", "--out", tmp_path / "out", *options)
    assert code == 2
    assert message in " ".join(told.replace("│", " ").split())
    assert not (tmp_path / "out").exists()
