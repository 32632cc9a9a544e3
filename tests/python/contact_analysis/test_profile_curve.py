"""Profiles seen: curve, slope and curvature beside the points, and back from the files that are exported."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr
from called import called
from rollerrig.contact_analysis.profile_curve import profile_csv, simpack_text
from rollerrig.profiles.analytic import s1002_height


@pytest.fixture
def points(tmp_path: Path) -> Path:
    s = np.arange(-62.0, 60.0, 0.25)
    noise = 0.005 * np.random.default_rng(1).standard_normal(len(s))
    path = tmp_path / "worn.txt"
    path.write_text("\n".join(f"{x} {z}" for x, z in zip(s, s1002_height(s) + noise, strict=True)))
    return path


def test_slope_and_curvature_are_those_of_the_height() -> None:
    curve = rr.profile("uic60_benchmark_1_40")
    slope = curve["height"].differentiate("abscissa")
    middle = abs(curve["abscissa"]) < 0.01  # one arc of 300 mm at the top
    assert float(abs(slope - curve["slope"]).where(middle).max()) < 1e-4
    assert float(curve["curvature"].sel(abscissa=0.0, method="nearest")) == pytest.approx(1 / 0.3, rel=1e-3)
    assert curve.sizes["point"] == 0


def test_a_flange_is_convex_at_its_tip_and_hollow_at_its_root() -> None:
    curve = rr.profile("s1002")
    tip, root = (float(curve["curvature"].sel(abscissa=at, method="nearest")) for at in (-0.055, -0.036))
    assert tip > 10
    assert root < -10


def test_measured_points_lie_beside_the_curve(points: Path) -> None:
    curve = rr.profile(points, "wheel")
    inside = abs(curve["point_abscissa"]) < 0.03
    smooth = curve["height"].interp(abscissa=curve["point_abscissa"][inside.to_numpy()])
    apart = smooth.to_numpy() - curve["point_height"][inside.to_numpy()].to_numpy()
    assert np.sqrt(np.mean(apart**2)) < 8e-6  # noise of 5 um, and what smoothing takes off
    assert curve.sizes["point"] == 488
    assert "smoothed at 20 mm" in rr.profile(points, "wheel", 0.02).attrs["source"]


@pytest.mark.parametrize(("name", "ending"), [("s1002", ".prw"), ("en_60e1_1_40", ".prr")])
def test_an_exported_profile_is_read_as_the_same(name: str, ending: str, tmp_path: Path) -> None:
    curve = rr.profile(name)
    (tmp_path / f"again{ending}").write_text(simpack_text(curve))
    again = rr.profile(tmp_path / f"again{ending}", smoothing=0.5e-3)
    assert again.attrs["kind"] == curve.attrs["kind"]
    inside = curve["abscissa"][(curve["abscissa"] > -0.03) & (curve["abscissa"] < 0.03)]
    apart = again["height"].interp(abscissa=inside) - curve["height"].sel(abscissa=inside)
    assert float(abs(apart).max()) < 5e-6  # rounding of the points and smoothing at 0.5 mm


def test_the_table_has_units_in_its_names() -> None:
    lines = profile_csv(rr.profile("cone_1_20")).splitlines()
    assert lines[0] == "abscissa_mm,height_mm,slope,curvature_per_m"
    y, z, slope, _ = map(float, lines[1].split(","))
    assert z == pytest.approx(-y / 20, rel=1e-5)
    assert slope == pytest.approx(-0.05)


def test_the_command_writes_picture_and_file(tmp_path: Path) -> None:
    arguments = ["profile", "cone_1_20", "--out", str(tmp_path / "p.pdf"), "--export", str(tmp_path / "p.prw")]
    for _ in range(2):  # what it wrote it may write again
        done = called(*arguments)
        assert done.exit_code == 0, done.output
    assert (tmp_path / "p.pdf").read_bytes().startswith(b"%PDF")
    assert called("show", "wheelset_rollers", "--out", tmp_path / "v.png").exit_code == 0
    assert (tmp_path / "v.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["profile", "s1002", "--out", "p.gif"], "allowed: a file that ends in .svg, .png or .pdf"),
        (["profile", "s1002", "--export", "p.prr"], "allowed for a wheel: a file that ends in .csv or .prw"),
        (["profile", "s1003"], "did you mean 's1002'?"),
        (["profile", "none.txt"], "cannot be read"),
        (["profile", "uic60_benchmark_1_40", "--kind", "wheel"], "is a rail profile and cannot be used as a wheel"),
        (["show", "bogie_trck"], "did you mean 'bogie_track'?"),
    ],
)
def test_what_cannot_be_drawn_is_said(
    arguments: list[str], line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = called(*arguments)
    assert done.exit_code == 2
    assert line in " ".join(done.output.replace("│", " ").split())
    assert not list(tmp_path.iterdir())
