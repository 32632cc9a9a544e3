"""Code that a case brings: named by every command, taken only from the case's own folder, never run by a check."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

import pytest

import rollerrig as rr
from called import call
from rollerrig.config import ConfigError, case_from_toml, code_of, load_any
from rollerrig.study.compare import compared_cases

TRACE = "ran"
CONTROLLER = f"""
from pathlib import Path
Path(__file__).with_name({TRACE!r}).touch()

class Mine:
    sample_time = 1e-3
    def step(self, measurements):
        return {{"roller_torque": measurements["feed_forward"]}}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A stranger's case with its controller beside it."""
    own = tmp_path / "own"
    own.mkdir()
    (own / "mine.py").write_text(CONTROLLER)
    write_case(own / "case.toml", "mine.py:Mine")
    return own


def write_case(path: Path, user: str) -> None:
    text = (files("rollerrig") / "catalog/cases/adhesion_brake.toml").read_text()
    text = text.replace("[rig_control]", f"[rig_control]\nuser = '{user}'")
    path.write_text(re.sub(r'duration = "[^"]*"', 'duration = "0.05 s"', text))


def test_check_names_the_code_and_does_not_run_it(folder: Path) -> None:
    code, text = call("check", folder / "case.toml")
    assert code == 0, text
    assert f"rig_control.user: brings code: {folder / 'mine.py'}, class Mine" in text
    assert "it has not been run, --allow-code does" in text
    assert not (folder / TRACE).exists()


def test_check_runs_the_code_where_it_is_told_to(folder: Path) -> None:
    code, text = call("check", folder / "case.toml", "--allow-code")
    assert code == 0, text
    assert "rig_control: every 1 ms, acting 0 ms later, Mine of your own" in text
    assert (folder / TRACE).exists()


@pytest.mark.slow
def test_run_names_the_code_beside_its_case_and_runs_it(folder: Path, tmp_path: Path) -> None:
    code, text = call("run", folder / "case.toml", "--out", tmp_path / "out")
    assert code == 0, text
    assert f"case.toml: rig_control.user: brings code: {folder / 'mine.py'}, class Mine" in text
    assert (folder / TRACE).exists()
    assert not list(folder.glob("__pycache__")), "nothing is written beside the user's files"


@pytest.mark.parametrize(
    "user",
    ["../mine.py:Mine", "{elsewhere}/mine.py:Mine", "linked.py:Mine", "linked/mine.py:Mine", "os:abort"],
)
def test_code_from_elsewhere_is_refused(folder: Path, tmp_path: Path, user: str) -> None:
    elsewhere = tmp_path
    (elsewhere / "mine.py").write_text(CONTROLLER)
    (folder / "linked.py").symlink_to(elsewhere / "mine.py")
    (folder / "linked").symlink_to(elsewhere)
    write_case(folder / "case.toml", user.format(elsewhere=elsewhere))
    more = {
        "check": [],
        "run": ["--out", tmp_path / "out"],
        "adhesion": ["--out", tmp_path / "out"],
        "control": ["--out", tmp_path / "out"],
        "tune": ["--out", tmp_path / "out"],
        "lateral": ["--out", tmp_path / "out"],
        "envelope": ["--out", tmp_path / "out"],
        "stability": ["--out", tmp_path / "out"],
        "compare": ["--out", tmp_path / "out"],
        "scale": ["--strategy", "dlr", "--out", tmp_path / "out"],
        "contact": ["--lateral-mm=0", "--csv", tmp_path / "out.csv"],
    }
    for command, options in more.items():
        code, text = call(command, folder / "case.toml", *options)
        assert code == 2, command
        assert "rig_control.user: '" in text, command
        assert "code from elsewhere: a" in text
        assert "outside the file's own folder" in text
        assert "--allow-code" in text
    assert not (elsewhere / TRACE).exists()
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_code_from_elsewhere_runs_where_the_user_says_so(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(CONTROLLER)
    write_case(folder / "case.toml", "../mine.py:Mine")
    code, text = call("run", folder / "case.toml", "--out", tmp_path / "out", "--allow-code")
    assert code == 0, text
    assert "brings code: " in text
    assert (tmp_path / TRACE).exists()


def test_the_python_interface_asks_by_a_keyword(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(CONTROLLER)
    write_case(folder / "case.toml", "../mine.py:Mine")
    for read in (rr.load_case, load_any, rr.simulate, lambda path: compared_cases(path, ["rig"])):
        with pytest.raises(ConfigError, match=r"rig_control\.user: .*allow_code=True"):
            read(str(folder / "case.toml"))
    case = rr.load_case(folder / "case.toml", allow_code=True)
    assert [(code.key, Path(code.source).name, code.name) for code in code_of(case)] == [
        ("rig_control.user", "mine.py", "Mine")
    ]
    assert not (tmp_path / TRACE).exists()
    longer = case.with_changes({"time.duration": "0.06 s"})  # allowed once, allowed for good
    assert rr.simulate(longer).attrs["status"] == "ok"


def test_a_text_has_no_own_folder_unless_it_is_given_one(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (folder / "case.toml").read_text()
    monkeypatch.chdir(folder)
    with pytest.raises(ConfigError, match="outside the file's own folder; runs only"):
        case_from_toml(text)
    assert code_of(case_from_toml(text, folder=folder))
    assert code_of(case_from_toml(text, allow_code=True))


def test_results_bring_no_code(folder: Path, tmp_path: Path) -> None:
    run = rr.simulate(rr.load_case(folder / "case.toml"))
    path = rr.save_run(run, tmp_path / "run.nc")
    (folder / TRACE).unlink()
    loaded = rr.load_run(path)
    assert str(folder / "mine.py") in loaded.attrs["config_toml"]
    with pytest.raises(ConfigError, match="code from elsewhere"):
        case_from_toml(loaded.attrs["config_toml"])
    assert not (folder / TRACE).exists()


def test_the_text_is_run_and_not_what_was_compiled_from_another(folder: Path) -> None:
    """Python takes compiled code for the file's own where date and size agree: it could hide in __pycache__."""
    import importlib.util
    import py_compile

    other = folder / "other.py"
    other.write_text(CONTROLLER.replace(TRACE, "hid"))
    cached = Path(importlib.util.cache_from_source(str(folder / "mine.py")))
    cached.parent.mkdir()
    py_compile.compile(str(other), str(cached), invalidation_mode=py_compile.PycInvalidationMode.UNCHECKED_HASH)
    rr.simulate(rr.load_case(folder / "case.toml"))
    assert (folder / TRACE).exists()
    assert not (folder / "hid").exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "FileNotFoundError: .* No such file"),
        ("class Mine\n", "SyntaxError: "),
        ("class Yours:\n    pass\n", "needed: a class Mine in that file"),
    ],
)
def test_check_sees_what_is_wrong_without_running_it(folder: Path, text: str | None, message: str) -> None:
    (folder / "mine.py").unlink()
    if text is not None:
        (folder / "mine.py").write_text(f"open({str(folder / TRACE)!r}, 'w')\n{text}")
    code, shown = call("check", folder / "case.toml")
    assert code == 2
    assert re.search(rf"rig_control\.user: '{folder / 'mine.py'}:Mine'; {message}", shown), shown
    assert not (folder / TRACE).exists()


def test_a_controller_may_use_what_looks_for_its_module(folder: Path) -> None:
    """Dataclasses with postponed annotations look their module up by its name."""
    (folder / "mine.py").write_text(
        "from __future__ import annotations\nfrom dataclasses import dataclass\n"
        "@dataclass\nclass Mine:\n    sample_time: float = 1e-3\n"
        "    def step(self, measurements):\n        return {'roller_torque': measurements['feed_forward']}\n"
    )
    assert rr.simulate(rr.load_case(folder / "case.toml")).attrs["status"] == "ok"


PLAN = """\
name = "stranger"
case = "{case}"
{changes}

[[vary]]
key = "{key}"
values = {values}

[[measure]]
kind = "run"
"""


def write_plan(folder: Path, *, changes: str = "", key: str = "motion.speed", values: str = '["20 m/s"]') -> Path:
    path = folder / "plan.toml"
    own = f"[changes]\n{changes}" if changes else ""
    path.write_text(PLAN.format(case=folder / "case.toml", changes=own, key=key, values=values))
    return path


@pytest.mark.parametrize(
    ("changes", "key", "values", "named"),
    [
        ('"rig_control.user" = "{evil}:Mine"', "motion.speed", '["20 m/s"]', "changes.rig_control.user"),
        ('rig_control = {{user = "{evil}:Mine"}}', "motion.speed", '["20 m/s"]', "changes.rig_control.user"),
        ('"rig_control.us*" = "{evil}:Mine"', "motion.speed", '["20 m/s"]', "changes.rig_control.user"),
        ('"rig_control.user" = "os:abort"', "motion.speed", '["20 m/s"]', "changes.rig_control.user"),
        ('slide_protection = {{fmu = "{evil}"}}', "motion.speed", '["20 m/s"]', "changes.slide_protection.fmu"),
        ('"slide_protection.fmu.file" = "{evil}"', "motion.speed", '["20 m/s"]', "changes.slide_protection.fmu"),
        ("", "rig_control.user", '["{evil}:Mine"]', "vary[0].values.rig_control.user"),
        ("", "rig_control.user", '["mine.py:Mine", "os:abort"]', "vary[0].values.rig_control.user"),
        ("", "rig_control", '[{{user = "{evil}:Mine"}}]', "vary[0].values.rig_control.user"),
        ("", "*.user", '["{evil}:Mine"]', "vary[0].values.*.user"),
        ("", "slide_protection", '[{{fmu = {{file = "{evil}"}}}}]', "vary[0].values.slide_protection.fmu"),
        ('base = "{evil_case}"', "motion.speed", '["20 m/s"]', "changes.base"),
    ],
)
def test_a_plan_brings_no_code_from_elsewhere(
    folder: Path, tmp_path: Path, changes: str, key: str, values: str, named: str
) -> None:
    (tmp_path / "mine.py").write_text(CONTROLLER)
    write_case(tmp_path / "evil.toml", "mine.py:Mine")
    paths = {"evil": tmp_path / "mine.py", "evil_case": tmp_path / "evil.toml"}
    plan = write_plan(folder, changes=changes.format(**paths), key=key, values=values.format(**paths))
    for command, options in {"check": [], "sweep": ["--out", tmp_path / "out", "--workers=1"]}.items():
        code, text = call(command, plan, *options)
        assert code == 2, text
        assert named in text, text
        assert "code from elsewhere: a" in text or "changes.base" in text
    assert not (tmp_path / TRACE).exists()
    assert not (folder / TRACE).exists()


def test_a_plan_names_the_code_beside_it_and_runs_it(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # paths start at the plan, wherever the command is called
    (folder / "other.py").write_text(CONTROLLER.replace(TRACE, "other"))
    plan = write_plan(folder, key="rig_control.user", values='["other.py:Mine"]')
    named = f"rig_control.user: brings code: {folder / 'other.py'}, class Mine"
    code, text = call("check", plan)
    assert (code, named in text) == (0, True), text
    assert not (folder / "other").exists()
    code, text = call("sweep", plan, "--out", tmp_path / "out", "--workers=1")
    assert (code, named in text) == (0, True), text
    assert (folder / "other").exists()


def test_a_plan_runs_code_from_elsewhere_where_the_user_says_so(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(CONTROLLER)
    plan = write_plan(folder, changes=f'"rig_control.user" = "{tmp_path / "mine.py"}:Mine"')
    code, text = call("sweep", plan, "--out", tmp_path / "out", "--workers=1", "--allow-code")
    assert code == 0, text
    assert f"brings code: {tmp_path / 'mine.py'}" in text
    assert (tmp_path / TRACE).exists()
