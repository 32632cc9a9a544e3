"""Write docs/benchmarks.md: the program beside published benchmarks of hunting and closed forms.

python tests/validation/write_benchmarks.py
"""

from __future__ import annotations

import json
import sys
from functools import cache
from math import sqrt
from pathlib import Path

import numpy as np

import rollerrig as rr
from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.config import Case

sys.path[:0] = [str(Path(__file__).parents[1])]

from validation.textbook_bogie import Bogie, effects  # noqa: E402
from validation.write_measured import table  # noqa: E402

PAGE = Path(__file__).parents[2] / "docs" / "benchmarks.md"
PUBLISHED = 68.66
"""Critical speed of Cooperrider's bogie: Hopf bifurcation [m/s]."""
RAIL_RADIUS = 0.3
"""Of the heads of `textbook_track` [m]."""
SPEEDS = (108.0, 180.0, 234.0, 288.0, 396.0)
"""Range in which critical speeds are looked for [km/h]."""
ORBIT, REST, LARGE, SMALL = (70.0, 8e-3), (60.0, 8e-3), (68.4, 9e-3), (68.4, 1e-3)
"""Speed [m/s] and offset of wheelset 1 [m] of runs: the published two, and two just below the critical speed."""

INTRODUCTION = """# Published benchmarks

Models of hunting from the literature, entered as cases with the creep coefficients that they state: what was published, what
the program gives, and why the two differ. This page is written by `python tests/validation/write_benchmarks.py`, and a test
compares it with the program. {doc}`how_to/textbook_vehicle` says how such a vehicle is entered.
"""


@cache
def case(name: str = "cooperrider_bogie") -> Case:
    return rr.load_case(name)


@cache
def critical(name: str = "cooperrider_bogie") -> tuple[float, float]:
    """Linear critical speed of a case [m/s] and its frequency [Hz]."""
    onset = scan_linear(case(name), SPEEDS).onset
    assert onset is not None
    return onset.speed, onset.frequency


@cache
def amplitude(speed: float, offset: float, duration: float = 10.0) -> tuple[float, float]:
    """Half of peak to peak of wheelset 1 over two periods after half the run and at its end [mm]."""
    changes = {"motion.speed": f"{speed} m/s", "disturbance[0].lateral": offset, "time.duration": duration}
    run = rr.simulate(case().with_changes(changes))
    return peaks(run["time"].to_numpy(), run["lateral"].sel(body="wheelset_1").to_numpy())


def peaks(time: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Half of peak to peak over half a second after half the time and at the end [mm]."""
    spans = ((time > end - 0.5) & (time <= end) for end in (time[-1] / 2, time[-1]))
    first, last = (500.0 * float(np.ptp(y[span])) for span in spans)
    return first, last


@cache
def fold() -> tuple[float, float]:
    """Speed [m/s] and amplitude [mm] at which the limit cycles become stable, the lowest speed that has any."""
    branch = rr.bifurcation(case(), range(220, 281, 10), largest=10e-3)
    (found,) = json.loads(branch.attrs["folds"])
    return found["speed_kmh"] / 3.6, found["amplitude_mm"]


@cache
def equations() -> dict[str, tuple[float, float]]:
    """Critical speed [m/s] and frequency [Hz] of the textbook's equations, with one after the other of what they leave out."""
    bodies = case().vehicle.data.body
    weight = case().gravity * sum(body.mass for body in bodies) / 2
    spin_inertia = bodies[-1].inertia[1]
    cases = effects(Bogie(), rail_radius=RAIL_RADIUS, spin_inertia=spin_inertia, weight=weight)
    return {name: bogie.critical_speed() for name, bogie in cases.items()}


def wheelset_formula(conicity: float = 0.05, s: float = 1.0) -> float:
    """Critical speed of a wheelset on springs [m/s]: where its quartic has the roots +-i w."""
    data = case("suspended_wheelset")
    (wheelset,) = (body for body in data.vehicle.data.body if body.kind == "wheelset")
    spring = next(e for e in data.vehicle.data.element if e.x is not None and e.y is not None)
    m, inertia, radius = wheelset.mass, wheelset.inertia[2], data.vehicle.data.wheel.radius
    k_y, k_yaw = 2 * spring.y.stiffness, 2 * spring.x.stiffness * spring.end_a[1] ** 2
    creep, half = data.contact.creep, 0.7163
    f11, f22 = creep.f11, creep.f22
    squared = (s * s * f22 * k_yaw + f11 * half**2 * k_y) / (m * f11 * half**2 + inertia * s * s * f22)
    steering = 4 * s * f11 * f22 * half * conicity / radius
    below = (m * squared - k_y) * (inertia * squared - k_yaw) + steering
    return sqrt(4 * s * s * f11 * f22 * half**2 * squared / below)


def percent(here: float, there: float) -> str:
    return f"{100 * (here / there - 1):+.2f} %"


def overview() -> str:
    here, lone = critical()[0], critical("suspended_wheelset")[0]
    formula = wheelset_formula()
    orbit, rest = amplitude(*ORBIT), amplitude(*REST)
    body = [
        ["Cooperrider's bogie: Hopf bifurcation", f"{PUBLISHED} m/s", f"{here:.2f} m/s", percent(here, PUBLISHED)],
        [
            "the same: from a large disturbance at 70 m/s",
            "periodic orbit",
            f"orbit of {orbit[1]:.1f} mm",
            "in agreement",
        ],
        ["the same at 60 m/s", "rest", f"rest: {rest[1]:.2f} mm after 10 s", "in agreement"],
        ["the same: fold of the limit cycles", "none at hand", "{:.2f} m/s, {:.2f} mm".format(*fold()), ""],
        [
            "wheelset on springs: critical speed",
            f"{formula:.2f} m/s, closed form",
            f"{lone:.2f} m/s",
            percent(lone, formula),
        ],
    ]
    return "## Overview\n\n" + table(["benchmark", "published, or closed form", "here", "difference"], body)


def cooperrider() -> str:
    here, steps = critical(), equations()
    rows = [["published", f"{PUBLISHED:.2f}", ""]]
    rows += [[name, f"{v:.2f}", f"{frequency:.2f}"] for name, (v, frequency) in steps.items()]
    rows += [["this program", f"{here[0]:.2f}", f"{here[1]:.2f}"]]
    speeds = np.array([v for v, _ in steps.values()])
    sizes = 100 * np.abs(np.diff(speeds)) / speeds[0]
    runs = []
    for speed, offset in (ORBIT, REST, LARGE, SMALL):
        own, theirs = amplitude(speed, offset), peaks(*Bogie().run(speed, offset))
        runs.append([f"{speed:g} m/s", f"{1e3 * offset:g} mm", *(f"{x:.2f}" for x in (*own, *theirs))])
    head = ["speed", "released from", "here, after 5 s", "at 10 s", "seven equations, after 5 s", "at 10 s"]
    texts = {"linear": table(["critical speed", "m/s", "Hz"], rows), "runs": table(head, runs)}
    rest = percent(here[0], float(speeds[-1]))
    folded = dict(zip(("fold_speed", "fold_amplitude"), fold(), strict=True))
    return COOPERRIDER.format(
        **texts, **folded, least=sizes.min(), most=sizes.max(), rest=rest, near=percent(here[0], PUBLISHED)
    )


COOPERRIDER = """## Cooperrider's bogie

`cooperrider_bogie`: two wheelsets in a frame below a car body that runs straight; conical wheels, linear springs, creep forces
after Vermeulen and Johnson, flanges as springs with a play of 9.1 mm. N. K. Cooperrider, *The hunting behavior of conventional
railway trucks*, J. Eng. Ind. 94 (1972); numbers of C. Kaas-Petersen, *Chaos in a railway bogie*, Acta Mechanica 61 (1986).
Published (bifurcation.de, example D10): straight running becomes unstable at 68.66 m/s in a Hopf bifurcation, hard; at 70 m/s a
periodic orbit attracts, at 60 m/s the state of rest. That page writes mph, the equations are in SI units.

{linear}
The papers themselves were not at hand. The same springs, dampers and heights are those of an open program
(D. Bigoni, DYTSI); that all numbers are theirs is known from the published speed, which seven equations written a second time
(`tests/validation/textbook_bogie.py`) return. These leave out that a wheelset which moves sideways rolls, since one wheel climbs.
Each consequence moves the critical speed by {least:.1f} to {most:.1f} %; {rest} are left to all that the
program has beyond these, the elastic contacts and loaded springs among them. That they sum up to {near} is chance: in
another bogie they need not cancel.

Half of peak to peak of the leading wheelset in mm, over half a second. Just below the critical speed a large disturbance ends
in an orbit and a small one decays: the loss of stability is hard here as well. Followed as periodic solutions
(`rollerrig stability cooperrider_bogie --branch-mm 10`), the limit cycles are unstable from the critical speed back to a fold
at {fold_speed:.2f} m/s and {fold_amplitude:.2f} mm, and stable from there on.

{runs}"""

WHEELSET = """## A wheelset on springs

`suspended_wheelset`: y and yaw count, creep is linear without spin. The reference is a closed form, not a published number: the
quartic of the textbook's two equations (A. H. Wickens, *Fundamentals of Rail Vehicle Dynamics*, 2003, chapter 2) has a pair of
imaginary roots ±iω at

$$
\\omega^2 = \\frac{{f_{{22}} k_\\psi + f_{{11}} l^2 k_y}}{{m f_{{11}} l^2 + I f_{{22}}}}, \\qquad
V^2 = \\frac{{4 f_{{11}} f_{{22}}\\, l^2 \\omega^2}}
{{(m\\omega^2 - k_y)(I\\omega^2 - k_\\psi) + 4 f_{{11}} f_{{22}}\\, l \\lambda / r}} .
$$

{table}
The case has a wheelset without a spin inertia worth the name. With that of a real one its gyroscopic moment, which the textbook
leaves out, holds it straight. No complete data of a suspended wheelset or of a two-axle vehicle together with a published
critical speed were found; the numbers of this wheelset are ours.
"""


def wheelset() -> str:
    full = list(effects(Bogie(), rail_radius=RAIL_RADIUS, spin_inertia=0.0, weight=0.0).values())[2]
    real = case("suspended_wheelset").with_changes({"vehicle.body.wheelset_1.inertia": [700.0, 80.0, 700.0]})
    spinning = scan_linear(real, SPEEDS).onset
    assert spinning is not None
    rows = {
        "closed form": wheelset_formula(),
        "closed form with a wheelset that rolls": wheelset_formula(full.conicity, full.lateral_ratio),
        "this program": critical("suspended_wheelset")[0],
        "this program, 80 kg m² about the axle": spinning.speed,
    }
    return WHEELSET.format(table=table(["critical speed", "m/s"], [[name, f"{v:.2f}"] for name, v in rows.items()]))


SECTIONS = (overview, cooperrider, wheelset)


def main() -> None:
    """Write the page."""
    sections = [section() for section in SECTIONS]
    PAGE.write_text("\n".join([INTRODUCTION, *sections]), encoding="utf-8")


if __name__ == "__main__":
    main()
