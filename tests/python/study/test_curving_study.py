"""The study of steady curving, as a function and as a command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr
from called import called
from reported import unexplained, unreported
from rollerrig.config import Case
from rollerrig.study.curving import CurvingStudy
from rollerrig.study.frame import Outcome

WAGON = Path(__file__).parents[1] / "two_axle_wagon.toml"
SMOOTH = {"contact.normal": {"kind": "hertz", "merging_criterion": 0.5}}  # its flange forces jump least


def wagon() -> Case:
    return rr.load_case(WAGON).with_changes(SMOOTH)


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    found = CurvingStudy(wagon(), (1000.0, 500.0), (0.0, 0.65, 1.2), None, False).run()
    assert found is not None
    return found


def test_every_number_is_explained(outcome: Outcome) -> None:
    assert unexplained(CurvingStudy.quantities, outcome.numbers) == []
    missing = unreported(CurvingStudy.quantities, outcome.numbers)
    assert [key for key in missing if not key.startswith("sensitivity")] == []


def test_limits_exceeded_and_points_without_a_steady_state_are_named(outcome: Outcome) -> None:
    """Prud'homme: 10 kN + 2/3 of 55.4 kN; 0.65 m of cant deficiency press 48 kN of the wagon's 22.6 t on each wheelset."""
    curves = outcome.numbers["curves"]
    assert outcome.numbers["guiding_force_sum_limit_n"] == pytest.approx(10e3 + 2 / 3 * 22.6e3 * 9.81 / 4, rel=1e-6)
    assert curves["1000 m, 0 mm"]["exceeded"] == []
    assert curves["1000 m, 650 mm"]["guiding_force_sum_n"] > 22.6e3 * 9.81 * 0.65 / 1.5 / 2
    assert curves["1000 m, 650 mm"]["exceeded"] == ["ΣY"]
    assert "ΣY exceeds its limit in 1000 m, 650 mm; 500 m, 650 mm." in outcome.summary
    assert "Y/Q exceeds its limit in no curve." in outcome.summary
    refused = curves["500 m, 1200 mm"]
    assert refused["guiding_force_n"] is None
    assert refused["exceeded"] == []
    assert f"500 m, 1200 mm: {refused['failure']}." in outcome.summary
    assert outcome.statuses.count("ok") == 4


def test_numbers_are_those_of_the_function(outcome: Outcome) -> None:
    found = rr.curving(wagon(), [500.0], [0.65]).isel(radius=0, cant_deficiency=0)
    curve = outcome.numbers["curves"]["500 m, 650 mm"]
    assert curve["wheel_load_n"] == pytest.approx(float(found["wheel_load"].max()), rel=1e-6)
    assert curve["angle_of_attack_mrad"] == pytest.approx(1e3 * float(abs(found["angle_of_attack"]).max()), rel=1e-4)
    assert curve["unbalanced_force_n"] < 1e-3
    assert found.attrs["cant_m"] == 0.1  # a case on rollers has no curve of its own


def test_the_case_s_own_cant_is_taken() -> None:
    assert rr.curving("vehicle_curve", [1000.0], [0.0]).attrs["cant_m"] == 0.11


def test_order_and_repetition_of_radii_do_not_matter() -> None:
    one, other = (
        rr.curving(wagon(), [500.0, 1000.0], [0.1, 0.0]),
        rr.curving(wagon(), [1000.0, 500.0, 500.0], [0.0, 0.1]),
    )
    assert one["radius"].to_numpy().tolist() == [1000.0, 500.0]
    np.testing.assert_array_equal(one["wheel_load"], other["wheel_load"])


def test_nothing_but_refused_curves_is_an_error() -> None:
    with pytest.raises(rr.StartError, match="no steady state in any curve"):
        rr.curving(wagon(), [500.0], [1.2])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--radii-m", "5"), "from 20 to"),
        (("--radii-m", "0,300"), "radii: 0 m; allowed: above 0"),
        (("--deficiencies-mm", "-60..150"), "is not a number"),
    ],
)
def test_what_is_no_curve_is_refused(words: tuple[str, ...], message: str, tmp_path: Path) -> None:
    done = called("curving", WAGON, *words, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert message in " ".join(done.stderr.replace("│", " ").split())


def test_the_command_writes_its_files(tmp_path: Path) -> None:
    words = ["curving", str(WAGON), "--radii-m", "500", "--deficiencies-mm", "-60,60", "--cant-mm", "120"]
    done = called(*words, "--out", tmp_path)
    assert done.exit_code == 0, done.output
    files = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    assert {"curving.nc", "figures/curving.png", "summary.json", "report.html"} <= files
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["cant_mm"] == pytest.approx(120.0)
    assert summary["curves"].keys() == {"500 m, -60 mm", "500 m, 60 mm"}


def test_what_moves_the_tightest_curve_is_drawn_and_tabled(tmp_path: Path) -> None:
    words = ["curving", str(WAGON), "--radii-m", "500,1000", "--deficiencies-mm", "0,60", "--sensitivity"]
    done = called(*words, "--out", tmp_path)
    assert done.exit_code == 0, done.output
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert unexplained(CurvingStudy.quantities, summary) == []
    case, rows = rr.load_case(WAGON), {row["parameter"]: row for row in summary["sensitivity"]}
    friction = rows["contact.friction.mu_0"]
    more = case.with_changes({"contact.friction.mu_0": 1.001 * friction["value"]})
    above, own = (rr.curving(one, [500.0], [0.06])["wear_number"].squeeze() for one in (more, case))
    assert friction["wear_number_change_n"] == pytest.approx(
        10 * float((above - own)[int(np.abs(own.to_numpy()).argmax())]), rel=1e-2
    )
    assert (tmp_path / "figures" / "sensitivity_wear_number.png").exists()
    assert (tmp_path / "sensitivity.csv").read_text().startswith("parameter,value,unit,derailment_quotient_change")
    assert "What moves it in the curve of 500 m" in (tmp_path / "report.html").read_text()


def test_what_the_function_finds_is_drawn_with_defaults() -> None:
    figure = rr.plot.curving_over_radius(rr.curving(wagon(), [1000.0, 500.0], [0.0, 0.1]))
    assert [len(axes.lines) for axes in figure.axes] == [2] * 6  # a line per cant deficiency


def test_a_wider_gauge_of_the_case_s_curve_is_that_of_all() -> None:
    """By 10 mm: both wheelsets run on the same place of the outer rail, 5 mm farther out."""
    wide = rr.load_case("vehicle_curve").with_changes({"support.use": "curved_track_190"})
    usual = [one.model_dump(exclude={"gauge"}, exclude_none=True) for one in wide.support.data.segment]
    cases = wide, wide.with_changes({"support.segment": usual})
    with_it, without = (rr.curving(case, [300.0], [0.0])["lateral"] for case in cases)
    np.testing.assert_allclose(with_it[..., ::2] - without[..., ::2], 5e-3, atol=0.1e-3)
