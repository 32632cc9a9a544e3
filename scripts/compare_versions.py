#!/usr/bin/env python
"""Do two versions of this program compute the same? Every shipped case, run by each, and the two compared.

    python scripts/compare_versions.py record OUT            with the Python of the version under test
    python scripts/compare_versions.py record OUT --perturb 1e-13    the same with every speed multiplied by 1 + 1e-13
    python scripts/compare_versions.py compare OLD NEW --perturbed PERTURBED_OLD [--perturbed ANOTHER]

`record` needs nothing of the package but `load_case`, `Case.with_changes`, `simulate`, `stability` and `contact`. It
runs each case as it ships, and short variants of some that use the other laws, methods and controllers.

Differences are relative to the largest magnitude of a variable in its run, or to LEAST of its unit if that is larger. A hunting
bogie or a brake controlled by dump valves amplifies round-off: with `--perturbed`, a difference may at any time be as large as
GROWTH times the one that the perturbed old versions have made until then, and 1e-9 in any case. The column `held until` says
up to which time 1e-9 itself was kept. Where half of the variables differ by PARTED the perturbed run is
another motion: from there on nothing is compared; the last table says how far each run was.
Differences that are meant stand in EXPECTED.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

TOLERANCE = 1e-9
GROWTH = 100.0
PARTED = 1e-4
LEAST = {
    "balance": 1.0,
    "1": 1e-3,
    "m": 1e-6,
    "rad": 1e-6,
    "m/s": 1e-4,
    "rad/s": 1e-4,
    "m/s^2": 1.0,
    "rad/s^2": 1.0,
    "N": 1.0,
    "N m": 1.0,
    "J": 1.0,
}
"""Magnitude below which a variable counts as zero, by unit: lateral motion of a symmetric case is round-off."""
MOST_SAMPLES = 2500
"""Longer runs are thinned."""
LEAST_DAMPED = 0.9
"""Eigenvalues are compared up to this damping ratio; near 1 a pair becomes two real ones by round-off."""

EXPECTED: dict[str, str] = {}
"""'case', 'case: variable' or ': variable' -> why it differs."""

SHORT = {"time.duration": 1.0}
LAWS = {
    "linear": {"contact.creep": "kalker_linear"},
    "spin moment": {"contact.creep": {"kind": "kalker_saturated", "saturate_spin_moment": True}},
    "fastsim": {"contact.creep": "fastsim"},
    "modified fastsim": {
        "contact.creep": {"kind": "modified_fastsim", "k_0": 0.6, "k_inf": 0.4, "beta": 0.3},
        "contact.friction": {"kind": "falling", "mu_0": 0.3, "A": 0.4, "B": 0.6},
    },
    "polach": {"contact.creep": {"kind": "polach", "k_A": 0.8, "k_S": 0.4}},
    "table": {"contact.creep": "table"},
    "strips": {"contact.normal": "strips"},
    "strips table": {"contact.normal": "strips", "contact.creep": "table"},
    "bare rule": {"contact.normal": {"kind": "hertz", "merging_criterion": 0.0}},
    "no roller effects": {
        "contact.roller_effects": {"curvature": False, "conicity": False, "spin": False, "yaw": False}
    },
    "dormand_prince": {"time.method": "dormand_prince", "time.step": None},
    "exponential": {"time.method": "exponential_rk4", "time.step": 5e-4},
    "rodas4": {"time.method": "rodas4", "time.step": None},
    "free": {"motion.drive": "free"},
}
TRACK = {"support.use": "uic60_track", "rig_control": None, "motion.drive": "speed_controlled"}
CONTROL = {
    "track": TRACK,
    "kalman": {"rig_control.estimator.kind": "kalman"},
    "derivative": {"rig_control.estimator.kind": "filtered_derivative"},
    "exact": {"rig_control.estimator.kind": "exact"},
    "sliding mode": {"rig_control.feedback.kind": "sliding_mode"},
    "no feedback": {"rig_control.feedback.kind": "none"},
    "ideal rolling": {"contact.pure_rolling": True},
    "sensors": {
        "sensors.axles": {"counts": 1024.0, "jitter": 0.1, "window": 4},
        "sensors.rollers": {"counts": 4096.0},
        "sensors.roller_torque": {"bandwidth": 50.0, "noise": 20.0, "resolution": 5.0, "range": 2e4},
        "rig_control.loads": "measured",
        "rig_control.delay": 2e-3,
    },
    "wrong radius": {"rig_control.assumed.wheel_radius": 0.455, "rig_control.load_transfer": "none"},
    "cleaning": {"adhesion.recovery_constant": 1e-4},
}
VARIANTS = {
    **{f"bogie_rollers_constant, {name}": {**SHORT, **law} for name, law in LAWS.items()},
    **{f"bogie_track, {name}": {**SHORT, **LAWS[name]} for name in ("polach", "strips", "table", "exponential")},
    **{f"adhesion_brake, {name}": {"time.duration": 2.5, **change} for name, change in CONTROL.items()},
    "bogie_rollers_constant, torque": {
        **SHORT,
        "motion.drive": "torque",
        "motion.torque_table": [[0.0, 0.0], [0.5, 2000.0], [1.0, 500.0]],
        "support.coupling": "independent",
    },
    "vehicle_rollers, irregular": {**SHORT, "support.irregularity": {"kind": "ore_b176", "level": "low"}},
    "vehicle_track_irregular, elastic": {
        **SHORT,
        "support.foundation": {
            "rail_mass": 300.0,
            "lateral": {"stiffness": 2e7, "damping": 5e4},
            "vertical": {"stiffness": 5e7, "damping": 2e5},
        },
    },
    "adhesion_brake, axle-hung motors": {
        "time.duration": 2.5,
        "brake.by_traction_motors": True,
        "traction": {"suspension": "axle", "link": 1.0, "motor": {"rotor_inertia": 0.5, "gear_ratio": -3.0}},
    },
}
"""'case, what' -> what is changed."""

SPEEDS_KMH = (100.0, 200.0)
STABILITY = {
    "bogie_rollers_constant": {},
    "bogie_track": {},
    "vehicle_rollers": {},
    "bogie_rollers_constant, polach": LAWS["polach"],
    "bogie_rollers_constant, strips": LAWS["strips"],
    "bogie_rollers_constant, fastsim": LAWS["fastsim"],
}
CONTACT_MM = (-7.0, -5.5, -3.0, -0.5, 0.0, 2.0, 5.0, 6.5)
CONTACTS = {
    "contact_benchmark_track": {},
    "contact_benchmark_rollers": {},
    "contact_benchmark_track, strips": LAWS["strips"],
    "contact_benchmark_rollers, strips": LAWS["strips"],
}

Values = dict[str, np.ndarray]


def main() -> int:
    """Record or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    recording = commands.add_parser("record")
    recording.add_argument("out", type=Path)
    recording.add_argument("--perturb", type=float, default=0.0, help="every speed times 1 plus this")
    recording.add_argument("--only", default="", help="only what has this text in its name")
    comparing = commands.add_parser("compare")
    comparing.add_argument("old", type=Path)
    comparing.add_argument("new", type=Path)
    comparing.add_argument(
        "--perturbed", type=Path, action="append", default=[], help="perturbed record of the old version"
    )
    comparing.add_argument("--tolerance", type=float, default=TOLERANCE)
    comparing.add_argument("--lines", type=int, default=30, help="rows of the table")
    asked = parser.parse_args()
    if asked.command == "record":
        record(asked.out, asked.perturb, asked.only)
        return 0
    return compare(asked.old, asked.new, asked.perturbed, asked.tolerance, asked.lines)


# ------------------------------------------------------------------------------------------------------------ record


def record(out: Path, perturb: float, only: str) -> None:
    """Run everything and write one .npz per job."""
    import rollerrig

    out.mkdir(parents=True, exist_ok=True)
    factor = 1.0 + perturb
    folder = Path(rollerrig.__file__).parent / "catalog" / "cases"
    cases = {path.stem: {} for path in sorted(folder.glob("*.toml"))}
    jobs = [(run_values, name, name, changes) for name, changes in (cases | VARIANTS).items()]
    jobs += [(stability_values, f"stability {name}", name, changes) for name, changes in STABILITY.items()]
    jobs += [(contact_values, f"contact {name}", name, changes) for name, changes in CONTACTS.items()]
    begun, spent = time.process_time(), 0.0
    for work, title, name, changes in jobs:
        if only not in title:
            continue
        file = out / f"{title}.npz"
        file.unlink(missing_ok=True)
        try:
            case = faster(rollerrig.load_case(name.split(",")[0]).with_changes(changes), factor)
            np.savez_compressed(file, **work(case, factor))
        except Exception as error:  # the others shall be recorded; `compare` misses this one
            print(f"{title}: {type(error).__name__}: {error}", flush=True)
        last, spent = spent, time.process_time() - begun
        print(f"{title}: {spent - last:.1f} s", flush=True)
    print(f"{spent:.0f} s of processor time")


def faster(case: Any, factor: float) -> Any:
    """The case with its speed times a factor."""
    if factor == 1.0:
        return case
    table = case.motion.speed_table
    if table is None:
        return case.with_changes({"motion.speed": f"{case.motion.speed * factor} m/s"})
    rows = [[t, f"{v * factor} m/s"] for t, v in table]
    return case.with_changes({"motion.speed_table": rows, "motion.speed": rows[0][1]})


def run_values(case: Any, _: float) -> Values:
    """All floating-point variables of a run; the energy residual over the energy turned over."""
    import rollerrig

    run = rollerrig.simulate(case)
    residual = run["energy_residual"] / run.attrs["energy_turned_over_j"]  # the difference of large numbers
    run = run.assign(energy_residual=residual.assign_attrs(units="balance"))
    run = run.drop_dims([dim for dim in run.dims if dim == "reading_time"])  # the same forces, more often
    return floats(run.isel(time=slice(None, None, -(-run.sizes["time"] // MOST_SAMPLES))))


def stability_values(case: Any, factor: float) -> Values:
    """Eigenvalues at two speeds, in the order of frequency and growth rate."""
    import rollerrig

    modes = rollerrig.stability(case, speeds_kmh=[factor * v for v in SPEEDS_KMH])
    found = {}
    for row, speed in enumerate(SPEEDS_KMH):
        rate, angular = modes["growth_rate"].to_numpy()[row], modes["angular_frequency"].to_numpy()[row]
        kept = -rate < LEAST_DAMPED * np.hypot(rate, angular)
        order = np.lexsort((np.round(rate[kept], 6), np.round(angular[kept], 6)))
        found[f"growth_rate {speed:g}"] = rate[kept][order]
        found[f"angular_frequency {speed:g}"] = angular[kept][order]
    return found


def contact_values(case: Any, factor: float) -> Values:
    """Contact patches of the loaded wheelset over its lateral position."""
    import rollerrig

    return floats(rollerrig.contact(case, [(1e-3 * factor * y, 1e-4 * y) for y in CONTACT_MM]))


def floats(dataset: Any) -> Values:
    """Floating-point variables and the time; as "least" the magnitude below which each counts as zero."""
    found = {str(name): variable for name, variable in dataset.variables.items() if variable.dtype.kind == "f"}
    least = [LEAST.get(variable.attrs.get("units", ""), 0.0) for variable in found.values()]
    return {"least": np.array(least)} | {name: variable.to_numpy() for name, variable in found.items()}


# ----------------------------------------------------------------------------------------------------------- compare


class Finding(NamedTuple):
    """How far one variable of one job differs.

    Attributes:
        ratio: largest difference over what is allowed there.
        difference: largest difference while compared.
        held: time until which it was within the tolerance [s]; NaN without time.
        compared: time until which it was compared [s]; NaN without time.
    """

    ratio: float
    difference: float
    held: float
    compared: float


def compare(old: Path, new: Path, perturbed: list[Path], tolerance: float, lines: int) -> int:
    """Print the differences, worst first, and how far each job was compared; 1 if one is larger than allowed."""
    rows: list[tuple[str, str, Finding]] = []
    problems: list[str] = []
    for file in sorted(old.glob("*.npz")):
        if not (new / file.name).exists():
            problems.append(f"{file.stem}: not there")
            continue
        wobble = [load(folder / file.name) for folder in perturbed]
        found, missing = differences(load(file), load(new / file.name), wobble, tolerance)
        problems += [f"{file.stem}: {text}" for text in missing]
        rows += [(file.stem, variable, finding) for variable, finding in found.items()]
    rows.sort(key=lambda row: (-row[2].ratio, -row[2].difference))
    failed = [row for row in rows if not row[2].ratio <= 1.0 and not expected(*row[:2])]
    shown = max(lines, sum(row[2].ratio > 1.0 for row in rows))
    print(f"{'case':44} {'variable':30} {'difference':>10} {'/ allowed':>9} {'held until':>10} {'compared':>10}")
    for title, variable, (ratio, difference, held, compared) in [row for row in rows if row[2].difference][:shown]:
        reason = expected(title, variable) if ratio > 1.0 else ""
        print(f"{title:44} {variable:30} {difference:10.1e} {ratio:9.1e} {held:8.4g} s {compared:8.4g} s {reason}")
    print(f"\n{'case':44} {'identical':>12} {'half the variables held until':>30} {'and compared':>20}")
    for title in sorted({row[0] for row in rows}):
        of_it = [row[2] for row in rows if row[0] == title]
        same = sum(one.difference == 0.0 for one in of_it)
        held, compared = (float(np.median([getattr(one, key) for one in of_it])) for key in ("held", "compared"))
        print(f"{title:44} {same:4} of {len(of_it):4} {held:28.4g} s {compared:18.4g} s")
    print(f"\n{len(rows)} variables, {len(failed)} beyond what is allowed, {len(problems)} other problems")
    print("\n".join(problems))
    return 1 if failed or problems else 0


def load(path: Path) -> Values:
    """The arrays of a file."""
    with np.load(path) as file:
        return {name: file[name] for name in file.files}


def differences(
    old: Values, new: Values, perturbed: list[Values], tolerance: float
) -> tuple[dict[str, Finding], list[str]]:
    """How far each variable differs, and what is missing or new."""
    found, problems = {}, []
    names = [name for name in old if name != "least"]
    least = dict(zip(names, old.get("least", ()), strict=False))
    growth = {name: spread(name, old, perturbed, least.get(name, 0.0)) for name in names}
    end = parted(old, growth)
    for name in names:
        if name not in new:
            problems.append(f"no variable '{name}'")
            continue
        over_time = is_over_time(name, old)
        difference = relative(old[name], new[name], over_time, least.get(name, 0.0))
        allowed = np.maximum(tolerance, GROWTH * growth[name][: len(difference)])
        compared = growth[name][: len(difference)] <= PARTED
        if over_time:
            compared &= np.arange(len(difference)) < end
        difference = np.where(compared, difference, 0.0)
        ratio = np.divide(difference, allowed, out=np.zeros(len(difference)), where=compared)
        times = [until(old["time"], good) if over_time else np.nan for good in (difference <= tolerance, compared)]
        found[name] = Finding(float(ratio.max()), float(difference.max()), min(times), times[1])
    problems += [f"new variable '{name}'" for name in new if name not in old and not expected("", name)]
    return found, problems


def is_over_time(name: str, old: Values) -> bool:
    """Whether the first dimension of a variable is time."""
    return old[name].ndim > 0 and len(old[name]) == len(old.get("time", ()))


def spread(name: str, old: Values, perturbed: list[Values], least: float) -> np.ndarray:
    """Largest difference of the perturbed runs until each time."""
    over_time = is_over_time(name, old)
    result = np.zeros(len(old[name]) if over_time else 1)
    for one in perturbed:
        gap = np.maximum.accumulate(relative(old[name], one[name], over_time, least))
        result = np.maximum(result, np.pad(gap, (0, max(0, len(result) - len(gap))), mode="edge")[: len(result)])
    return result


def parted(old: Values, growth: Values) -> int:
    """Sample at which half of the variables of the perturbed runs are PARTED away; the run is compared until then."""
    ends = sorted(int(np.argmax(one > PARTED)) or len(one) for name, one in growth.items() if is_over_time(name, old))
    return ends[len(ends) // 2] if ends else 0


def until(times: np.ndarray, good: np.ndarray) -> float:
    """Time of the first sample that is not good, or of the last one."""
    bad = np.nonzero(~good)[0]
    return float(times[bad[0] if bad.size else len(good) - 1])


def relative(old: np.ndarray, new: np.ndarray, over_time: bool, least: float) -> np.ndarray:
    """Difference over the largest magnitude of the old: one for each time, or one; infinite where one alone is NaN.

    Of two runs of different length the common part counts, and the difference at its end is infinite.
    """
    count = min(len(old), len(new)) if over_time else 1
    first, second = (old[:count], new[:count]) if over_time else (old[np.newaxis], new[np.newaxis])
    if first.shape != second.shape:
        return np.full(count, np.inf)
    finite = np.abs(old[np.isfinite(old)])
    scale = max(float(finite.max(initial=0.0)), least) or 1.0
    gap = np.where(np.isnan(first) & np.isnan(second), 0.0, np.abs(second - first) / scale)
    gap = np.where(np.isnan(gap), np.inf, gap).reshape(count, -1)
    result = gap.max(axis=1, initial=0.0)
    if over_time and len(old) != len(new):
        result[-1] = np.inf
    return result


def expected(title: str, variable: str) -> str:
    """Why a difference is meant, or nothing."""
    return next((EXPECTED[key] for key in (f"{title}: {variable}", f": {variable}", title) if key in EXPECTED), "")


if __name__ == "__main__":
    sys.exit(main())
