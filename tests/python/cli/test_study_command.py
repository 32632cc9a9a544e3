"""Commands that follow from functions: an option has its argument's default, meaning and unit, and is read as it is shown."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from importlib import import_module
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from called import called
from rollerrig.cli.app import build_app
from rollerrig.cli.study_command import _options, _shown, _value
from rollerrig.study import heads
from rollerrig.study.options import UNITS, Option, Parameter, head, parameters

STUDIES = {name: parameters(head(name)) for name in heads()}
EVERY = [(name, one) for name, found in STUDIES.items() for one in found]
GROUP = typer.main.get_command(build_app())


@pytest.mark.parametrize(("name", "one"), EVERY, ids=lambda v: v if isinstance(v, str) else v.name)
def test_an_option_that_is_not_given_is_the_default_of_the_argument(name: str, one: Parameter) -> None:
    if not one.options or any(option.default is not None for option in one.options):
        return  # a place of its own, or said to have another default
    given = {parameter.name: parameter.default for parameter in _options(one)}
    if inspect.Parameter.empty in given.values():
        assert one.default is inspect.Parameter.empty
        return
    value, default = _value(one, given), one.default
    assert value == (pytest.approx(default, rel=1e-12) if isinstance(default, float) else default) or (
        isinstance(default, tuple) and value == pytest.approx(default, rel=1e-12)
    )


@pytest.mark.parametrize("name", STUDIES)
def test_help_has_the_meaning_of_every_argument_and_no_unit_of_the_other_side(name: str) -> None:
    text = " ".join(CliRunner().invoke(build_app(), [name, "--help"], terminal_width=1000).stdout.split()).lower()
    for one in STUDIES[name]:
        for option in one.options:
            words = (option.meaning or one.meaning).replace("None: ", "absent: ").lower()
            unit, other = option.unit.lower(), UNITS[option.unit][0].lower()
            assert words.replace(f"[{other}]", f"[{unit}]") in text, (name, one.name)


@pytest.mark.parametrize("name", STUDIES)
def test_the_head_that_is_read_is_that_of_the_function(name: str) -> None:
    function = getattr(import_module(f"rollerrig.{heads()[name][0]}"), name)
    own, read = (inspect.signature(one).parameters for one in (function, head(name)))
    assert {key: one.replace(annotation="") for key, one in own.items()} == {
        key: one.replace(annotation="") for key, one in read.items()
    }
    assert inspect.getdoc(function) == inspect.getdoc(head(name))
    assert [str(one.annotation) for one in own.values() if "Option" in str(one.annotation)] == []


@pytest.mark.parametrize(
    ("value", "option", "text"),
    [
        ((0.001, 0.002, 0.003, 0.004), Option(unit="mm"), "1:4:1"),
        ((60.0, 80.0, 100.0), Option(), "60,80,100"),
        ((-0.06, 0.0, 0.1), Option(unit="mm"), "-60,0,100"),
        (("rig", "track"), Option(commas=True), "rig,track"),
        (3e-3, Option(unit="mm"), 3.0),
    ],
)
def test_defaults_are_shown_in_the_unit_of_the_option(value: Any, option: Option, text: Any) -> None:
    assert _shown(value, option) == text


def test_an_option_in_another_unit_reaches_the_function_in_si() -> None:
    (one,) = (one for one in STUDIES["response"] if one.name == "brake_pressure")
    assert _value(one, {"brake_pressure": 2.5}) == pytest.approx(2.5e5)
    (two,) = (one for one in STUDIES["response"] if one.name == "frequencies")
    assert _value(two, {"from_hz": 1.0, "to_hz": 5.0}) == (1.0, 5.0)


def test_numbers_of_a_list_keep_their_range() -> None:
    done = called("compare", "manchester_vehicle_1", "--radii-m", "0.01", "--out", "x")
    assert done.exit_code == 2
    assert "must lie between 0.05 and 1e+06" in " ".join(re.sub("[│╭╮╰╯─]", " ", done.output).split())


def test_help_is_there_where_docstrings_are_stripped() -> None:
    command = [sys.executable, "-OO", "-c", "from rollerrig.cli import main; main()", "scale", "--help"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "A scaled rig by similitude" in done.stdout, done.stderr
