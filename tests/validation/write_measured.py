"""Write docs/measured.md: the program beside measurements.

    python tests/validation/write_measured.py [--shared FOLDER]

Without the folder of third-party files the section of single measured points stays as it is on the page.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1])]

from validation import locomotive_adhesion as locomotive  # noqa: E402
from validation import sanding_trial  # noqa: E402
from validation.locomotive_adhesion import Array, ParameterSet, bins, bogie, rms, sets, within  # noqa: E402

PAGE = Path(__file__).parents[2] / "docs" / "measured.md"
FITTED = {law: len(names) for law, names in locomotive.FREE.items()}

INTRODUCTION = """# Held against measurements

What was measured on vehicles, what the program gives, and the error. Each row says how many of its numbers were fitted to
that very measurement; all others are predictions. Rows that do not agree are kept. This page is written by
`python tests/validation/write_measured.py`, and a test compares it with the program. Comparisons with other programs and
closed forms: {doc}`checks`, {doc}`validation`.
"""

ADHESION = """## A locomotive's adhesion

Siemens Eurosprinter 127 001, 36 km/h, straight track, 106.7 kN a wheel, wheels of 625 mm, a/b of the patches about 0.5
(J. Engel, H.-P. Beck, J. Alders, *Verschleißreduzierende Radschlupfregelung mit hoher Kraftschlussausnutzung*,
Elektrische Bahnen 96 (1998) 201–209). 158 points were read off a published figure; their 13 means over ranges of
creepage, with standard errors, are in `tests/validation/data/eurosprinter_bins.csv`. Traction coefficient: force along
the rail over vertical force.

![Measured traction coefficient of a locomotive with all creep laws](images/measured_adhesion.svg)

To see the bogie of a locomotive run through this curve, `rollerrig run eurosprinter_traction`; in a copy of the
repository `python examples/14_measured_adhesion.py` prints it beside the means. The condition is
`adhesion.rail = "eurosprinter"`.
"""

LAWS = """### Each law on one wheel

Hertz' ellipse with a/b = 0.5 under 106.7 kN. *Published* parameters are as their authors give them, who chose the last
two of them for this locomotive; *fitted* ones minimise the deviations from the 13 means, each over its standard error.

{table}
**`dry` and `wet` are for other purposes.** They are Polach's recommended values for typical rails, to design with between
them: at 3 % of creepage a wheel pulls {dry:.2f} of its load on `dry` and {wet:.2f} on `wet`, where {measured:.2f} was
measured. `eurosprinter` lies between. It is the dry rail with less friction: with μ₀ = 0.357 and all else as in `dry`,
{scaled} of 13 means are within 3 standard errors, r.m.s. {scaled_rms:.4f}.

**Laws that do not agree.** `table`, `fastsim` and the paper's law reach {few[0]}, {few[1]} and {few[2]} of 13 means
however they are fitted: the rail's condition leaves them one constant part of the stiffness, (A4). Their force peaks near
1.3 % of creepage, where the measured one still rises to 2.9 %; it is up to 0.02 too large from 0.7 to 1.5 % and 0.02 too
small at 0.5 %. Polach's $k_S$ and the softening of the modified FASTSIM describe the slow rise. A wheel-slip control that
seeks the peak should not be tuned with the other laws. `strip_theory` is the table on a flat ellipse; `kalker_linear` has
no limit of friction.

**What the means do not determine.** Up to the 1.9 m/s of slip that were measured, A cannot be separated from B (a fit of both
ends at A = 0), nor k_A from k_S: A = 0.40 and, in Polach's law, k_A = 1 are held at those of the dry rail. The means at
4.6 and 6.0 % rise again ({again[0]:.3f}, {again[1]:.3f}); no law with falling friction does (`eurosprinter`:
{falls[0]:.3f}, {falls[1]:.3f}).

**How far the fit predicts.** Polach's law fitted to twelve means gives the thirteenth with an r.m.s. error of
{left_rms:.4f}, {left_most:.3f} at most.
"""

BOGIE = """### A locomotive's bogie

`eurosprinter_traction`: torque rises until both axles have slipped through the whole curve, at 36 km/h on S1002 and UIC60
1:40 (a/b at rest 0.55), wheels and load as measured; bogie and suspension are another locomotive's. Nothing is fitted to
the bogie: the rail is `eurosprinter`, fitted on one wheel above. Mean of the two axles, each where it first has this
creepage. On the rig (rollers of 725 mm, dry) it is the axles of the virtual train, whose rail the controller reproduces.

{table}
r.m.s. {track_rms:.4f} on track, {rig_rms:.4f} on the rig; {track} and {rig} of 13 means are within 3 standard errors.

**Load transfer.** The leading axle is unloaded by the pull, and slips first. Its coefficient is right only over the load
of the instant; over the load at rest it is not:

{loads}
The car body is fixed: what its own pitch moves between the bogies is not in these numbers. How the measurement counted
the load is not known; 106.7 kN is taken for all points.
"""

SAND = """## Sand on very low adhesion

A trial of RSSB with trains of class 387 (project T1107, reported by Rail Engineer, 12 February 2018): from 55 mph, 0.9 m/s²
demanded, untreated friction 0.02, sand throughout the stop. On dry rail the same case stops with 0.9 m/s² on average.

{table}
Without sand nothing is fitted: the friction is the trial's. One number is calibrated on one sander of fixed rate,
`saturation`, 3.5 g/m; it predicts the second sander of fixed rate within 15 %. The rate of the variable sanders was not at
hand: the `flow` of the fourth row is fitted to its distance (5.1 kg/min beside 2 kg/min), and predicts two of them within 15 %.

**These rows say less than those above.** The friction of 0.02 is as reported, one value for a treated rail. The sixteen axles
of the train have the order of the trial's, not its distances: the two with sanders stand as those of a bogie.
The report names axle 3 for the first sander. That the second one is at axle 7, the rate of 2 kg/min, `kept` (0.7) and the
friction of a sanded rail (0.25) are assumptions. With `kept` 0.55 or 0.84, and `saturation` calibrated anew
(1.73, 6.71 g/m), two sanders of fixed rate need 572 or 597 m. `flow` is one number: a rate that rises with the speed
cannot be given. Two sanders do more than measured at the fixed rate and less at the variable one; the one curve of
saturation (A19) cannot do both.

`rollerrig run sanding_trial` is one sander of fixed rate, with `sanding.axles = ["wheelset_1", "wheelset_2"]` it is two.
`python tests/validation/sanding_trial.py` computes all five stops.
"""

POINTS = """### Against the single points

r.m.s. of the traction coefficient over all {count} points. About their own 13 means they have {inside:.4f} ({scatter:.4f}
as a scatter with 13 means taken from {count} points): no smooth curve is much nearer.

{table}"""


def table(header: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(row)} |" for row in (header, *body)]
    return "\n".join([lines[0], "|---" * len(header) + "|", *lines[1:]]) + "\n"


def source(one: ParameterSet) -> str:
    """Who published a set, and its name as a condition of a rail."""
    condition = f"condition `{one.condition}`" if one.condition else ""
    return "; ".join(filter(None, (one.origin, condition))) or "–"


def span(values: Array) -> str:
    return f"{values.min():.3f} to {values.max():.3f}"


def overview() -> str:
    """What was measured, and how near the bogie is."""
    measured, here = bins(), bogie(bins().creepage)
    top, fitted = measured.mean.max(), "3 of 5: μ₀, B, k_S, to these means on a single wheel"
    peak = [
        "largest traction coefficient",
        f"{top:.3f}",
        f"{here.max():.3f}",
        f"{100 * (here.max() / top - 1):+.1f} %",
        fitted,
    ]
    error = f"r.m.s. {rms(here - measured.mean):.4f}"
    body = [peak, ["13 means from 0.5 to 19 % of creepage", span(measured.mean), span(here), error, "the same"]]
    for one in (s for s in sets() if not s.fitted):
        curve = one.curve(measured.creepage)
        error = f"r.m.s. {rms(curve - measured.mean):.4f}"
        body.append([f"the same, one wheel, `{one.law}`: {source(one)}", "the same", span(curve), error, "none here"])
    rows = table(["traction coefficient of a locomotive", "measured", "here", "error", "fitted"], body)
    return f"## Overview\n\n{rows}\n{stops()}"


def stops() -> str:
    """Stopping distances with sand, as they were computed last."""
    body, here = [], sanding_trial.recorded()
    for stop in sanding_trial.STOPS:
        way, measured = here[stop.name], f"{stop.measured:.0f} m"
        error = f"{100 * (way / stop.measured - 1):+.0f} %"
        if stop.at_least:
            measured, error = f"more than {measured}", "in agreement" if way > stop.measured else error
        body.append([stop.name, measured, f"{way:.0f} m", error, stop.fitted or "none to this row"])
    return table(["stop from 55 mph on a friction of 0.02", "measured", "here", "error", "fitted"], body)


def row_of(one: ParameterSet) -> list[str]:
    """How near one law is to the means."""
    curve, fine = one.curve(bins().creepage), np.geomspace(1e-3, 0.25, 400)
    whole, error = one.curve(fine), curve - bins().mean
    return [
        f"`{one.law}`",
        source(one),
        ", ".join(f"{name} {value:g}" for name, value in one.numbers.items()),
        f"{FITTED[one.law]}" if one.fitted else "none",
        f"{whole.max():.3f} at {100 * fine[whole.argmax()]:.1f} %",
        f"{within(curve)} of 13",
        f"{rms(error):.4f}",
        f"{np.abs(error).max():.3f}",
    ]


def laws() -> str:
    """Creep laws on one wheel."""
    header = ["law", "published by, or name", "numbers (B in s/m)", "fitted", "peak", "within 3 standard errors", "r.m.s. error",
              "largest error"]  # fmt: skip
    fits = {one.law: one for one in sets() if one.fitted}
    dry, wet = (next(one for one in sets() if one.condition == name) for name in ("dry", "wet"))
    scaled = ParameterSet("polach", True, {**dry.numbers, "mu_0": 0.357}).curve(bins().creepage)
    three, left = np.array([0.03]), locomotive.left_out("polach")
    return LAWS.format(
        table=table(header, [row_of(one) for one in sets()]),
        dry=dry.curve(three)[0],
        wet=wet.curve(three)[0],
        measured=np.interp(0.03, bins().creepage, bins().mean),
        scaled=within(scaled),
        scaled_rms=rms(scaled - bins().mean),
        few=[within(fits[law].curve(bins().creepage)) for law in ("table", "fastsim", "kalker_saturated")],
        again=bins().mean[8:10],
        falls=fits["polach"].curve(bins().creepage[8:10]),
        left_rms=rms(left),
        left_most=np.abs(left).max(),
    )


def on_bogie() -> str:
    """The bogie of a locomotive on track and on the rig."""
    measured, track, rig = bins(), bogie(bins().creepage), bogie(bins().creepage, on_rig=True)
    columns = zip(measured.creepage, measured.mean, measured.error, track, rig, strict=True)
    body = [
        [f"{100 * x:.1f}", f"{y:.4f} ± {e:.4f}", f"{a:.4f}", f"{a - y:+.4f}", f"{b:.4f}", f"{b - y:+.4f}"]
        for x, y, e, a, b in columns
    ]
    run = locomotive.traction()
    static, loads = float(run["load"].isel(time=0).mean()), []
    for axle in map(str, run["axle"].to_numpy()):
        own = run.sel(axle=axle)
        carried = float(own["load"][int(np.argmax(own["traction_coefficient"].to_numpy()))]) / static - 1
        errors = [rms(locomotive.at(run, axle, measured.creepage, load) - measured.mean) for load in (None, static)]
        loads.append([axle.replace("_", " "), f"{100 * carried:+.1f} %", *(f"{error:.4f}" for error in errors)])
    columns_of_loads = ["axle", "load at its peak, from that at rest", "r.m.s. error, load of the instant",
                        "r.m.s. error, load at rest"]  # fmt: skip
    return BOGIE.format(
        table=table(["creepage %", "measured", "on track", "error", "on the rig", "error"], body),
        track_rms=rms(track - measured.mean),
        rig_rms=rms(rig - measured.mean),
        track=within(track),
        rig=within(rig),
        loads=table(columns_of_loads, loads),
    )


def points(shared: Path) -> str:
    """Laws and bogie against the single points, which are a third party's."""
    creepage, measured = locomotive.points(shared)
    body = []
    for one in sets():
        error = rms(one.curve(creepage) - measured)
        body.append([f"`{one.law}`", "fitted to the means" if one.fitted else source(one), f"{error:.4f}"])
    for name, on_rig in (("on track", False), ("on the rig", True)):
        body.append(["bogie", f"`eurosprinter`, {name}", f"{rms(bogie(creepage, on_rig) - measured):.4f}"])
    parts = [measured[(creepage >= low) & (creepage < high)] for low, high in zip(bins().low, bins().high, strict=True)]
    inside = np.concatenate([part - part.mean() for part in parts])
    scatter = float(np.sqrt(np.sum(inside**2) / (len(inside) - len(parts))))
    return POINTS.format(
        count=len(inside), inside=rms(inside), scatter=scatter, table=table(["law", "parameters", "r.m.s. error"], body)
    )


def sand() -> str:
    """Stopping distances of a trial with sand."""
    return SAND.format(table=stops())


SECTIONS = (overview, laws, on_bogie, sand)
"""Those that need nothing but the repository."""


def section(text: str, title: str) -> str:
    """A section of the page, from its title to the next one of its level or above."""
    _, found, rest = text.partition(f"{title}\n")
    assert found, title
    level = title.split(" ")[0]
    kept: list[str] = []
    for line in rest.splitlines(keepends=True):
        if line.startswith("#") and len(line.split(" ")[0]) <= len(level):
            break
        kept.append(line)
    return f"{title}\n" + "".join(kept)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, help="folder of third-party files")
    shared = parser.parse_args().shared
    title = POINTS.splitlines()[0]
    single = points(shared) if shared else section(PAGE.read_text(encoding="utf-8"), title).rstrip() + "\n"
    PAGE.write_text(
        "\n".join([INTRODUCTION, overview(), ADHESION, laws(), on_bogie(), single, sand()]), encoding="utf-8"
    )


if __name__ == "__main__":
    main()
