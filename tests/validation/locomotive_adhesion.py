"""Adhesion of a Siemens Eurosprinter, measured, beside the creep laws of the program and beside a locomotive's bogie on track.

13 means -> [fit] -> parameters of each law -> [rms, within] -> how near it is
case eurosprinter_traction -> [bogie_curve] -> force over load of its axles, over creepage

python tests/validation/locomotive_adhesion.py      fits all laws anew and prints their parameters
"""

from __future__ import annotations

import csv
import functools
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core, load_case, simulate
from rollerrig.analysis.estimation import estimate
from rollerrig.assembly.laws import creep_law
from rollerrig.common.free_number import FreeNumber
from rollerrig.contact_analysis.traction_curve import LoadedWheel, traction_coefficient

Array = NDArray[np.float64]

DATA = Path(__file__).with_name("data")
WHEEL = LoadedWheel(
    radius=0.625, load=106.7e3, speed=10.0, a_over_b=0.5, shear_modulus=82e9, poisson_ratio=0.28
)  # fmt: skip
"""36 km/h, 106.7 kN; a/b and G as in CONTACT's example of these measurements."""


@dataclass(frozen=True)
class Bins:
    """Means of the measured points: creepage [-], traction coefficient, its standard error, number, ends of the bins [-]."""

    creepage: Array
    mean: Array
    error: Array
    points: Array
    low: Array
    high: Array


@functools.cache
def bins() -> Bins:
    with (DATA / "eurosprinter_bins.csv").open() as lines:
        table = [{key: float(text) for key, text in row.items()} for row in csv.DictReader(lines)]

    def column(name: str, factor: float = 1.0) -> Array:
        return factor * np.array([row[name] for row in table])

    return Bins(
        column("creepage_mean", 0.01), column("traction_mean"), column("traction_se"), column("points"),
        column("creepage_low", 0.01), column("creepage_high", 0.01),
    )  # fmt: skip


def points(shared: Path) -> tuple[Array, Array]:
    """Creepage and traction coefficient of the 158 points, which are a third party's."""
    text = [
        line
        for line in (shared / "reference" / "eurosprinter_measured.csv").read_text().splitlines()
        if line[:1].isdigit()
    ]
    creepage, traction = np.array([line.split(",") for line in text], dtype=float).T
    return 0.01 * creepage, traction


@dataclass(frozen=True)
class ParameterSet:
    """A creep law with numbers.

    Attributes:
        law: name of the creep law.
        fitted: whether the numbers were fitted here, to the 13 means.
        numbers: mu_0, A, B [s/m]; k_A, k_S of the rail's condition, or k_0, k_inf, beta of the law.
        origin: who published them.
        condition: the named condition of a rail that has them.
    """

    law: str
    fitted: bool
    numbers: Mapping[str, float]
    origin: str = ""
    condition: str = ""

    def curve(self, creepage: Array, wheel: LoadedWheel = WHEEL) -> Array:
        """Traction coefficient per creepage."""
        return coefficient(self.law, self.numbers, creepage, wheel)


def coefficient(law: str, numbers: Mapping[str, float], creepage: Array, wheel: LoadedWheel = WHEEL) -> Array:
    friction = _core.friction_laws["falling"](**{name: numbers[name] for name in ("mu_0", "A", "B")})
    reduction = (numbers["k_A"], numbers["k_S"]) if "k_A" in numbers else None
    own = {name: numbers[name] for name in ("k_0", "k_inf", "beta") if name in numbers}
    if law == "polach":
        own = {"k_A": numbers["k_A"], "k_S": numbers["k_S"]}
    return traction_coefficient(wheel, creepage, friction, creep_law(law, **own), reduction)


@functools.cache
def sets() -> tuple[ParameterSet, ...]:
    """Published and fitted parameters, in the order of the page."""
    data = tomllib.loads((DATA / "eurosprinter_sets.toml").read_text(encoding="utf-8"))
    return tuple(ParameterSet(**one) for one in data["set"])


# ------------------------------------------------------------------------------------------------------------- fits

START: Mapping[str, tuple[float, float, float]] = {
    "mu_0": (0.35, 0.05, 1.0), "A": (0.4, 0.0, 1.0), "B": (0.5, 0.0, 5.0),
    "k_A": (0.7, 0.01, 1.0), "k_S": (0.3, 0.01, 1.0),
    "k_0": (0.54, 0.01, 1.0), "k_inf": (0.05, 1e-3, 1.0), "beta": (0.64, 0.0, 50.0),
}  # fmt: skip
"""Start and range of each number that is fitted."""
FREE: Mapping[str, tuple[str, ...]] = {
    "polach": ("mu_0", "B", "k_S"),
    "modified_fastsim": ("mu_0", "B", "k_0", "k_inf", "beta"),
    "table": ("mu_0", "B", "k_A"),
    "fastsim": ("mu_0", "B", "k_A"),
    "kalker_saturated": ("mu_0", "B", "k_A"),
}
"""Numbers fitted of each law. Laws other than Polach's know only the mean of k_A and k_S, (A4): both are equal there."""
HELD: Mapping[str, Mapping[str, float]] = {"polach": {"A": 0.40, "k_A": 1.0}}
"""Those of Polach's dry rail that the means do not determine: up to the 1.9 m/s of slip that were measured, A cannot be told from
B (a fit of both ends at A = 0), nor k_A from k_S. A is held in every law."""


def fit(law: str, without: int | None = None) -> tuple[dict[str, float], dict[str, float]]:
    """Numbers of a law that fit the 13 means, or those without one, weighted by their errors, and their standard errors."""
    names, measured = FREE[law], bins()
    used = [k for k in range(len(measured.mean)) if k != without]

    def numbers(values: Array) -> dict[str, float]:
        found = {"A": 0.40, **HELD.get(law, {}), **dict(zip(names, map(float, values), strict=True))}
        if law != "polach" and "k_A" in found:
            found["k_S"] = found["k_A"]
        return found

    def deviation(values: Array) -> Array:
        return ((coefficient(law, numbers(values), measured.creepage) - measured.mean) / measured.error)[used]

    free = [FreeNumber(name, *START[name][1:]) for name in names]
    tries = [[factor * START[name][0] for name in names] for factor in (1.0, 0.6, 1.4)]
    found = min((estimate(free, deviation, start) for start in tries), key=lambda one: one.cost)
    return numbers(np.array(list(found.values.values()))), found.errors


@functools.cache
def left_out(law: str) -> Array:
    """Error at each mean of a law that is fitted to the other twelve."""
    every = range(len(bins().mean))
    predicted = [coefficient(law, fit(law, without=k)[0], bins().creepage[k : k + 1])[0] for k in every]
    return np.array(predicted) - bins().mean


# ------------------------------------------------------------------------------------------------------------ bogie

DRIVES = {
    "feedback": {"kind": "proportional_integral", "largest": "70 kN m"},
    "motor": {"largest_torque": "70 kN m", "largest_power": "3 MW", "largest_speed": "134 rad/s"},
}
"""Of the case `locomotive_traction`."""
ON_RIG: Mapping[str, Any] = {
    "support": {"use": "full_scale_rig"}, "motion.drive": "free", "contact.friction": 0.55, "rig_control": DRIVES,
    "contact.creepage_regularisation_speed": "1 m/s",
}  # fmt: skip


@functools.cache
def traction(on_rig: bool = False) -> xr.Dataset:
    """Creepage and traction coefficient of the bogie's axles in the case eurosprinter_traction, or of that on the rig."""
    case = load_case("eurosprinter_traction")
    run = simulate(case.with_changes(ON_RIG) if on_rig else case)
    assert run.attrs["status"] == "ok"
    axles = [str(name) for name in run["axle"].to_numpy()]
    train = run["train_speed"]
    sides = [run["vertical_force"].sel(wheel=[f"{name}_{side}" for name in axles]) for side in ("left", "right")]
    load = run["axle_speed"].copy(data=sum(side.to_numpy() for side in sides))
    if on_rig:  # of the axles of the virtual train on its rail, loaded as the real ones
        force, speed, own = run["virtual_force"], run["virtual_speed"], 0.0
    else:  # a bogie yields on its traction rod
        force, speed = run["creep_force"], run["axle_speed"]
        own = run["longitudinal_velocity"].sel(body=axles).rename(body="axle")
    creepage = (WHEEL.radius * speed - train - own) / train
    return xr.Dataset({"creepage": creepage, "traction_coefficient": force / load, "load": load})


def at(run: xr.Dataset, axle: str, creepage: Array, load: float | None = None) -> Array:
    """Traction coefficient of an axle where it first has these creepages; over a given load [N], or over that of the instant."""
    own = run.sel(axle=axle)
    slip, force = own["creepage"].to_numpy(), own["traction_coefficient"].to_numpy()
    if load is not None:
        force = force * own["load"].to_numpy() / load
    risen = int(np.argmax(slip > creepage.max())) + 1
    assert slip[risen - 1] > creepage.max()
    return np.interp(creepage, slip[:risen], force[:risen])


def bogie(creepage: Array, on_rig: bool = False) -> Array:
    """Mean traction coefficient of the bogie's two axles, each over its own load of the instant."""
    run = traction(on_rig)
    return np.mean([at(run, str(axle), creepage) for axle in run["axle"].to_numpy()], axis=0)


# --------------------------------------------------------------------------------------------------------- measures


def rms(difference: Array) -> float:
    """Root of the mean of the squares."""
    return float(np.sqrt(np.mean(difference**2)))


def within(curve: Array, errors: float = 3.0) -> int:
    """Number of means that a curve passes within so many standard errors."""
    return int(np.sum(np.abs(curve - bins().mean) <= errors * bins().error))


def main() -> None:
    for law in FREE:
        numbers, errors = fit(law)
        curve = coefficient(law, numbers, bins().creepage)
        chi = float(np.sum(((curve - bins().mean) / bins().error) ** 2))
        print(law, f"chi2 {chi:.2f}", f"rms {rms(curve - bins().mean):.4f}", within(curve))
        print("   ", {k: f"{v:.4g} +- {errors.get(k, float('nan')):.2g}" for k, v in numbers.items()})


if __name__ == "__main__":
    main()
