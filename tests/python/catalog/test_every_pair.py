"""Every vehicle of the catalogue runs on every track and rig of its gauge; all other pairs are refused by the gauge."""

from __future__ import annotations

import pytest

from rollerrig import load_case, simulate
from rollerrig.catalog import catalog_names
from rollerrig.config import Case, ConfigError, Rig, load_support, load_vehicle
from rollerrig.results.run_info import RunInfo

CUT = {"cooperrider": "bogie", "textbook_wheelset": "wheelset"}
"""Vehicles that are of use in parts alone: what holds their car body or frame."""

ROD = {"height": "1.05 m", "stiffness": "10 MN/m", "damping": "100 kN s/m"}
"""The coupler rod of `vehicle_rollers`."""

GAUGES = {1.36: 1.435, 1.2926: 1.4136}
"""Back to back of the wheels -> gauge [m]."""

PAIRS = [(vehicle, support) for vehicle in catalog_names("vehicle") for support in catalog_names("support")]


def fits(vehicle: str, support: str) -> bool:
    return GAUGES[load_vehicle(vehicle).wheel.back_to_back] == load_support(support).gauge


def pair(vehicle: str, support: str, duration: float) -> Case:
    """At 40 km/h, centred; whole vehicles on rollers are held by a rod."""
    under: dict[str, object] = {"use": support}
    whole = len(load_vehicle(vehicle).body) > 1 and vehicle not in CUT
    if whole and isinstance(load_support(support), Rig):
        under["restraint"] = ROD
    return load_case("bogie_track").with_changes({
        "vehicle": {"use": vehicle, **({"cut": CUT[vehicle]} if vehicle in CUT else {})},
        "support": under,
        "motion.speed": "40 km/h",
        "disturbance": [],
        "time.duration": duration,
        "time.output_step": "10 ms",
    })  # fmt: skip


@pytest.mark.parametrize(("vehicle", "support"), [one for one in PAIRS if fits(*one)])
def test_it_runs(vehicle: str, support: str) -> None:
    run = simulate(pair(vehicle, support, 0.1))
    assert run.attrs["status"] == "ok"
    loads = [2.0 * (body.wheel_load or 0.0) for body in RunInfo.of(run).wheelsets]
    assert float(run["vertical_force"].isel(time=-1).sum()) == pytest.approx(sum(loads), rel=5e-3)
    assert abs(run.attrs["energy_relative_residual"]) < 1e-5


@pytest.mark.parametrize(("vehicle", "support"), [one for one in PAIRS if not fits(*one)])
def test_another_gauge_is_refused(vehicle: str, support: str) -> None:
    with pytest.raises(ConfigError, match=r"support\.gauge: 1\.4.*check gauge|of different gauge"):
        simulate(pair(vehicle, support, 0.1))


@pytest.mark.long
@pytest.mark.parametrize(("vehicle", "support"), [one for one in PAIRS if fits(*one)])
def test_it_runs_to_the_end_of_the_line(vehicle: str, support: str) -> None:
    segments = getattr(load_support(support), "segment", ())
    length = sum(one.length for one in segments)
    run = simulate(pair(vehicle, support, max(10.0, (length + 30.0) / (40.0 / 3.6))))
    assert run.attrs["status"] == "ok"
    assert float(run["distance"][-1]) > length
