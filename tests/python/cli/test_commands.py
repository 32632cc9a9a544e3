"""The commands as a user meets them: files, exit codes, messages."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from importlib.resources import files
from pathlib import Path

import pytest

import rollerrig as rr
from called import called
from rollerrig.config import case_from_toml

CASE = """
name = "short"
vehicle = { use = "manchester_vehicle_1", cut = "leading_wheelset" }
support = { use = "full_scale_rig" }
contact = { material = "steel" }
motion = { speed = "40 km/h" }
disturbance = [{ body = "wheelset_1", lateral = "3 mm" }]
time = { duration = "0.1 s" }
"""
ENTRY = [sys.executable, "-c", "from rollerrig.cli import main; main()"]


class Done:
    def __init__(self, *arguments: object) -> None:
        result = called(*arguments)
        self.code, self.out, self.err = result.exit_code, result.stdout, result.stderr


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "short.toml"
    path.write_text(CASE)
    return path


@pytest.mark.slow
def test_run_writes_its_files(case: Path, tmp_path: Path) -> None:
    done = Done("run", case, "--out", tmp_path / "out")
    assert done.code == 0, done.err
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {
        "rollerrig.json",
        "run.nc",
        "summary.json",
        "timing.json",
        "running_safety.csv",
        "figures",
        "report.html",
        "view.html",
    }
    assert '<a href="view.html">' in (tmp_path / "out" / "report.html").read_text()
    assert "%" not in done.err  # no progress bar where nobody looks
    assert done.err.startswith("short: 0.1 s computed.")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["status"] == "ok"
    assert summary["keys"]["stopped_at_s"]
    assert rr.load_run(tmp_path / "out" / "run.nc").attrs["case"] == "short"


@pytest.mark.slow
def test_a_run_that_stops_keeps_its_results(case: Path, tmp_path: Path) -> None:
    lifted = {"disturbance": [{"body": "wheelset_1", "vertical": "0.5 m"}], "time.duration": "0.4 s"}
    case.write_text(rr.load_case("contact_benchmark_track").with_changes(lifted).to_toml())  # it falls for 0.32 s
    done = Done("run", case, "--out", tmp_path / "out")
    assert done.code == 3
    assert "contact_benchmark_track: 0.2" in done.err
    assert "wheelset_1_left: A wheel lost contact" in done.err
    assert rr.load_run(tmp_path / "out" / "run.nc").sizes["time"] > 0


@pytest.mark.slow
def test_ctrl_c_keeps_what_was_computed(case: Path, tmp_path: Path) -> None:
    case.write_text(CASE.replace('"0.1 s"', '"100000 s", maximum_step = "1 ms", output_step = "5 s"'))
    out = tmp_path / "out"
    process = subprocess.Popen(
        [*ENTRY, "run", case, "--out", out], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    while not out.exists() and process.poll() is None:  # the folder is made just before the run
        time.sleep(0.02)
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    try:
        _, errors = process.communicate(timeout=30)
    finally:
        process.kill()
    assert process.returncode == 130, errors
    assert "interrupted" in errors
    run = rr.load_run(out / "run.nc")
    assert run.attrs["status"] == "interrupted"
    assert 0 < float(run["time"][-1]) < 1e5
    assert json.loads((out / "summary.json").read_text())["samples"] == run.sizes["time"]


def test_mistakes_of_a_file_end_with_code_2(case: Path, tmp_path: Path) -> None:
    case.write_text(CASE.replace("steel", "steal").replace('"40 km/h"', "nan"))
    done = Done("run", case, "--out", tmp_path / "out")
    assert done.code == 2
    assert "contact.material: 'steal'" in done.err
    assert "did you mean 'steel'?" in done.err
    assert "motion.speed" in done.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["run", "check", "contact"])
def test_a_missing_file_ends_with_code_2(command: str, tmp_path: Path) -> None:
    more = {"run": ["--out", tmp_path / "o"], "check": [], "contact": ["--lateral-mm=0", "--csv", tmp_path / "c.csv"]}
    done = Done(command, "missing.toml", *more[command])
    assert done.code == 2
    assert "missing.toml" in done.err


def test_an_unwritable_folder_is_found_before_the_run(case: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = Done("run", case, "--out", tmp_path / "file" / "out")
    assert done.code == 2
    assert "a part of the path is a file" in done.err


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs limits of processes")
def test_a_full_disk_ends_with_code_2_and_nothing_half_written(case: Path, tmp_path: Path) -> None:
    """A limit on the size of files stops the write as a full disk does; a folder that the command made goes too."""
    limited = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000));"
        "from rollerrig.cli import main; main()"
    )
    (tmp_path / "mine").mkdir()
    for out in ("made", "mine"):
        done = subprocess.run(
            [sys.executable, "-c", limited, "run", case, "--out", tmp_path / out],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 2, done.stderr
        assert "run.nc: cannot be written" in done.stderr
    assert not (tmp_path / "made").exists()
    assert list((tmp_path / "mine").iterdir()) == []


def test_check_prints_model_loads_and_masses() -> None:
    done = Done("check", "bogie_rollers_constant")
    assert done.code == 0
    assert "20 degrees of freedom" in done.out
    assert "secondary_spring_front_left" in done.out
    assert "mass of front_frame, wheelset_1, wheelset_2: 6.241 t, weight 61.224 kN" in done.out
    difference = float(done.out.split("(difference")[1].split()[0])
    assert abs(difference) < 1e-3  # N; what Newton's method leaves


def test_check_prints_actuators_and_controllers() -> None:
    done = Done("check", "adhesion_brake")
    assert done.code == 0
    # 2 faces * 0.247 m * (0.085 m^2 * 3.8 bar - 500 N) * friction of the pads at 17.9 m/s, 0.3514
    assert (
        "brake: 3.8 bar at most, 5.52 kN m per axle by friction brakes, which asks for an adhesion of 0.110" in done.out
    )
    assert "adhesion of the rail: 0.08 falling to 0.032 with slip" in done.out
    assert "slide_protection: every 5 ms, acting 1 ms later" in done.out
    assert "observer 20 Hz, proportional-integral feedback" in done.out
    done = Done("check", "sanding_trial", "--set", "brake.demand=[[0, 0], [1, '2 bar']]")
    assert "brake: 2 bar at most" in done.out
    assert "adhesion of the rail, in place of contact.friction: 0.02 falling to 0.02 with slip" in done.out
    done = Done("check", "full_scale_rig", "--set", "gauge=1.4 m")
    assert (done.code, "'full_scale_rig' is a support; allowed: with a case or a plan" in done.err) == (2, True)


def test_check_names_an_ensemble_that_is_no_test(case: Path) -> None:
    """`run` takes such a case, `adhesion` refuses it."""
    case.write_text('base = "adhesion_brake"\nname = "mine"\n"ensemble.load" = 1.0\n')
    done = Done("check", case)
    assert done.code == 0
    assert "no test for adhesion, tune, wsp: mine: ensemble.load: 1, which draws veh" in done.out
    assert "no test for" not in Done("check", "adhesion_brake").out


def test_check_loads_the_users_controllers(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(
        (files("rollerrig") / "catalog/cases/adhesion_brake.toml")
        .read_text()
        .replace("[rig_control]", '[rig_control]\nuser = "nowhere.py:Mine"')
    )
    done = Done("check", str(tmp_path / "case.toml"))
    assert done.code == 2
    assert f"rig_control.user: '{tmp_path / 'nowhere.py'}:Mine'" in done.err
    (tmp_path / "nowhere.py").write_text(
        "class Mine:\n    sample_time = 1e-3\n    def step(self, measurements):\n        return {}\n"
    )
    done = Done("check", str(tmp_path / "case.toml"), "--allow-code")
    assert done.code == 0, done.err
    assert "rig_control: every 1 ms, acting 0 ms later, Mine of your own" in done.out


def test_check_prints_the_line_and_how_the_vehicle_runs_on_it() -> None:
    done = Done("check", "vehicle_curve")
    assert done.code == 0
    (row,) = [line.split() for line in done.out.splitlines() if line.startswith("2 curve")]
    assert row[2:9] == ["130", "330", "100.0", "600", "left", "110", "74.9"]
    deficiency, highest = map(float, row[9:])
    # 11.8 V^2 / R - h; the cosine of the cant and g take half a per cent
    assert deficiency == pytest.approx(11.8 * 100**2 / 600 - 110, abs=2)
    assert 200 < highest < 230
    assert "transition" in done.out


def test_check_prints_the_size_of_irregularities() -> None:
    done = Done("check", "vehicle_track_irregular")
    assert "irregularity: ORE B 176, low level, seed 1, waves of 3 to 100 m, repeating after 2000 m" in done.out
    assert "root mean square [mm]: alignment 1.72, vertical 2.37, cross level 1.79, gauge 0.32" in done.out


@pytest.mark.parametrize("name", ["manchester_vehicle_1", "full_scale_rig", "uic60_track", "steel", "s1002"])
def test_check_knows_every_kind(name: str) -> None:
    done = Done("check", name)
    assert done.code == 0
    assert "a valid" in done.out


def test_check_reports_what_is_wrong(case: Path) -> None:
    case.write_text(CASE + "colour = 'red'\n")
    done = Done("check", case)
    assert done.code == 2
    assert "colour" in done.err


def test_catalog_lists_and_shows() -> None:
    listed = Done("catalog")
    assert listed.code == 0
    assert {"bogie_rollers_ramp", "manchester_vehicle_1", "steel"} <= set(listed.out.split())
    assert Done("catalog", "show", "steel").out == rr.catalog_text("steel")
    missing = Done("catalog", "show", "steal")
    assert missing.code == 2
    assert "did you mean 'steel'?" in missing.err


def test_contact_writes_a_row_per_patch(tmp_path: Path) -> None:
    path = tmp_path / "new" / "contact.csv"
    done = Done("contact", "contact_benchmark_track", "--lateral-mm=-2:2:2", "--csv", path)
    assert done.code == 0, done.err
    rows = list(csv.DictReader(path.open()))
    head = "lateral_mm,yaw_mrad,side,patch,wheel_s_mm,angle_rad,a_mm,b_mm,approach_mm,normal_n,roll_mrad,height_mm,"
    assert path.read_text().startswith(head)
    assert {row["lateral_mm"] for row in rows} == {"-2", "0", "2"}
    assert {row["side"] for row in rows} == {"left", "right"}
    # the wheelset presses through steel: loaded it stands lower than unloaded
    centred = [row for row in rows if row["lateral_mm"] == "0"]
    assert all(-0.03 < float(row["height_mm"]) < 0 for row in centred)
    assert sum(float(row["normal_n"]) for row in centred) == pytest.approx(20e3, rel=3e-3)  # over the cosine


@pytest.mark.slow
def test_contact_compares_the_normal_contacts(tmp_path: Path) -> None:
    path, picture = tmp_path / "contacts.csv", tmp_path / "contacts.svg"
    done = Done("contact", "contact_benchmark_track", "--lateral-mm=0,2", "--csv", path, "--compare", "--plot", picture)
    assert done.code == 0, done.err
    for words in ("hertz: ", "strips: ", "µs per wheel and evaluation"):
        assert words in done.out
    rows = [line.split(",") for line in path.read_text().splitlines()]
    assert len(rows) == 1 + 2 * 2 * 2  # models, positions, wheels
    found = {(row[0], row[1], row[3]): dict(zip(rows[0], row, strict=True)) for row in rows[1:]}
    # Centred, the wide patch is on the way from two ellipses to one; at 2 mm both see the same ellipse.
    assert float(found["hertz", "0", "left"]["patches"]) > 1.9
    assert float(found["strips", "0", "left"]["patches"]) < 1.9
    for name in ("approach_mm", "peak_pressure_mpa", "area_mm2"):
        one, other = (float(found[model, "2", "left"][name]) for model in ("hertz", "strips"))
        assert one == pytest.approx(other, rel=0.06), name
    assert picture.stat().st_size > 5000
    assert "ns per call" in done.out
    assert "hertz,exact,0,0,left," in (tmp_path / "contacts_creep.csv").read_text()
    assert (tmp_path / "contacts_creep.svg").stat().st_size > 5000


def test_contact_from_flange_to_flange(tmp_path: Path) -> None:
    """Every position asked for has both wheels on their rails, and the table is its own mirror image."""
    path = tmp_path / "contact.csv"
    done = Done("contact", "contact_benchmark_track", "--lateral-mm=-8:8:2", "--csv", path)
    assert done.code == 0, done.err
    rows = list(csv.DictReader(path.open()))
    for lateral in range(-8, 9, 2):
        here = [row for row in rows if float(row["lateral_mm"]) == lateral]
        assert {row["side"] for row in here} == {"left", "right"}
        mirrored = [row for row in rows if float(row["lateral_mm"]) == -lateral]
        for row in here:
            other = next(m for m in mirrored if m["side"] != row["side"] and m["patch"] == row["patch"])
            # the balance is found to 1e-5 of the load, where some 10 kN/um press
            assert float(row["wheel_s_mm"]) == pytest.approx(float(other["wheel_s_mm"]), abs=1e-3)
            assert float(row["roll_mrad"]) == pytest.approx(-float(other["roll_mrad"]), abs=1e-4)


def test_contact_in_proportion_and_with_a_plot(tmp_path: Path) -> None:
    path, picture = tmp_path / "c.csv", tmp_path / "c.png"
    done = Done(
        "contact",
        "contact_benchmark_rollers",
        "--lateral-mm=1,2",
        "--yaw-mrad-per-mm=2.4",
        "--csv",
        path,
        "--plot",
        picture,
    )
    assert done.code == 0, done.err
    assert {row["yaw_mrad"] for row in csv.DictReader(path.open())} == {"2.4", "4.8"}
    assert picture.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--lateral-mm=1:2:0"], "the step is zero"),
        (["--lateral-mm=a"], "not a number"),
        (["--lateral-mm=0", "--yaw-mrad=1", "--yaw-mrad-per-mm=2"], "not both"),
        (["--lateral-mm=0", "--plot", "picture.doc"], "ends in .svg, .png or .pdf"),
    ],
)
def test_bad_options_of_contact(options: list[str], message: str, tmp_path: Path) -> None:
    done = Done("contact", "contact_benchmark_track", *options, "--csv", tmp_path / "c.csv")
    assert done.code == 2
    assert message in done.err
    assert not (tmp_path / "c.csv").exists()


def test_roll_can_be_fixed(tmp_path: Path) -> None:
    path = tmp_path / "c.csv"
    done = Done("contact", "contact_benchmark_track", "--lateral-mm=3", "--roll-mrad=0.1", "--csv", path)
    assert done.code == 0, done.err
    assert {row["roll_mrad"] for row in csv.DictReader(path.open())} == {"0.1"}


def test_version_and_help() -> None:
    assert Done("--version").out.strip() == rr.__version__
    text = Done("--help").out
    assert "run" in text
    assert "130 interrupted" in " ".join(text.split())


def test_the_version_is_that_of_the_package() -> None:
    import tomllib

    root = Path(__file__).resolve().parents[3]
    assert tomllib.loads((root / "pyproject.toml").read_text())["project"]["version"] == rr.__version__


def test_public_names_exist() -> None:
    for name in rr.__all__:
        if name != "stability":  # needs the analysis; tested there
            assert getattr(rr, name) is not None


@pytest.mark.parametrize("option", ["--yaw-mrad-per-mm=nan", "--roll-mrad=inf"])
def test_options_are_finite_numbers(tmp_path: Path, option: str) -> None:
    done = Done("contact", "contact_benchmark_track", "--lateral-mm=0", option, "--csv", tmp_path / "c.csv")
    assert done.code == 2
    assert option.split("=")[0] in done.err
    assert not (tmp_path / "c.csv").exists()


def test_what_is_found_late_names_the_file_too(case: Path, tmp_path: Path) -> None:
    case.write_text(CASE.replace('"0.1 s"', '"0.1 s", method = "rk4", step = "9 ms"'))
    done = Done("run", case, "--out", tmp_path / "out")
    assert done.code == 2
    assert f"rollerrig: {case}: time.step: 9 ms; allowed" in done.err


@pytest.mark.slow
def test_values_of_a_case_can_be_set_on_the_command_line(case: Path, tmp_path: Path) -> None:
    sets = (
        "--set",
        "motion.speed=72 km/h",
        "--set",
        "vehicle.element.primary_*.x.stiffness=30 MN/m",
        "--set",
        "time.duration=0.02",
    )
    assert Done("run", case, "--out", tmp_path / "out", *sets).code == 0
    run = rr.load_run(tmp_path / "out" / "run.nc")
    kept = case_from_toml(run.attrs["config_toml"])
    assert (kept.motion.speed, kept.time.duration) == (20.0, 0.02)
    assert {e.x.stiffness for e in kept.vehicle.data.element if e.x and e.name.startswith("primary_")} == {30e6}


@pytest.mark.parametrize(
    ("text", "line"),
    [("motion.speed", "allowed: KEY=VALUE"), ("motion.sped=3", "motion.sped: unknown key (= 3); allowed"),
     ("motion.speed=3 kg", "motion.speed: '3 kg'; allowed: a number in m/s"), ("=3", "allowed: KEY=VALUE")],
)  # fmt: skip
def test_what_cannot_be_set_is_said(text: str, line: str, case: Path, tmp_path: Path) -> None:
    done = Done("run", case, "--out", tmp_path / "out", "--set", text)
    assert done.code == 2
    assert line in " ".join(done.err.replace("│", " ").split())
    assert not (tmp_path / "out").exists()


# ------------------------------------------------------------------------------------------------- for those who begin


@pytest.mark.slow
def test_a_new_case_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert Done("new", "mine", "--from", "wheelset_rollers").code == 0
    assert Done("run", "mine.toml", "--out", "out", "--set", "time.duration=0.02").code == 0
    again = Done("new", "mine")
    assert (again.code, again.err.startswith("rollerrig: mine.toml: there is a case of that name")) == (2, True)
    assert Done("new", "other", "--out", "other.toml").err.startswith("rollerrig: other.toml: --out is the folder")
    assert Done("new", "two words").err.startswith("rollerrig: new: name: 'two words'; allowed")
    assert Done("new", "other", "--from", "wheelst_rollers").code == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.toml", "out"]


def test_keys_are_explained_and_the_schema_is_printed() -> None:
    assert "unit       m/s" in Done("explain", "motion.speed").out
    wrong = Done("explain", "motion.sped")
    assert (wrong.code, wrong.err) == (2, "rollerrig: motion.sped: no such key; did you mean 'motion.speed'?\n")
    assert json.loads(Done("schema", "material").out) == rr.json_schema("material")
    assert Done("schema", "cse").code == 2


def test_sources_are_printed_as_bibtex(tmp_path: Path) -> None:
    assert Done("cite").out == rr.cite()
    assert "polach2005" in Done("cite", "adhesion_brake").out
    assert Done("cite", tmp_path / "none.nc").code == 2
    assert Done("cite", "adhesion_brak").code == 2
