"""Commands and options that README and documentation show exist."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import typer

from rollerrig.cli.app import build_app
from rollerrig.study import heads

ROOT = Path(__file__).resolve().parents[3]
PAGES = [ROOT / "README.md", *sorted(p for p in (ROOT / "docs").rglob("*.md") if "generated" not in p.parts)]
GROUP = typer.main.get_command(build_app())
OPTIONS = {
    name: {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
    for name, command in GROUP.commands.items()
}


def shown(page: Path) -> list[tuple[str, list[str]]]:
    """Commands in code, each with its options."""
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    code = re.findall(r"```(?:bash)?\n(.*?)```", text, re.DOTALL) + re.findall(r"`(rollerrig [^`\n]+)`", text)
    lines = [line.split("#")[0] for block in code for line in block.splitlines() if line.startswith("rollerrig ")]
    return [(line.split()[1], re.findall(r"(?<= )--[a-z-]+", line)) for line in lines]


@pytest.mark.parametrize("page", [page for page in PAGES if shown(page)], ids=lambda p: str(p.relative_to(ROOT)))
def test_commands_and_options_exist(page: Path) -> None:
    for command, options in shown(page):
        assert command in OPTIONS or command.startswith("-"), command
        assert set(options) <= OPTIONS.get(command, {"--help", "--version"}), command


def test_what_commands_cost_stands_in_their_help_and_on_the_page() -> None:
    costs = json.loads((ROOT / "python/rollerrig/cli/costs.json").read_text(encoding="utf-8"))
    page = (ROOT / "docs/performance.md").read_text(encoding="utf-8")
    assert set(costs) <= set(heads())
    for name, one in costs.items():
        assert f"| `rollerrig {one['example']}` | {one['processor_s']:g} s |" in page
        assert f"Cost: 'rollerrig {one['example']}' takes" in (GROUP.commands[name].help or "")
    readme = re.findall(r"`([a-z]+)` ([0-9]+) s\b", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert len(readme) > 3
    assert {name: float(seconds) for name, seconds in readme}.items() <= {
        n: c["processor_s"] for n, c in costs.items()
    }.items()
