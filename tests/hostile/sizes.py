"""Cases and files of absurd size: `check` answers within 10 s and 1 GB, or says what is too large."""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
from pathlib import Path

from rollerrig.cli import main
from rollerrig.config import ConfigError

REFUSALS = (ConfigError,)
SECONDS, KILOBYTES = 10.0, 2**20
BASES = ("wheelset_rollers", "adhesion_brake", "vehicle_track_irregular", "vehicle_curve")
LARGE = ("1e9 s", "1e15 s", "1e6 s", "1e-12 s", "1e-300 s", "1e12 m", "1e-9 m", "1e300 m")
KEYS = ("time.duration", "time.output_step", "time.step", "time.maximum_step", "support.irregularity.longest",
        "support.irregularity.shortest", "support.irregularity.length", "motion.distance")  # fmt: skip


def prepare() -> Path:
    return Path(tempfile.mkdtemp(prefix="hostile"))


def attack(folder: Path, choose: random.Random) -> str:
    path = folder / "case.toml"
    path.write_text(text(choose))
    pid = os.fork()
    if pid == 0:
        os._exit(checked(path))
    _, status, used = os.wait4(pid, 0)
    code, seconds = os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime
    if code not in (0, 2):
        raise AssertionError(f"exit code {code} for {path.read_text()[:120]!r}")
    if seconds > SECONDS or used.ru_maxrss > KILOBYTES:
        return f"nonsense {seconds:.1f} s and {used.ru_maxrss / 1e6:.1f} GB for {path.read_text()[:120]!r}"
    return "ran" if code == 0 else "refused"


def checked(path: Path) -> int:
    """What the command says, within a minute of the processor."""
    signal.setitimer(signal.ITIMER_PROF, 60.0)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    sys.argv = ["rollerrig", "check", str(path)]
    try:
        main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except BaseException:
        return 99
    return 0


def text(choose: random.Random) -> str:
    """A case that asks for much, or a text that is long or deep."""
    count = choose.choice([1000, 100_000, 400_000])
    match choose.choice(["numbers", "numbers", "numbers", "points", "segments", "vehicle", "deep", "strings", "keys"]):
        case "numbers":
            lines = [f'base = "{choose.choice(BASES)}"']
            lines += [f'{key} = "{choose.choice(LARGE)}"' for key in choose.sample(KEYS, choose.choice([1, 2]))]
            return "\n".join(lines)
        case "points":
            rows = ", ".join(f"[{k}, 30]" for k in range(count))
            return f'base = "adhesion_brake"\nbrake.demand = [{rows}]\nmotion.speed = [{rows}]\n'
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
