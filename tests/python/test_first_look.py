"""`scripts/watch`: one hunt in motion, without its installation."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("bash") is None or shutil.which("c++") is None, reason="needs bash and a compiler")
def test_a_first_look_shows_a_bogie_that_hunts(tmp_path: Path) -> None:
    programs = tmp_path / "venv" / "bin"
    programs.mkdir(parents=True)
    for name, text in (
        ("python", "exit 0"),  # pip has installed already
        ("rollerrig", f'exec {sys.executable} -c "from rollerrig.cli import main; main()" "$@"'),
    ):
        (programs / name).write_text(f"#!/bin/sh\n{text}\n")
        (programs / name).chmod(0o755)
    (tmp_path / "scripts").mkdir()
    for name in ("watch", "environment.sh"):
        shutil.copy(ROOT / "scripts" / name, tmp_path / "scripts")
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = subprocess.run(
        [tmp_path / "scripts" / "watch", "look"],
        env=environment | {"VENV": str(tmp_path / "venv")}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "It hunts: wheelset 1 moved sideways by up to " in done.stderr
    assert f"in motion: {tmp_path / 'look' / 'view.html'}" in done.stdout
    assert (tmp_path / "look" / "view.html").is_file()
