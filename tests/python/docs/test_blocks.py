"""Every block of code in README and documentation is run: Python, TOML, and the commands as far as they are quick.

Python blocks of a page run in their order in one session and an empty folder; a `text` block behind one is what it prints. A
TOML block whose first line is a comment `# name.toml` is that file; others are read as a part of a case, a vehicle, a support,
or a programme. Of commands the arguments are parsed, and those that take no time are carried out.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import textwrap
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

import rollerrig as rr
from rollerrig.analysis.adhesion_reconstruction import read_stop
from rollerrig.catalog import catalog_file
from rollerrig.cli.app import build_app
from rollerrig.config import json_schema, load_any
from rollerrig.config.load.plan import load_plan
from rollerrig.contact_analysis.profile_curve import simpack_text

ROOT = Path(__file__).resolve().parents[3]
PAGES = [ROOT / "README.md", *sorted(p for p in (ROOT / "docs").rglob("*.md") if "generated" not in p.parts)]
APP = build_app()
GROUP: Any = typer.main.get_command(APP)
QUICK = {"catalog", "new", "explain", "schema", "cite", "check", "show", "assemble"}
"""Commands that are carried out; `check` and `show` of files that are there."""

SERVED = {"real_time.md"}
"""Blocks for a server that runs: tests/python/realtime and examples/10_brake_controller.py are the same with one."""


def blocks(page: Path) -> list[tuple[str, str]]:
    """Language and text of the blocks of a page, those in lists too."""
    found = re.findall(r"^( *)```([a-z]*)\n(.*?)^\1```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    return [(language, textwrap.dedent(code)) for _, language, code in found]


def with_blocks(*languages: str) -> list[Any]:
    pages = [page for page in PAGES if any(language in languages for language, _ in blocks(page))]
    return [pytest.param(page, id=page.relative_to(ROOT).as_posix()) for page in pages]


def prepare(page: Path) -> None:
    """Files that a page speaks of and the reader has."""
    if page.name == "fmu.md":
        rr.export_fmu("adhesion_brake", "bench.fmu", external=["slide_protection"])
        rr.export_fmu("bogie_rollers_constant", "bogie.fmu", kind="both")
    if page.name in ("profile.md", "getting_started.md"):
        Path("my_wheel.prw").write_text(simpack_text(rr.profile("s1002")))
    if page.name == "track.md":
        rows = "\n".join(f"{0.5 * i}, {0.1 * (i % 7)}" for i in range(4000))
        Path("my_track.csv").write_text(f"distance [m], vertical [mm]\n{rows}\n")
        points = (f"{1e3 * y} {1e3 * height}" for y, height in rr.profile("en_60e1_1_40").attrs["outline"])
        Path("worn_rail.txt").write_text("\n".join(points))


@pytest.mark.parametrize("page", with_blocks("python"))
def test_the_python_of_a_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    prepare(page)
    session: dict[str, Any] = {"__name__": "__main__"}
    printed = ""
    for language, code in blocks(page):
        if language == "toml" and (name := file_name(code)):
            Path(name).write_text(code)
        if language == "text" and printed:
            assert printed.rstrip() == code.rstrip()
        printed = ""
        if language == "python":
            compiled = compile(code, str(page.relative_to(ROOT)), "exec")
            if page.name in SERVED:
                continue
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(compiled, session)
            printed = out.getvalue()


def file_name(code: str) -> str:
    found = re.match(r"# (\w+\.toml)\n", code)
    return found[1] if found else ""


def test_the_first_lines_of_a_log_are_those_of_a_stop(tmp_path: Path) -> None:
    (lines,) = (code for _, code in blocks(ROOT / "docs/studies/fit.md") if code.startswith("time [s],"))
    (tmp_path / "stop.csv").write_text(lines)
    log = read_stop(tmp_path / "stop.csv", rr.load_case("adhesion_brake"))
    assert log.axles == ("wheelset_1", "wheelset_2")
    assert log.axle_speed == pytest.approx(120.0 / 3.6 / 0.46, rel=1e-4)


# ---------------------------------------------------------------------------------------------------------------- TOML


def whole(raw: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """The kind of file a block belongs to, and the block within a whole file of that kind."""
    starts = {
        "case": None,
        "vehicle": "manchester_vehicle_1",
        "support": "uic60_track",
        "programme": "slide_protection_stops",
        "plan": "",
        "fit": "",
    }
    for kind, name in starts.items():
        schema = json_schema(kind)  # type: ignore[arg-type]
        tables = [schema] if "properties" in schema else [schema["$defs"][name] for name in ("Rig", "Track")]
        if not raw.keys() <= {key for table in tables for key in table["properties"]}:
            continue
        if kind in ("plan", "fit"):
            return kind, raw
        if kind == "case":
            return kind, raw if raw.keys() & {"base", "time"} else {"base": base_of(raw), **raw}
        entry = tomllib.loads(catalog_file(kind, str(name)).read_text("utf-8"))  # type: ignore[arg-type]
        return kind, raw if "name" in raw and "element" not in raw else merged(entry, raw)
    raise AssertionError(f"no kind of file has {', '.join(raw)}")


def base_of(raw: dict[str, Any]) -> str:
    return "vehicle_track_irregular" if "support" in raw else "adhesion_brake"


def merged(entry: dict[str, Any], raw: dict[str, Any]) -> dict[str, Any]:
    """An entry of the catalogue with a block in it: items of lists by their names."""
    found = dict(entry)
    for key, value in raw.items():
        old = found.get(key)
        if isinstance(value, list) and isinstance(old, list) and value and isinstance(value[0], dict):
            label = "name" if "name" in value[0] else "criterion"
            names = {item[label] for item in value}
            found[key] = [*(item for item in old if item.get(label) not in names), *value]
        else:
            found[key] = {**old, **value} if isinstance(old, dict) and isinstance(value, dict) else value
    return found


@pytest.mark.parametrize("page", with_blocks("toml"))
def test_the_toml_of_a_page_is_read(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import tomli_w

    monkeypatch.chdir(tmp_path)
    prepare(page)
    Path("adhesion_map.csv").write_text("distance [m],friction\n0,0.08\n10,0.1\n20,0.11\n")
    Path("mine.py").write_text("class Mine:\n    sample_time = 1e-3\n    def step(self, measurements): ...\n")
    for language, code in blocks(page):
        if language == "toml":
            kind, raw = whole(tomllib.loads(code))
            name = file_name(code) or "block.toml"
            Path(name).write_text(code if file_name(code) else tomli_w.dumps(raw))
            if kind == "plan":
                load_plan(name)
            else:
                assert load_any(name)[0] == kind, code


# ------------------------------------------------------------------------------------------------------------- commands


def commands(page: Path) -> Iterator[list[str]]:
    for language, code in blocks(page):
        if language in ("bash", ""):
            for line in code.replace("\\\n", " ").splitlines():
                if line.startswith("rollerrig "):
                    yield shlex.split(line, comments=True)[1:]


@pytest.mark.parametrize("page", [param for param in with_blocks("bash", "") if list(commands(param.values[0]))])
def test_the_commands_of_a_page_are_understood(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    prepare(page)
    for name, *arguments in commands(page):
        if name.startswith("-"):
            continue
        command = GROUP.commands[name]
        if name != "catalog":
            command.make_context(name, list(arguments))  # raises where an option or value is wrong
        if name in QUICK and all(Path(word).exists() for word in arguments if word.endswith((".toml", ".nc"))):
            done = CliRunner().invoke(APP, [name, *arguments])
            assert done.exit_code == 0, (name, arguments, done.output)


def test_every_language_is_known() -> None:
    known = {"python", "toml", "bash", "text", "", "console", "matlab", "cpp"}
    assert {language for page in PAGES for language, _ in blocks(page)} <= known
