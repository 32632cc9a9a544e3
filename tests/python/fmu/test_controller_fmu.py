"""Controllers as FMUs: ours alone, brought back in, are the built-in ones; those of others are checked before a run."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from called import called
from rollerrig import Case, export_part, load_case, simulate
from rollerrig.analysis.control_loop import loop_of, users_loop
from rollerrig.analysis.loop_stability import ABOVE, growth, vehicle_plant
from rollerrig.cli.describe import describe_case
from rollerrig.config import ConfigError, case_from_toml
from rollerrig.simulation.starting_state import StartError
from rollerrig.study.ensemble import recorded
from rollerrig.study.runs.control import loop_case

fmpy = pytest.importorskip("fmpy", reason="FMPy is an optional dependency")
validation = pytest.importorskip("fmpy.validation")
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the library inside FMUs is built on Linux")

OWN_ESTIMATE = {"reference_speed", "reference_speed_error"}
"""What the core records of the inside of its own slide protection or slip control; of one outside it knows nothing."""


def braked(duration: float, **changes: object) -> Case:
    return load_case("adhesion_brake").with_changes({"time.duration": duration} | changes)


def different(one: xr.Dataset, other: xr.Dataset) -> set[str]:
    return {str(name) for name in one.data_vars if not np.array_equal(one[name], other[name], equal_nan=True)}


@pytest.fixture(scope="module")
def protection(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return export_part("adhesion_brake", "slide_protection", tmp_path_factory.mktemp("part") / "wsp.fmu")


# ---------------------------------------------------------------------------------------------------- ours


@pytest.mark.parametrize(
    ("name", "part", "fmi", "changes"),
    [
        ("adhesion_brake", "slide_protection", "2", {"time.duration": 4.0}),
        ("adhesion_brake", "slide_protection", "3", {"time.duration": 4.0, "slide_protection.kind": "threshold_table"}),
        ("adhesion_train", "slide_protection", "2", {"time.duration": 1.0}),
        ("locomotive_traction", "wheel_slip_control", "2", {"time.duration": 3.0}),
        ("adhesion_brake", "rig_control", "2", {"time.duration": 3.0}),
        ("adhesion_sanding", "rig_control", "3", {"time.duration": 1.0, "rig_control.loads": "measured"}),
        ("adhesion_brake", "rig_control", "2", {"time.duration": 1.0, "rig_control.estimator": "kalman"}),
        ("adhesion_train", "rig_control", "2", {"time.duration": 1.0, "adhesion.recovery_constant": 0.0}),
    ],
)
def test_our_controller_brought_back_in_gives_the_same_run(
    name: str, part: str, fmi: str, changes: dict[str, object], tmp_path: Path
) -> None:
    case = load_case(name).with_changes(changes)
    file = export_part(case, part, tmp_path / "part.fmu", fmi=fmi)
    assert validation.validate_fmu(str(file)) == []
    built_in, outside = simulate(case), simulate(case.with_changes({f"{part}.fmu": str(file)}))
    assert outside.attrs["status"] == built_in.attrs["status"] == "ok"
    assert different(built_in, outside) <= (set() if part == "rig_control" else OWN_ESTIMATE)
    asked = {"slide_protection": "valve", "wheel_slip_control": "torque_factor", "rig_control": "roller_command"}[part]
    if name != "adhesion_train":
        assert np.ptp(built_in[asked].values) > 0.0
    assert re.fullmatch(rf"part\.fmu: .*, FMI {fmi}\.0, SHA-256 [0-9a-f]{{64}}", outside.attrs[f"{part}_fmu"])


@pytest.mark.slow
def test_motions_of_the_loop_that_an_fmu_closes_are_those_of_what_is_in_it(tmp_path: Path) -> None:
    case = loop_case(load_case("adhesion_brake").with_changes({"rig_control.estimator": "kalman"}))
    file = export_part(case, "rig_control", tmp_path / "part.fmu")
    inside, outside = (
        loop_of(case, 1e6, sliding=False),
        users_loop(case.with_changes({"rig_control.fmu": str(file)}), 1e6),
    )
    assert inside is not None
    expected, found = (growth(loop, vehicle_plant(case), ABOVE) for loop in (inside, outside))
    assert found == pytest.approx(expected, rel=1e-5)


def test_fmpy_alone_runs_our_slide_protection(protection: Path) -> None:
    speed = np.concatenate([np.linspace(87.0, 86.0, 100), np.linspace(86.0, 40.0, 60)])
    signals = np.array(
        [(0.005 * k, w, 87.0) for k, w in enumerate(speed)],
        dtype=[("time", float), ("wheelset_1.axle_speed", float), ("wheelset_2.axle_speed", float)],
    )
    found = fmpy.simulate_fmu(
        str(protection),
        start_values={"train.start_speed": 40.0},
        input=signals,
        output_interval=0.005,
        stop_time=0.8,
        output=["wheelset_1.valve_command", "wheelset_2.valve_command"],
    )
    assert (found["wheelset_1.valve_command"] == 2.0).any()  # it slides, and is vented
    assert (found["wheelset_2.valve_command"] == 0.0).all()


def test_the_same_part_gives_the_same_bytes(protection: Path, tmp_path: Path) -> None:
    again = export_part("adhesion_brake", "slide_protection", tmp_path / "wsp.fmu")
    assert again.read_bytes() == protection.read_bytes()
    with zipfile.ZipFile(protection) as archive:
        assert len(archive.read("resources/controller.part")) < 2000  # nothing of the rig is in it


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("adhesion_brake", "--part", "slide_protetcion"),
            r"part: 'slide_protetcion'; .*did you mean 'slide_protection'",
        ),
        (("wheelset_rollers", "--part", "slide_protection"), r"part: .*it has none"),
        (("adhesion_train", "--part", "rig_control"), r"part: 'rig_control'; the simulated axles"),
        (("adhesion_brake", "--part", "rig_control", "--set", "rig_control.estimator=exact"), "which no rig measures"),
        (("adhesion_brake", "--part", "rig_control", "--external", "slide_protection"), "--external"),
        (("adhesion_brake", "--part", "slide_protection", "--kind", "me"), "--kind: .*allowed with --part: cs"),
    ],
)
def test_a_part_that_is_not_there_is_refused(arguments: tuple[str, ...], message: str, tmp_path: Path) -> None:
    done = called("export-fmu", *arguments, "--out", tmp_path / "part.fmu")
    assert done.exit_code == 2
    assert re.search(message, " ".join(done.stderr.split()))
    assert not list(tmp_path.iterdir())


# ---------------------------------------------------------------------------------------------------- of others


def rewritten(source: Path, target: Path, change: Callable[[str], str], without: str = "-") -> Path:
    """An FMU with another description, and without the files whose names begin so."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                content = change(content.decode()).encode()
            if not name.startswith(without):
                new.writestr(name, content)
    return target


def named_otherwise(text: str) -> str:
    """Names that another tool would give."""
    for i in (1, 2):
        text = text.replace(f'"wheelset_{i}.axle_speed"', f'"omega[{i}]"')
        text = text.replace(f'"wheelset_{i}.valve_command"', f'"u_{i}"')
    return text


NAMES = {"axle_speed": "omega[{number}]", "valve": ("u_1", "u_2")}


def test_names_are_mapped(protection: Path, tmp_path: Path) -> None:
    file = rewritten(protection, tmp_path / "other.fmu", named_otherwise)
    table = {"file": str(file), "names": NAMES, "parameters": {"train.start_speed": 120 / 3.6}}
    case = braked(3.5)
    outside = simulate(mapped := case.with_changes({"slide_protection.fmu": table}))
    assert different(simulate(case), outside) <= OWN_ESTIMATE
    again = case_from_toml(outside.attrs["config_toml"], case.name, allow_code=True)
    assert again.slide_protection == mapped.slide_protection


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (
            {},
            r"slide_protection\.fmu\.names\.valve: 'wheelset_1\.valve_command'; no output of other\.fmu; it offers u_1, u_2",
        ),
        ({"names": NAMES | {"axle_sped": "x"}}, r"fmu\.names: axle_sped; allowed: .*did you mean 'axle_speed'\?"),
        ({"names": NAMES | {"axle_speed": "omega_{number}"}}, r"'omega_1'; no input of .*did you mean 'omega\[1\]'\?"),
        ({"names": NAMES | {"valve": "u_1"}}, r"it has 1 numbers for 2 axles \(wheelset_1, wheelset_2\)"),
        (
            {"names": {"valve": "u_{number}"}},
            r"no input is driven: omega\[1\], omega\[2\]; measured are axle_sp",
        ),
        (
            {"names": NAMES, "parameters": {"train.speed": 1.0}},
            r"'train\.speed'; no parameter .*'train\.start_speed'\?",
        ),
        ({"names": NAMES, "parameters": {"train.start_speed": "fast"}}, r"train\.start_speed: 'fast'; allowed: .*Real"),
        ({"file": "nowhere.fmu"}, r"nowhere\.fmu'; No such file"),
        ({"names": {"axle_speed": 5}}, r"slide_protection\.fmu\.names"),
        ({"names": NAMES, "parameters": {"train.start_speed": 10**400}}, r"fmu\.parameters.*allowed: a number, true"),
        (
            {"names": NAMES, "parameters": {"train.start_speed": float("nan")}},
            r"fmu\.parameters.*allowed: a number, true",
        ),
    ],
)
def test_what_does_not_fit_is_refused_before_the_run(
    table: dict[str, Any], message: str, protection: Path, tmp_path: Path
) -> None:
    file = rewritten(protection, tmp_path / "other.fmu", named_otherwise)
    with pytest.raises(ConfigError, match=message):
        simulate(braked(1.0, **{"slide_protection.fmu": {"file": str(file)} | table}))


@pytest.mark.parametrize(
    ("change", "without", "message"),
    [
        (lambda text: text, "modelDescription", "it has no modelDescription.xml"),
        (lambda text: text[:200], "-", "modelDescription.xml cannot be read"),
        (lambda text: text.replace('fmiVersion="2.0"', 'fmiVersion="1.0"'), "-", "FMI 1.0|cannot be read"),
        (lambda text: text.replace("CoSimulation", "ModelExchange"), "-", "for model exchange alone"),
        (lambda text: text, "binaries/linux64", r"it has no binaries/linux64/.*runs on no platform, this is linux64"),
    ],
)
def test_a_file_that_cannot_run_here_is_refused(
    change: Callable[[str], str], without: str, message: str, protection: Path, tmp_path: Path
) -> None:
    file = rewritten(protection, tmp_path / "wrong.fmu", change, without)
    with pytest.raises(ConfigError, match=rf"slide_protection\.fmu\.file: '.*wrong\.fmu'; .*({message})"):
        simulate(braked(1.0, **{"slide_protection.fmu": str(file)}))


def test_what_is_no_archive_or_has_no_fmpy_or_stands_beside_a_class_is_refused(
    protection: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "text.fmu").write_text("no archive")
    with pytest.raises(ConfigError, match="it is no zip archive"):
        simulate(braked(1.0, **{"slide_protection.fmu": str(tmp_path / "text.fmu")}))
    with pytest.raises(ConfigError, match=r"slide_protection\.fmu: .*one of user and fmu"):
        braked(1.0, **{"slide_protection.fmu": str(protection), "slide_protection.user": "mine:Mine"})
    monkeypatch.setitem(sys.modules, "fmpy", None)
    with pytest.raises(ConfigError, match=r'needs FMPy, which is not installed: pip install "rollerrig\[fmu\]"'):
        simulate(braked(1.0, **{"slide_protection.fmu": str(protection)}))


def test_a_case_finds_its_fmu_beside_it_and_none_elsewhere(protection: Path, tmp_path: Path) -> None:
    own = tmp_path / "own"
    own.mkdir()
    shutil.copy(protection, own / "wsp.fmu")
    text = 'base = "adhesion_brake"\n[time]\nduration = "0.05 s"\n[slide_protection]\nfmu = "{}"\n'
    (own / "case.toml").write_text(text.format("wsp.fmu"))
    done = called("check", own / "case.toml")
    assert done.exit_code == 0, done.stderr
    shown = " ".join(done.stdout.split())
    assert f"slide_protection.fmu: brings code: {own / 'wsp.fmu'}" in shown
    assert "acting 1 ms later, FMU wsp.fmu (FMI 2.0): axle_speed -> valve" in shown
    run = simulate(load_case(own / "case.toml"))
    assert case_from_toml(run.attrs["config_toml"], allow_code=True).slide_protection.fmu.file == str(own / "wsp.fmu")
    (own / "elsewhere.toml").write_text(text.format("../wsp.fmu"))
    with pytest.raises(ConfigError, match=r"slide_protection\.fmu: .*code from elsewhere"):
        load_case(own / "elsewhere.toml")


# ---------------------------------------------------------------------------------------------------- in C


@pytest.fixture(scope="module")
def relay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An FMU that no tool of ours has written."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no compiler of C")
    folder = tmp_path_factory.mktemp("relay")
    here = Path(__file__)
    headers = here.parents[3] / "third_party" / "fmi" / "2.0"
    library = folder / "relay.so"
    command = [
        compiler,
        "-std=c2x",
        "-shared",
        "-fPIC",
        "-O1",
        f"-I{headers}",
        str(here.with_name("relay.c")),
        "-o",
        str(library),
    ]
    subprocess.run(command, check=True)
    kinds = [
        ("w1", "Real", "input", 'start="0"'),
        ("w2", "Real", "input", 'start="0"'),
        ("v1", "Integer", "output", ""),
    ]
    kinds += [("v2", "Integer", "output", ""), ("part", "Real", "parameter", 'start="0.9" min="0" max="1"')]
    kinds += [(name, "Real", "parameter", 'start="1e9"') for name in ("fails_at", "errs_at")]
    kinds += [("rail", "String", "parameter", 'start="wet"'), ("never", "Boolean", "parameter", 'start="false"')]
    kinds += [
        ("r1", "Real", "output", ""),
        ("r2", "Real", "output", ""),
        ("none_at", "Real", "parameter", 'start="1e9"'),
        ("dies", "Real", "parameter", 'start="0"'),
    ]
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{i}" causality="{causality}" '
        f'variability="{"fixed" if causality == "parameter" else "discrete"}"><{kind} {rest}/></ScalarVariable>'
        for i, (name, kind, causality, rest) in enumerate(kinds)
    )
    with zipfile.ZipFile(folder / "relay.fmu", "w") as archive:
        archive.write(library, "binaries/linux64/relay.so")
        archive.writestr(
            "modelDescription.xml",
            '<fmiModelDescription fmiVersion="2.0" modelName="relay" guid="relay"><CoSimulation modelIdentifier="relay"/>'
            f"<ModelVariables>{variables}</ModelVariables><ModelStructure/></fmiModelDescription>",
        )
    return folder / "relay.fmu"


def with_relay(relay: Path, duration: float, valve: str = "v{number}", **parameters: object) -> Case:
    names = {"axle_speed": "w{number}", "valve": valve}
    table = {"file": str(relay), "names": names, "parameters": parameters}
    return braked(duration, **{"slide_protection.fmu": table})


class Relay:
    """What relay.c computes."""

    sample_time = 5e-3

    def step(self, measurements: dict[str, Any]) -> dict[str, Any]:
        speed = measurements["axle_speed"]
        return {"valve": np.where(speed < 0.95 * speed.max(), 2.0, 0.0)}


def test_an_fmu_of_others_is_a_controller_like_a_class(relay: Path) -> None:
    case = with_relay(relay, 4.0, part=0.95, rail="dry")
    assert case.slide_protection is not None
    assert case.slide_protection.sample_time == Relay.sample_time
    outside, own = simulate(case), simulate(braked(4.0), controllers={"slide_protection": Relay()})
    assert different(own, outside) == set()
    assert (outside["valve"] == 2.0).any()
    assert not (simulate(with_relay(relay, 4.0, never=True))["valve"] == 2.0).any()


def test_an_fmu_that_fails_ends_the_run_and_leaves_nothing_behind(
    relay: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    failed = simulate(with_relay(relay, 1.0, fails_at=0.5))
    assert failed.attrs["status"] == "controller_failed"
    message = failed.attrs["status_message"]
    assert re.match(r"t = 0\.505 s, slide_protection, controller relay\.fmu: fmi2DoStep failed .*error", message)
    assert "it says: the wire is broken" in message
    assert 0.4 < float(failed["time"][-1]) <= 0.51
    wrong = simulate(with_relay(relay, 1.0, errs_at=0.5))
    assert re.search(r"valve = \[7\.0, 0\.0\]; allowed: 0 fill", wrong.attrs["status_message"])
    none = simulate(with_relay(relay, 1.0, valve="r{number}", none_at=0.5))
    assert none.attrs["status"] == "controller_failed"
    assert re.match(r"t = 0\.505 s, slide_protection.*valve = \[nan, 0\.0\]", none.attrs["status_message"])
    assert 0.4 < float(none["time"][-1]) <= 0.51
    refused = simulate(with_relay(relay, 1.0, rail="dusty"))
    assert re.match(r"t = 0 s, slide_protection, controller relay\.fmu: fmi2SetString", refused.attrs["status_message"])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("value", "allowed"), [(2.0, "at most 1"), ("a", "Real"), (True, "Real")])
def test_parameters_have_their_type_and_limits(relay: Path, value: object, allowed: str) -> None:
    with pytest.raises(ConfigError, match=rf"slide_protection\.fmu\.parameters\.part: .*{allowed}"):
        simulate(with_relay(relay, 1.0, part=value))


# ---------------------------------------------------------------------------------------------------- hostile


def repacked(
    relay: Path, path: Path, change: Callable[[bytes], bytes], member: str = "binaries/linux64/relay.so"
) -> Path:
    """The same FMU with another content of one member; the archive is sound."""
    with zipfile.ZipFile(relay) as whole, zipfile.ZipFile(path, "w") as archive:
        for name in whole.namelist():
            archive.writestr(name, change(whole.read(name)) if name == member else whole.read(name))
    return path


@pytest.mark.parametrize("part", [0.02, 0.5, 0.9])
def test_a_cut_library_ends_its_own_process_alone(relay: Path, tmp_path: Path, part: float) -> None:
    cut = repacked(relay, tmp_path / "cut.fmu", lambda whole: whole[: int(part * len(whole) / 2)])
    run = simulate(with_relay(cut, 0.1))
    assert run.attrs["status"] == "controller_failed"
    assert re.search("cannot be loaded|tried in a process of its own", run.attrs["status_message"])
    with pytest.raises(StartError, match=r"slide_protection, controller cut\.fmu"):
        recorded(with_relay(cut, 0.1))
    with pytest.raises(ConfigError, match=r"slide_protection\.fmu\.file: '.*cut\.fmu'; ") as error:
        describe_case(with_relay(cut, 0.1), run_code=True)
    assert "\n" not in str(error.value)


def test_a_library_that_cannot_be_loaded_ends_its_own_process_alone(
    relay: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "unpacked"))
    (tmp_path / "unpacked").mkdir()
    damaged = repacked(relay, tmp_path / "damaged.fmu", lambda whole: whole[:16] + b"\xff" * 2 + whole[18:])
    run = simulate(with_relay(damaged, 0.1))
    assert run.attrs["status"] == "controller_failed"
    assert "its library cannot be loaded: OSError: " in run.attrs["status_message"]
    assert list((tmp_path / "unpacked").iterdir()) == []


@pytest.mark.parametrize(
    ("dies", "how"),
    [(1, "ended that with SIGABRT"), (2, "ended that with exit code 0"), (3, "had not ended after 1 s")],
)
def test_an_fmu_that_ends_its_process_or_never_returns_ends_its_own_alone(
    relay: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dies: int, how: str
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "unpacked"))
    (tmp_path / "unpacked").mkdir()
    monkeypatch.setattr("rollerrig.simulation.fmu_controller._SOUND", set())
    monkeypatch.setattr("rollerrig.simulation.fmu_controller._PATIENCE", 1.0 if dies == 3 else 30.0)
    case = with_relay(relay, 0.1, dies=dies)
    run = simulate(case)
    assert run.attrs["status"] == "controller_failed"
    assert re.search(f"tried in a process of its own, .*{how}", run.attrs["status_message"])
    with pytest.raises(ConfigError, match=rf"slide_protection\.fmu\.file: '.*relay\.fmu'; tried in .*{how}"):
        describe_case(case, run_code=True)
    assert list((tmp_path / "unpacked").iterdir()) == []


def test_what_unpacks_to_too_much_is_refused(relay: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rollerrig.simulation.fmu_file.LARGEST_UNPACKED", 1000)
    with pytest.raises(ConfigError, match=r"it unpacks to 0\.\d+ MB; allowed: up to 0\.001 MB"):
        simulate(with_relay(relay, 0.1))
    monkeypatch.undo()
    many = shutil.copy(relay, tmp_path / "many.fmu")
    with zipfile.ZipFile(many, "a") as archive, warnings.catch_warnings(action="ignore"):
        for _ in range(3):
            archive.writestr("resources/zeros", bytes(1_000_000), zipfile.ZIP_DEFLATED)
    monkeypatch.setattr("rollerrig.simulation.fmu_file.LARGEST_UNPACKED", 2_000_000)
    with pytest.raises(ConfigError, match=r"it unpacks to 3\.\d+ MB; allowed: up to 2 MB"):
        simulate(with_relay(many, 0.1))
    monkeypatch.setattr("rollerrig.simulation.fmu_file.LARGEST_DESCRIPTION", 100)
    with pytest.raises(ConfigError, match=r"its modelDescription\.xml has .*allowed: up to 0\.0001 MB"):
        simulate(with_relay(relay, 0.1))
