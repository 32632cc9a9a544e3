"""Numbers of a run as a summary: loss of contact, resolution of the output.

    signal, unit -> [resolution] -> the signal with zeros where it means nothing
    spells without contact of the core -> [contact_loss] -> attribute `contact_losses`, warnings

Symmetric vehicles do not move sideways, but for 1e-17 m: what is round-off is zero. Meanings and units of the numbers that go
into summary.json are registered in quantities.toml.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rollerrig.common.arrays import Array
from rollerrig.results.dataset import Draft, readings_of
from rollerrig.results.run_info import RunInfo

RESOLUTION = {"m": 1e-10, "rad": 1e-10, "m/s": 1e-9, "m/s^2": 1e-7, "N": 1e-3, "1": 1e-8}
"""Magnitude below which a value counts as zero, by unit; of displacements a tenth of the default absolute tolerance."""


def resolved(values: ArrayLike, unit: str) -> Array:
    """Values of any shape with zeros where their magnitude is below that of RESOLUTION for the unit; NaN stays."""
    given = np.asarray(values, dtype=np.float64)
    return np.where(np.abs(given) < RESOLUTION[unit], 0.0, given)


ATTRIBUTE = "contact_losses"

LONGEST_SPELL = 10e-3
"""Without contact for longer than this a wheel has left its rail; shorter ones are vibrations on the contact's spring [s]."""

LARGEST_PART = 1e-2
"""Part of a run that a wheel may vibrate without contact before a warning [-]."""

Spells = tuple[int, float, float, float]
"""Number, sum, longest [s], and when that one began [s]."""


@dataclass(frozen=True)
class ContactLoss:
    """What one wheel ran without contact."""

    wheel: str  # its name
    spells: int  # number of times
    total_s: float  # sum of their durations [s]
    longest_s: float  # duration of the longest [s]
    longest_from_s: float  # time at which that one began [s]
    longest_from_m: float  # distance there [m]

    def in_words(self, on_rollers: bool) -> str:
        """Text for a warning: the wheel, how long, when and where."""
        times = "once" if self.spells == 1 else f"{self.spells} times, {1e3 * self.total_s:.3g} ms in all"
        place = "" if on_rollers else f", {self.longest_from_m:.5g} m"
        longest = f"{1e3 * self.longest_s:.3g} ms at t = {self.longest_from_s:.4g} s{place}"
        return f"{self.wheel} without contact {times}; the longest {longest}"


def add_contact_losses(draft: Draft, wheels: Sequence[str], spells: Sequence[Spells]) -> list[ContactLoss]:
    """Add the losses of all wheels that had any, from the spells of each, to a draft with `distance`, as JSON; return them."""
    times, distances = draft.values("time"), draft.values("distance")
    losses = [
        ContactLoss(wheel, count, total, longest, at, float(np.interp(at, times, distances)) if len(times) else 0.0)
        for wheel, (count, total, longest, at) in zip(wheels, spells, strict=True)
        if count
    ]
    draft.attributes[ATTRIBUTE] = json.dumps([asdict(loss) for loss in losses])
    return losses


def contact_losses(run: xr.Dataset) -> list[ContactLoss]:
    """Losses of every wheel that lost contact, in the order of the wheels."""
    return [ContactLoss(**loss) for loss in json.loads(run.attrs.get(ATTRIBUTE, "[]"))]


def keeps_contact(longest: float, total: float, duration: float) -> bool:
    """Whether a wheel was without contact for no longer than vibrations explain; not where a number is missing.

    Args:
        longest: time without contact [s].
        total: sum of all such times [s].
        duration: of the run [s].
    """
    return longest <= LONGEST_SPELL and total <= LARGEST_PART * duration


def contact_loss_warning(losses: Sequence[ContactLoss], duration: float, *, on_rollers: bool, advice: str = "") -> str:
    """One line that names the wheels whose contact was lost for longer than vibrations explain; empty if there are none.

    Args:
        losses: of a run.
        duration: of the run [s].
        on_rollers: whether it was on a rig.
        advice: what to try, a sentence.
    """
    gross = [loss for loss in losses if not keeps_contact(loss.longest_s, loss.total_s, duration)]
    if not gross:
        return ""
    told = "wheels lost contact: " + "; ".join(loss.in_words(on_rollers) for loss in gross)
    return f"{told}. {advice}" if advice else told


def summarise(run: xr.Dataset) -> dict[str, Any]:
    """The numbers of a run by name; None where a number does not exist."""
    attributes = run.attrs
    speed = 3.6 * run["speed"].to_numpy()
    return {
        **{key: attributes[key] for key in ("case", "status", "status_message", "stopped_at_s", "stopped_wheel")},
        **{key: attributes[key] for key in ("stopped_at_m", "stopped_segment", "stopped_quotient_wheel")},
        "stopped_quotient": _finite(np.array([attributes["stopped_quotient"]])),
        "samples": run.sizes["time"],
        "speed_start_kmh": _finite(speed[:1]),
        "speed_end_kmh": _finite(speed[-1:]),
        "energy_turned_over_j": attributes["energy_turned_over_j"],
        "energy_relative_residual": attributes["energy_relative_residual"],
        "warnings": attributes["warnings"],
        "bodies": {body: _body(run.sel(body=body)) for body in RunInfo.of(run).moving},
        "wheels": _wheels(run),
        "solver": json.loads(attributes["solver_statistics"]),
        "contact": json.loads(attributes["contact_counters"]),
        "rollerrig_version": attributes["rollerrig_version"],
    }


def _body(run: xr.Dataset) -> dict[str, float | None]:
    lateral = 1e3 * _resolved(run["lateral"])
    tail = lateral[-max(1, len(lateral) // 10) :]
    return {
        "lateral_largest_mm": _finite(np.abs(lateral)),
        "lateral_end_mm": _finite(lateral[-1:]),
        "lateral_last_tenth_mm": _finite(np.abs(tail)),
        "yaw_largest_mrad": _finite(np.abs(1e3 * _resolved(run["yaw"]))),
    }


def _wheels(run: xr.Dataset) -> dict[str, dict[str, float | int | None]]:
    """Forces as they were computed, at every reading; what is assessed goes through filters first."""
    readings = readings_of(run)
    dense = run if readings is None else readings
    lost = {loss.wheel: loss for loss in contact_losses(run)}
    wheels = map(str, run["wheel"].to_numpy())
    return {name: _wheel(run.sel(wheel=name), dense.sel(wheel=name), lost.get(name)) for name in wheels}


def _wheel(run: xr.Dataset, dense: xr.Dataset, loss: ContactLoss | None) -> dict[str, float | int | None]:
    q, y = dense["vertical_force"].to_numpy(), _resolved(dense["lateral_force"])
    loaded = q > 0
    sliding = _resolved(run["longitudinal_sliding"])
    return {
        "vertical_force_start_n": _finite(q[:1]),
        "vertical_force_end_n": _finite(q[-1:]),
        "vertical_force_least_raw_n": _finite(q, np.min),
        "lateral_force_largest_raw_n": _finite(np.abs(y)),
        "derailment_quotient_largest_raw": _finite(np.abs(y[loaded] / q[loaded])),
        "longitudinal_sliding_largest_mps": _finite(np.abs(sliding)),
        "longitudinal_sliding_end_mps": _finite(sliding[-1:]),
        "samples_with_several_patches": int(np.count_nonzero(run["patch_count"].to_numpy() > 1)),
        "without_contact_s": loss.total_s if loss else 0.0,
        "without_contact_longest_s": loss.longest_s if loss else 0.0,
    }


def _resolved(signal: xr.DataArray) -> Array:
    return resolved(signal, str(signal.attrs["units"]))


def _finite(values: Array, of: Callable[[Array], Any] = np.max) -> float | None:
    """The largest, or least; an interrupted run may have no values, an unloaded wheel has NaN."""
    finite = values[np.isfinite(values)]
    return float(of(finite)) if finite.size else None
