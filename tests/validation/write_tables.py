"""Writes docs/validation.md: every number on that page comes from here.

python tests/validation/write_tables.py
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests")]

from rollerrig import _core  # noqa: E402
from rollerrig.assembly.model_parts import static_loads  # noqa: E402
from rollerrig.config import load_vehicle  # noqa: E402
from validation import half_space_pairs as pairs  # noqa: E402
from validation import test_adhesion_slip as traction_checks  # noqa: E402
from validation import test_bogie as bogie_checks  # noqa: E402
from validation import test_contact_results as contact_checks  # noqa: E402
from validation import test_creep_laws as creep_checks  # noqa: E402
from validation import test_kinematics as kinematics  # noqa: E402
from validation import test_patch_creep as patch_creep_checks  # noqa: E402
from validation import test_pose_statistics as pose_checks  # noqa: E402
from validation import test_rigid_touch as touch  # noqa: E402
from validation import test_suspended_vehicle as suspended  # noqa: E402
from validation.comparison import FILES, Comparison, comparisons  # noqa: E402
from validation.reference import benchmark_contact, kmh, mm, rows  # noqa: E402

INTRODUCTION = """# Validation

What the simulator is compared with, and how far apart the two are. This page is written by
`python tests/validation/write_tables.py`; the tests in `tests/validation` and `tests/core` assert the same comparisons with
tolerances that carry their reasons.

References, all in `tests/validation/data` with their origin: CONTACT (Vollebregt, Kalker: exact half-space theory),
independent codes for rigid contact points and Hertz ellipses. Besides these: a bogie model written separately in NumPy
(`tests/validation/independent_model`), and closed forms.
"""


POSE_STATISTICS = """## Strips over all poses of the references

Largest approach and pressure, centre of the pressures, length along rolling and width across it, each pose at the force of the
reference. Lengths in units of what is asked for: 8 % or 0.3 mm, whichever is more. The half-space is our own solution
(`tests/validation/half_space.py`) on a grid fine enough for each patch, in CONTACT's poses, with yaw of 10 to 50 mrad on rail and
rollers of 500 and 1000 mm with longitudinal offsets of 0 to 20 mm, and under 50 and 100 kN. It agrees with CONTACT within 0.1 %
in approach (median) and, on rail, in pressure; on the roller CONTACT's pressures scatter by up to 12 % from shift to shift.

"""


PAIR_STATISTICS = """## Normal contact in random poses of new and worn pairs

Strips and Hertz at given heights against the exact half-space, which finds the patches itself
(`tests/validation/free_patches.py`): S1002 on UIC60 1:40, on 60E1 1:20 and 1:40, hollow by 3 mm on 60E1 1:40, and on a worn 60E1
1:40; rail and rollers of 300 and 725 mm, half of the wheels on rollers with a longitudinal offset of up to 4 mm; 5 to 150 kN, yaw
up to 50 mrad. `transition`: between tread and flange, poses in which an earlier contact of strips was most wrong. Sum of the
patches' forces, largest pressure, largest distance of a patch's centre, whole area, largest approach: median / 95 % / worst, in %
and, of the centre, mm. Asked for of the strips' centre were 0.2 mm in 95 % of all poses and 0.4 mm in the worst, which it misses
narrowly; bars for it are at 0.24 and 0.45 mm.

In 20 000 other poses, 5 to 800 µm below their first touch, up to 2 MN (`HALF_SPACE_POSES=20000 pytest
tests/validation/test_half_space_pairs.py --long -s -k exact_one`), the force of the strips is off by 0.2 % in the median, by
1.4 % at 95 % and 4.7 to 8.2 % at 99.9 %; by 21 % in one pose (a roller of 300 mm, flange root, 387 for 321 kN: three contacts
of the strips are one in one plane there), by 9.3 % at most in the others. Left out is one pose of 800, in which the reference
says nothing: where regions from tread to flange become one, it has one plane for them, and where a hollow tread closes around
the rail it loses patches.

"""


TRACTION = """## Traction over slip

The bogie of `electric_locomotive` on 3-D track and on the rig, no anti-slip, the torque rising slowly until the wheels run away:
force over load of the axles at slips of 0.1 to 30 %, against Polach's closed form with his parameters of a locomotive on wet and
dry rail (*Wear* 258, 2005; from memory). The closed form knows of the run the patch at rest, the loads and the slip; on the rig
force and slip are the virtual axles', which the wheels follow. With anti-slip, wheels on wet rail stay on the curve at 2 to 5 %.

"""


PATCH_CREEP = """## Creep forces on patches that are no ellipses

The law `table` on the strips' equivalent ellipse. Error of the tangential force in % of μN, of the moment in % of μN√(area/π).
CONTACT: its own forces in all its poses, at its creepages. Exact theory: our exact solver on rows along rolling with the lengths
and loads of the half-space's pressures, which repeats CONTACT's forces within 2 % of μN (1 % outside the wide patch, the error of
its grid of 0.2 mm): a wheel on rail and on a roller of 500 mm, shift -5 to 4.5 mm, 10, 50 and 100 kN, eight directions and three
sizes of creepage, spin as the contact angle gives it. Where the patch has two lobes of different height, or a long shelf, one
ellipse is an approximation: neither other moments for its ratio of axes nor a creepage taken nearer to the centre of the area
brings the worst case below 8 %; one ellipse per lobe would, at the price of two or three patches in the most
frequent position of a wheel.

"""


def table(header: list[str], body: list[list[str]]) -> str:
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in body]) + "\n"


def rigid_touch() -> str:
    contacts = {"rail": benchmark_contact(None), "roller": benchmark_contact(0.5)}
    found = [touch.compare(contacts[row["cfg"]], row) for row in rows("rigid_touch.csv")]
    body = []
    for support in ("rail", "roller"):
        for flange in (False, True):
            part = [d for d in found if d.row["cfg"] == support and d.flange == flange]
            position = [max(abs(d.s), abs(d.x), abs(d.y), abs(d.z)) for d in part]
            height = [abs(d.height) for d in part]
            body.append(
                [support, "flange" if flange else "tread", str(len(part)), f"{np.median(position):.5f}",
                 f"{max(position):.4f}", f"{max(height):.1e}"]
            )  # fmt: skip
    second = [d for d in found if not np.isnan(d.row["gap2"])]
    return (
        "## Where rigid profiles touch\n\n"
        "S1002 on UIC60 1:40, rail and roller of 500 mm radius; shift -8 to 8 mm, yaw 0 to 50 mrad, longitudinal offset 0 "
        "to 20 mm. Largest difference of any coordinate of the contact point, and of the height of the wheelset, in mm.\n\n"
        + table(["support", "contact on the", "poses", "position, median", "position, worst", "height, worst"], body)
        + f"\nAll {len(second)} second contacts of the reference are found; their heights differ by at most "
        f"{max(abs(d.second_height) for d in second):.1e} mm.\n"
    )


def contact_rows(results: list[Comparison]) -> list[list[str]]:
    body = []
    for c in results:
        r = c.reference
        creep = "" if np.isnan(c.creep_error) else f"{100 * c.creep_error:.1f}"
        body.append(
            [r["side"], f"{r['y_ws']:g}", f"{len(c.patches)}", f"{np.degrees(c.angle):.1f}", f"{r['Fn'] / 1e3:.2f}",
             f"{1e3 * r['approach']:.1f}", f"{100 * c.ratio('approach', 'approach'):+.1f}",
             f"{100 * c.ratio('area', 'patch_area'):+.0f}", f"{100 * c.ratio('pressure', 'pmax'):+.1f}",
             f"{c.abscissa - c.reference_abscissa:+.2f}", f"{1e3 * (c.height - r['z_ws']):+.1f}", creep]
        )  # fmt: skip
    return body


def elastic_contact() -> str:
    results = {file: comparisons(file) for file in FILES}
    ellipses = [c for part in results.values() for c in part if contact_checks.is_elliptic(c)]
    approach = [100 * abs(c.ratio("approach", "approach")) for c in ellipses]
    tread = max(100 * c.creep_error for c in ellipses if c.angle < 0.2)
    flange = max(100 * c.creep_error for c in ellipses if c.angle >= 0.2)
    text = (
        "## Hertz and the paper's creep law against CONTACT\n\n"
        "Each wheel carries the normal force that CONTACT found. `patches`: how many the paper's method keeps (CONTACT always "
        "finds one). Approach (largest), area and peak pressure are differences to CONTACT; its areas count grid cells of "
        "0.2 mm and are high by half a rim, 2 to 8 %. Position: centre of the patches on the wheel, weighted with force; "
        "height: of the wheelset under load. Creep: error of the tangential force at CONTACT's creepages, in % of the "
        "friction limit, where there is one patch.\n\n"
        f"Where the patch is an ellipse the two agree: in the approach {np.median(approach):.1f} % (median), "
        f"{max(approach):.1f} % (worst). They do not where the profiles conform: within "
        "1 mm of the centred position, where CONTACT sees one patch 14 to 16 mm wide and the paper's method two Hertz "
        "patches, then one that is too long or too short; and in the flange root at 5 mm. The tangential force is at most "
        f"{tread:.0f} % of the friction limit off on the tread and {flange:.0f} % on the flange, where spin is large: the "
        "paper's law takes spin as linear up to the limit.\n"
    )
    header = ["side", "shift mm", "patches", "angle deg", "N kN", "approach um", "approach %", "area %", "pressure %",
              "position mm", "height um", "creep %"]  # fmt: skip
    for file, title in FILES.items():
        text += f"\n### {title[0].upper() + title[1:]}\n\n" + table(header, contact_rows(results[file]))
    return text


def strips() -> str:
    results = {file: comparisons(file, "strips") for file in FILES}
    everything = [c for part in results.values() for c in part]
    worst = {
        "centre": max(abs(c.centre - c.pressure_centre) for c in everything),
        **{
            name: max(100 * abs(c.ratio(ours, theirs)) for c in everything)
            for name, ours, theirs in (("approach", "approach", "approach"), ("pressure", "pressure", "pmax"))
        },
        "width": max(abs(c.width - c.reference["patch_len_s"]) for c in everything),
    }
    text = (
        "## Strips against CONTACT\n\n"
        '`contact.normal = "strips"` ({doc}`theory/non_elliptic_contact`) at the same poses and loads, wide patches and the '
        "flange root included. Centre: of the pressures, difference across the track; CONTACT's own contact reference point is "
        "weighted with the interpenetration and lies up to 1.8 mm from it. Widths count grid cells of 0.2 mm in CONTACT. "
        f"Largest differences of all {len(everything)} poses: centre {worst['centre']:.2f} mm, approach "
        f"{worst['approach']:.1f} %, peak pressure {worst['pressure']:.0f} %, width {worst['width']:.2f} mm. On the roller "
        "CONTACT's pressures scatter by some percent from shift to shift.\n\n"
        "A closed path of the wheel, 1 mm wide and 0.1 mm high around the wide patch of the middle, gains or loses "
        f"{100 * strip_loop():.2f} % of the largest elastic energy on it.\n"
    )
    header = ["side", "shift mm", "patches", "approach um", "approach %", "pressure MPa", "pressure %", "width mm", "CONTACT mm",
              "area %", "centre mm"]  # fmt: skip
    for file, title in FILES.items():
        body = [
            [str(c.reference["side"]), f"{c.reference['y_ws']:g}", f"{sum(p.weight for p in c.patches):.3g}",
             f"{1e3 * c.reference['approach']:.1f}", f"{100 * c.ratio('approach', 'approach'):+.1f}",
             f"{c.reference['pmax']:.0f}", f"{100 * c.ratio('pressure', 'pmax'):+.1f}", f"{c.width:.2f}",
             f"{c.reference['patch_len_s']:.1f}", f"{100 * c.ratio('area', 'patch_area'):+.0f}",
             f"{c.centre - c.pressure_centre:+.2f}"]
            for c in results[file]
        ]  # fmt: skip
        text += f"\n### Strips: {title}\n\n" + table(header, body)
    return text


def pose_statistics() -> str:
    """Distribution of the strips' errors over all poses of the references."""
    body = []
    for name, errors in (("CONTACT", pose_checks.contact_errors()), ("half-space", pose_checks.half_space_errors())):
        for quantity, error in zip(pose_checks.TARGET, errors.T, strict=True):
            percent = quantity in ("approach", "pressure")
            unit, factor = ("%", 100.0) if percent else ("mm", 1.0) if quantity == "centre" else ("-", 1.0)
            sizes = [factor * x for x in (np.median(error), percentile_95(error), error.max())]
            within = 100 * np.mean(error <= pose_checks.TARGET[quantity])
            target = f"{factor * pose_checks.TARGET[quantity]:g}"
            body.append(
                [name, str(len(error)), quantity, unit, *(f"{size:.2f}" for size in sizes), target, f"{within:.1f}"]
            )
    header = [
        "reference",
        "poses",
        "error of",
        "unit",
        "median",
        "95 %",
        "worst",
        "asked for",
        "within, % of the poses",
    ]
    return POSE_STATISTICS + table(header, body)


def pair_statistics() -> str:
    """Distribution of the laws' errors in random poses, by category."""
    body = []
    for law, category in itertools.product(("strips", "hertz"), ("all", *pairs.CATEGORIES)):
        poses = [row for row in pairs.read() if category in ("all", row[0].category)]
        found = np.array([pairs.errors(*row, law) for row in poses])
        factors = [1.0 if quantity == "centre" else 100.0 for quantity in pairs.ERRORS]
        sizes = np.quantile(found, (0.5, 0.95, 1.0), axis=0).T * np.array(factors)[:, None]
        body.append([law, category, str(len(found)), *(" / ".join(f"{size:.2f}" for size in three) for three in sizes)])
    return PAIR_STATISTICS + table(["law", "contact", "poses", *pairs.ERRORS], body)


def strip_loop() -> float:
    """Work of the strips' pressures around a closed path of shift and height, over the largest elastic energy on it."""
    contact = benchmark_contact(None, "strips")
    corners = [(-0.5 * mm, -0.20 * mm), (0.5 * mm, -0.20 * mm), (0.5 * mm, -0.30 * mm), (-0.5 * mm, -0.30 * mm)]
    work = [0.0]
    for (y0, z0), (y1, z1) in zip(corners, [*corners[1:], corners[0]], strict=True):
        for i in range(400):
            part = (i + 0.5) / 400
            patches = contact.patches(0.0, y0 + part * (y1 - y0), z0 + part * (z1 - z0), 0.0, 0.0, False)
            force = sum(p.normal * np.array(p.direction) for p in patches)
            work.append(work[-1] + float(force[1] * (y1 - y0) + force[2] * (z1 - z0)) / 400)
    return abs(work[-1]) / (max(work) - min(work))


def creep_laws(laws: tuple[str, ...] = (creep_checks.EXACT, *creep_checks.LAWS)) -> str:
    body = []
    for law in laws:
        force, moment, spin = creep_checks.errors(law)
        for label, chosen in (("none", ~spin), ("with", spin)):
            spread = [100 * f(x[chosen]) for x in (force, moment) for f in (np.median, percentile_95, np.max)]
            body.append([law, label, *(f"{x:.1f}" for x in spread)])
    coefficients = []
    for row in rows("kalker_full_solution.csv"):
        if row["nu"] == 0.28:
            ours = creep_checks.linear_limit(_core.RollingReference(row["a_over_b"], row["nu"], 1.0))
            names = ("C11", "C22", "C23", "C33")
            off = [100 * (value / row[f"{name}_contact"] - 1) for name, value in zip(names, ours, strict=True)]
            coefficients.append([f"{row['a_over_b']:.3g}", *(f"{x:+.1f}" for x in off)])
    return (
        "## Creep laws against CONTACT\n\n"
        "a/b 0.5, 1 and 2, eight directions of creepage, eleven sizes from stick to full sliding; ν = 0.28. Error of the "
        "tangential force in % of the friction limit μN, and of the spin moment in % of μN√(ab). CONTACT's own error is at most "
        "0.6 %. `exact solver`: ours, with which the law `table` is made. Polach with k_A = k_S = 1 (clean); its moment is not "
        "Polach's ({doc}`theory/creep_laws`). The paper's law leaves the moment unsaturated, as published.\n\n"
        + table(["law", "spin", *(f"{what}, {which}" for what in ("force", "moment") for which in ("median", "95 %", "worst"))],
                body)
        + "\nLinear limit of our exact solver against CONTACT's, in %; CONTACT's values carry standard errors of up to 3 % at "
        "a/b = 10, and C33 of long patches asks for a finer grid than the solver's usual one.\n\n"
        + table(["a/b", "C11", "C22", "C23", "C33"], coefficients)
    )  # fmt: skip


def patch_creep() -> str:
    """Distribution of the errors of creep forces on patches that are no ellipses."""
    contact = patch_creep_checks.contact_errors()
    tread = contact[:, 2] > 0
    groups = {"CONTACT, tread": contact[tread], "CONTACT, flange": contact[~tread]}
    table_rows, exact = patch_creep_checks.exact_errors()
    shift, force = (np.array([row[name] for row in table_rows]) for name in ("y", "force"))
    wide = (shift >= -0.5) & (shift <= 1.5)
    groups["exact theory, shift -0.5 to 1.5 mm, 10 kN"] = exact[wide & (force < 2e4)]
    groups["exact theory, shift -0.5 to 1.5 mm, 50 and 100 kN"] = exact[wide & (force > 2e4)]
    groups["exact theory, other shifts"] = exact[~wide]
    groups["exact theory, all"] = exact
    body = [
        [name, str(len(error))]
        + [f"{100 * f(error[:, k]):.1f}" for k in (0, 1) for f in (np.median, percentile_95, np.max)]
        for name, error in groups.items()
    ]
    header = ["reference", "cases", "force, median", "force, 95 %", "force, worst", "moment, median", "moment, 95 %",
              "moment, worst"]  # fmt: skip
    return PATCH_CREEP + table(header, body)


def percentile_95(values: np.ndarray) -> float:
    return float(np.percentile(values, 95))


def limits() -> str:
    speed = 100 * kmh
    track = bogie_checks.eigenvalues("uic60_track", speed)
    body = []
    for radius in (10.0, 100.0, 1e3, 1e4):
        rig = bogie_checks.eigenvalues("full_scale_rig", speed, support__roller_radius=f"{radius} m")
        body.append([f"{radius:g}", f"{bogie_checks.largest_relative_difference(track, rig):.2e}"])
    return (
        "## Rollers grow into a track\n\n"
        "Eigenvalues of the bogie at 100 km/h on rollers of growing radius against those on straight track: largest relative "
        "difference of any of the 50 eigenvalues. Rail and roller are the same code; the difference falls as 1/R.\n\n"
        + table(["roller radius m", "difference"], body)
    )


def slow_rolling() -> str:
    body = []
    for conicity in (1 / 20, 1 / 40, 1 / 100):
        length, radius, half = kinematics.wavelength(kinematics.lone_wheelset(conicity))
        expected = kinematics.klingel(radius, half, conicity)
        name = f"wheelset, cone 1:{1 / conicity:.0f}"
        body.append([name, f"{length:.3f}", f"{expected:.3f}", f"{100 * (length / expected - 1):+.2f}"])
    for nu, label in ((0.0, "nu = 0 (C11 = C22)"), (0.28, "steel")):
        length, radius, half = kinematics.wavelength(kinematics.rigid_bogie(1 / 40, nu))
        expected = kinematics.klingel(radius, half, 1 / 40) * float(np.sqrt(1 + (1.28 / half) ** 2))
        body.append([f"rigid bogie, cone 1:40, {label}", f"{length:.3f}", f"{expected:.3f}",
                     f"{100 * (length / expected - 1):+.2f}"])  # fmt: skip
    return (
        "## Slow rolling\n\n"
        "Wavelength of the weave at 2 m/s, from the eigenvalues, against Klingel's formula and its form for a rigid bogie, "
        "L sqrt(1 + (lw/l0)^2). That form holds for equal longitudinal and lateral creep coefficients; with steel C22 < C11, "
        "and the bogie's wave is shorter by what their ratio says.\n\n"
        + table(["model", "computed m", "formula m", "difference %"], body)
    )


def suspension() -> str:
    names = list(suspended.HAND_CALCULATION)
    body = [["by hand", *(f"{suspended.HAND_CALCULATION[name][0]:g}" for name in names)]]
    for springs in suspended.SPRINGS:
        found = suspended.modes(springs)
        body.append([springs, *(f"{suspended.nearest(found, name):.3f}" for name in names)])
    _, axles = static_loads(load_vehicle(suspended.VEHICLE), 9.81)
    loads = sorted({f"{load / 2e3:.2f}" for load in axles.values()})
    clamped = suspended.modes(next(iter(suspended.SPRINGS)))
    pendulum, whole = suspended.sways(1.130, "pendulum"), suspended.sways(0.8275, "clamped")
    off = {name: suspended.nearest(clamped, name) / suspended.HAND_CALCULATION[name][0] - 1 for name in names}
    return (
        "## The suspended vehicle\n\n"
        f"Manchester vehicle 1. Static wheel load: {' and '.join(loads)} kN, published 54.55 kN. Natural frequencies in Hz, "
        "dampers off and wheelsets held, from the linearisation with all preloads; a test finds the same from the second "
        "derivative of the elastic energy. No published or measured eigenvalues of this vehicle are known; the first row is a "
        "hand calculation of this project. The other rows differ in what a secondary spring is taken for.\n\n"
        + table(["secondary springs", *names], body)
        + "\nBounce, pitch, yaw and the modes of the bogie depend little on it and agree with the hand calculation, to "
        f"{max(abs(100 * off[name]) for name in names if 'sway' not in name):.1f} %. The sways depend on which seat of a loaded "
        "spring takes its moment. The catalogue's springs are clamped at both ends, as coil springs on flat seats are "
        "({doc}`theory/bodies_and_elements`, B11); with them the lower sway is "
        f"{abs(100 * off['lower sway']):.0f} % lower and the upper one {100 * off['upper sway']:.0f} % higher than by hand. The "
        "hand calculation leaves that moment out: it lets the shear act at the springs' tops and counts the load as a pendulum "
        "term on roll alone. A closed form of these two simplifications, y and roll of car body and frames, gives "
        f"{pendulum[0]:.3f} and {pendulum[1]:.3f} Hz, and with the whole moment {whole[0]:.3f} and {whole[1]:.3f} Hz, ours; so "
        "the difference lies in the hand calculation.\n"
    )


def energy() -> str:
    body = []
    for support, speed, lateral in (
        ("full_scale_rig", 150.0, 3.0),
        ("full_scale_rig", 150.0, 6.5),
        ("uic60_track", 150.0, 3.0),
        ("full_scale_rig", 0.0, 3.0),
    ):
        turned_over, share = bogie_checks.energy_share(support, speed * kmh, lateral * mm)
        body.append([support, f"{speed:g}", f"{lateral:g}", f"{turned_over:.0f}", f"{share:.0e}"])
    return (
        "## Energy\n\n"
        "Work put in less what is stored and what turned into heat, over 0.5 s after a release beside the middle, relative "
        "tolerance 1e-8. Every run reports this residual.\n\n"
        + table(["support", "km/h", "offset mm", "energy turned over J", "residual / turned over"], body)
    )


def traction() -> str:
    body = []
    for rail, speed, on_rig in itertools.product(traction_checks.RAILS, traction_checks.SPEEDS, (False, True)):
        curve = traction_checks.measured(rail, speed, on_rig)
        top, published = curve.peaks
        place = "rig" if on_rig else "track"
        error = 100.0 * curve.largest_error
        body.append([rail, f"{speed}", place, f"{top:.3f}", f"{published:.3f}", f"{error:.1f}"])
    heading = ["rail", "km/h", "on", "peak", "peak, Polach", "largest error % of the peak"]
    return TRACTION + table(heading, body)


SECTIONS = (
    rigid_touch,
    elastic_contact,
    strips,
    pose_statistics,
    pair_statistics,
    creep_laws,
    patch_creep,
    limits,
    slow_rolling,
    suspension,
    traction,
    energy,
)
PAGE = ROOT / "docs" / "validation.md"


def main() -> None:
    PAGE.write_text("\n".join([INTRODUCTION, *(section() for section in SECTIONS)]), encoding="utf-8")


if __name__ == "__main__":
    main()
