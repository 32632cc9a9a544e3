"""Cases and files of absurd size: `check` answers within 10 s and 1 GB, or says what is too large."""

from __future__ import annotations

import random
import subprocess
import sys
import tempfile
from pathlib import Path

from rollerrig.config import ConfigError

REFUSALS = (ConfigError,)
SECONDS, KILOBYTES = 10.0, 2**20
CHECK = """import resource, sys, time
from rollerrig.cli import main
begun, code = time.process_time(), 0
try:
    main(["check", *sys.argv[1:]])
except SystemExit as end:
    code = end.code or 0
used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print("USED", code, time.process_time() - begun, used)
"""
BASES = ("wheelset_rollers", "adhesion_brake", "vehicle_track_irregular", "vehicle_curve")
LARGE = ("1e9 s", "1e15 s", "1e6 s", "1e-12 s", "1e-300 s", "1e12 m", "1e-9 m", "1e300 m")
KEYS = ("time.duration", "time.output_step", "time.step", "time.maximum_step", "support.irregularity.longest",
        "support.irregularity.shortest", "support.irregularity.length", "motion.distance")  # fmt: skip


def prepare() -> Path:
    return Path(tempfile.mkdtemp(prefix="hostile"))


def attack(folder: Path, choose: random.Random) -> str:
    path = folder / "case.toml"
    path.write_text(text(choose))
    command = [sys.executable, "-c", CHECK, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    if "USED" not in done.stdout:
        raise AssertionError(f"exit code {done.returncode}: {done.stderr[-300:]}")
    code, seconds, kilobytes = done.stdout.rsplit("USED", 1)[1].split()
    if float(seconds) > SECONDS or int(kilobytes) > KILOBYTES:
        return f"nonsense {float(seconds):.1f} s and {int(kilobytes) / 1e6:.1f} GB for {path.read_text()[:120]!r}"
    return "ran" if code == "0" else "refused"


def text(choose: random.Random) -> str:
    """A case that asks for much, or a text that is long or deep."""
    count = choose.choice([1000, 100_000, 400_000])
    match choose.choice(["numbers", "numbers", "numbers", "points", "segments", "vehicle", "deep", "strings", "keys"]):
        case "numbers":
            lines = [f'base = "{choose.choice(BASES)}"', "[changes]"]
            lines += [f'"{key}" = "{choose.choice(LARGE)}"' for key in choose.sample(KEYS, choose.choice([1, 2]))]
            return "\n".join(lines)
        case "points":
            rows = ", ".join(f"[{k}, 30]" for k in range(count))
            return f'base = "adhesion_brake"\n[changes]\n"brake.demand" = [{rows}]\n"motion.speed" = [{rows}]\n'
        case "segments":
            one = '[[support.segment]]\nkind = "curve"\nlength = "1 m"\nradius = "300 m"\n'
            return 'base = "vehicle_curve"\n' + one * (count // 20)
        case "vehicle":
            one = '[[vehicle.body]]\nname = "b{}"\nmass = "1 t"\n'
            return 'base = "bogie_track"\n' + "".join(one.format(k) for k in range(count // 20))
        case "deep":
            return "a = " + choose.choice(["[", "{a=", "[{a="]) * count
        case "strings":
            return f'name = "{"x" * count}"\nbase = "{"y" * count}"\n'
    return "\n".join(f"k{k} = {k}" for k in range(count // 4))
