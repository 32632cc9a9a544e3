"""The Dataset of an envelope map: what its runs found over load, adhesion and torque, and the closed forms beside them.

records by Point, grid -> [map_dataset] -> Dataset over load, adhesion and torque, lines over side, load and adhesion
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.analysis.rig_limits import LINES, closed_forms
from rollerrig.analysis.run_limits import NUMBERS, REGIONS, Record
from rollerrig.config import Case
from rollerrig.results import variable
from rollerrig.study.envelope_points import Point, point_case, vehicle_torque

DIMENSIONS = ("load", "adhesion", "torque")


def map_dataset(
    case: Case,
    loads: Sequence[float],
    adhesions: Sequence[float],
    torques: Sequence[float],
    done: Mapping[Point, Record],
) -> xr.Dataset:
    """The map of the records that there are; see `envelope`."""
    shape = (len(loads), len(adhesions), len(torques))
    texts = {name: np.full(shape, "", dtype=object) for name in ("region", "limits", "status")}
    numbers = {name: np.full(shape, np.nan) for name in NUMBERS}
    for place in np.ndindex(*shape):
        record = done.get(Point(loads[place[0]], torques[place[2]], adhesions[place[1]]))
        if record is None:
            continue
        texts["region"][place], texts["status"][place] = record["region"], record["status"]
        texts["limits"][place] = ", ".join(f"{name} {since:.3g} s" for name, since in record["limits"].items())
        for name, values in numbers.items():
            values[place] = np.nan if record[name] is None else record[name]
    meanings = {
        "region": "; ".join(f"{name}: {meaning}" for name, meaning in REGIONS.items()),
        "limits": "limits reached and when, the first one first",
        "status": "status of the run",
    }
    variables: dict[str, Any] = {
        **{name: (DIMENSIONS, texts[name].astype(str), {"long_name": text}) for name, text in meanings.items()},
        **{name: variable(DIMENSIONS, numbers[name], u, m) for name, (u, m) in NUMBERS.items()},
    }
    coordinates = {
        "load": variable("load", list(loads), "1", "axle load over the case's own"),
        "adhesion": variable("adhesion", list(adhesions), "1", "of the virtual rail at no slip"),
        "torque": variable("torque", list(torques), "N m", "on each axle, negative brakes"),
    }
    attributes = {
        "title": f"Operating envelope of {case.name}",
        "case": case.name,
        "config_toml": case.to_toml(),
        "speed_kmh": 3.6 * case.motion.speed,
        "runs": int((texts["region"] != "").sum()),
        "rollerrig_version": __version__,
    }
    return _with_lines(xr.Dataset(variables, coordinates, attributes), case)


def _with_lines(found: xr.Dataset, case: Case) -> xr.Dataset:
    """The map with its closed forms over `side` (brake, traction), load and adhesion."""
    loads, adhesions = found["load"].to_numpy().tolist(), found["adhesion"].to_numpy()
    sides = [side for side, on in (("brake", found["torque"][0] < 0), ("traction", found["torque"][-1] > 0)) if on]
    fine = np.linspace(adhesions[0], adhesions[-1], 91)
    lines = {name: np.full((len(sides), len(loads), len(fine)), np.nan) for name in LINES}
    loads_n, contact = np.zeros(len(loads)), np.zeros((len(sides), len(loads)))
    for (s, side), (k, load) in itertools.product(enumerate(sides), enumerate(loads)):
        loaded = point_case(case, Point(load, -1.0 if side == "brake" else 1.0, float(adhesions[0])), 1.0)
        forms = closed_forms(loaded, fine)
        loads_n[k], contact[s, k] = forms["axle_load"], forms["contact_adhesion"]
        for name in forms.keys() & lines.keys():
            lines[name][s, k] = forms[name]
        own = vehicle_torque(case, side == "brake")
        lines["line_vehicle"][s, k] = np.nan if own is None else own
    variables: dict[str, Any] = {
        name: variable(("side", "load", "line_adhesion"), values, "N m", LINES[name]) for name, values in lines.items()
    }
    meaning = "on rails with more adhesion than this a sliding wheel slides on its roller, (V3)"
    variables["contact_adhesion"] = variable(("side", "load"), contact, "1", meaning)
    variables["axle_load"] = variable("load", loads_n, "N", "mean static load of an axle")
    along = variable("line_adhesion", fine, "1", "adhesion along the closed forms")
    return found.assign(variables).assign_coords(side=("side", sides), line_adhesion=along)


def middles(found: xr.Dataset) -> dict[str, Point]:
    """Region -> the run farthest from any other region and from the map's edge, counted in places of the lattice.

    At the load nearest to the case's own at which the region occurs; 'failed' is left out.
    """
    chosen: dict[str, Point] = {}
    for load in sorted(found["load"].to_numpy(), key=lambda value: abs(value - 1.0)):
        regions = found["region"].sel(load=load).to_numpy()
        for region in (r for r in REGIONS if r != "failed" and r not in chosen and (regions == r).any()):
            own, others = np.argwhere(regions == region), np.argwhere((regions != region) & (regions != ""))
            edge = np.minimum(own, np.array(regions.shape) - 1 - own).min(axis=1) + 1.0
            apart = [np.inf if not len(others) else np.hypot(*(others - place).T).min() for place in own]
            row, column = own[int(np.argmax(np.minimum(edge, apart)))]
            chosen[region] = Point(float(load), float(found["torque"][column]), float(found["adhesion"][row]))
    return {region: chosen[region] for region in REGIONS if region in chosen}
