"""What is run for an envelope map: axle torques, adhesions of the virtual rail and axle loads, and the test at each of them.

Case of a rig with [rig_control], Point -> [point_case] -> the case that is run

At each point the torque rises within RISE and stays; slide protection or wheel-slip control, the case's or else one with
default settings, lets the wheels slide and regain speed. The case's own cylinders and motors would be slower: here the torque
is what is asked for, so that the map describes the rig.
"""

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.analysis import rig_limits
from rollerrig.analysis.rig_limits import LINES, NUMBERS, REGIONS, Record, RigLimits
from rollerrig.analysis.virtual_rail import Patch, grip_slip, patch_of, rail_shape
from rollerrig.assembly.actuators import friction_brake
from rollerrig.assembly.model import assemble
from rollerrig.common.arrays import Array
from rollerrig.common.formatting import number
from rollerrig.config import Brake, Case, ConfigError, ConfigProblem, Traction
from rollerrig.results import variable
from rollerrig.simulation.mechatronics import full_brake_torque
from rollerrig.simulation.starting_state import StartError
from rollerrig.simulation.virtual_train import load_transfer
from rollerrig.study.jobs import Progress, whole_run

BEGIN, RISE = 0.1, 0.2  # the torque begins to act, and takes so long to its full value [s]

LEAST_DURATION = round(2.0 * (BEGIN + RISE), 9)
"""Duration of a run: the full torque acts for half of it [s]; rounded, since 0.1 + 0.2 is not quite 0.3."""

FOLLOW = 200.0  # rate of the test's control valve and cylinder [1/s]: the torque follows the ramp within a few ms

PAD_FRICTION = 0.35
"""Pad friction of the test's brake, constant over speed, so that its pressure gives the torque asked for [-]."""

ADHESIONS = (0.02, 0.04, 0.06, 0.08, 0.12, 0.16, 0.20, 0.25, 0.30, 0.36)
LOADS = (0.6, 1.0, 1.4)
TORQUES = 12  # torques of a default map

MOST_RUNS = 100_000
MOST_REFINED = 4


class Point(NamedTuple):
    """A place on the map: axle load over the case's own [-], torque on each axle, positive forward [N m], adhesion [-]."""

    load: float
    torque: float
    adhesion: float

    @property
    def label(self) -> str:
        """Label for a title."""
        return f"{number(1e-3 * self.torque, 3)} kN m, adhesion {self.adhesion:.3g}, load {self.load:.3g}"


def default_torques(case: Case) -> list[float]:
    """Beyond what rollers or their drives carry, in round steps; brakes for a case with [brake], otherwise traction."""
    rig = rig_limits.rig_limits(case)
    raw = 1.3 * max(min(rig.contact(), rig.drive_grip()), 1e-6) / TORQUES
    power = 10.0 ** math.floor(math.log10(raw))
    step = min((1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0), key=lambda s: abs(s * power - raw)) * power
    rising = [float(f"{step * k:.9g}") for k in range(1, TORQUES + 1)]
    return [-torque for torque in reversed(rising)] if case.brake is not None else rising


def vehicle_torque(case: Case, brakes: bool) -> float | None:
    """Largest torque that the vehicle itself exerts on an axle at the start [N m]; None: no limit is known.

    Of its brake at the demand's largest pressure, or of its motor's envelope.
    """
    if brakes and case.brake is not None:
        return abs(full_brake_torque(case))
    envelope = case.traction.motor.envelope if case.traction is not None else None
    if brakes or envelope is None:
        return None
    return float(np.interp(case.motion.speed / case.vehicle.data.wheel.radius, *np.array(envelope).T))


def point_case(case: Case, point: Point, duration: float) -> Case:
    """The test at one point of the map, for a duration [s]."""
    changes: dict[str, object] = {
        "time.duration": duration,
        "time.output_step": 5.0 * case.time.sampling_step,
        "adhesion": {"rail": _rail(case, point.adhesion)},
        **_load_changes(case, point.load),
        **(_braking(case, -point.torque) if point.torque < 0.0 else _pulling(case, point.torque)),
    }
    return case.with_changes(changes)


def _rail(case: Case, adhesion: float) -> dict[str, Any]:
    """The case's condition of the rail with another friction at no slip."""
    shape = _plain(rail_shape(case))
    return {**shape, "friction": {**shape["friction"], "mu_0": adhesion}}


def _load_changes(case: Case, load: float) -> dict[str, object]:
    if load == 1.0:
        return {}
    body = max((b for b in case.vehicle.data.body if b.kind != "wheelset"), key=lambda b: b.mass)
    mass = _loaded_mass(case, load)
    inertia = [mass / body.mass * value for value in body.inertia]
    return {f"vehicle.body.{body.name}.mass": mass, f"vehicle.body.{body.name}.inertia": inertia}


def _loaded_mass(case: Case, load: float) -> float:
    """Mass of the heaviest body where all axle loads are multiplied; not positive where the rest is too heavy already."""
    bodies = case.vehicle.data.body
    heaviest = max((b.mass for b in bodies if b.kind != "wheelset"), default=0.0)
    return float(heaviest + (load - 1.0) * sum(b.mass for b in bodies)) if heaviest else 0.0


def _braking(case: Case, torque: float) -> dict[str, object]:
    brake = case.brake or Brake(demand=((0.0, 0.0), (1.0, 0.0)))
    constant = {"friction": ((0.0, PAD_FRICTION), (50.0, PAD_FRICTION))}
    pressure = brake_pressure(brake.model_copy(update=constant), torque)
    quick = {
        "demand": [[0.0, 0.0], [BEGIN, 0.0], [BEGIN + RISE, pressure]],
        **constant,
        "application_rate": 100.0 * pressure / RISE,
        "release_rate": 100.0 * pressure / RISE,
        "follow_rate": FOLLOW,
        "air": {"kind": "unlimited", "fill_rate": FOLLOW},
        "by_traction_motors": False,
        "electrodynamic": None,
    }
    protection: object = {} if case.slide_protection is None else case.slide_protection
    without = {"traction": None, "wheel_slip_control": None}
    return {"brake": {**_plain(brake), **quick}, "slide_protection": protection, **without}


def brake_pressure(brake: Brake, torque: float) -> float:
    """Cylinder pressure of a brake with constant friction for a torque on the axle [Pa], from the core's brake."""
    core, fast = friction_brake(brake), 1e9  # rad/s: far above the speed below which friction is regularised

    from scipy.optimize import brentq  # slow to load, and seldom needed

    def excess(pressure: float) -> float:
        return -float(core.torque(pressure, fast)) - torque

    highest = 1e6
    while excess(highest) < 0.0:
        highest *= 2.0
    return float(brentq(excess, 0.0, highest, xtol=1e-9, rtol=1e-15))


def _pulling(case: Case, torque: float) -> dict[str, object]:
    traction = case.traction or Traction()
    motor = traction.motor.model_copy(update={"envelope": None})
    demand = [[0.0, 0.0], [BEGIN, 0.0], [BEGIN + RISE, torque]]
    return {
        "traction": {**_plain(traction), "demand": demand, "motor": _plain(motor)},
        "wheel_slip_control": {} if case.wheel_slip_control is None else case.wheel_slip_control,
        "brake": None,
        "track_brake": None,
        "sanding": None,
        "slide_protection": None,
    }


def _plain(table: Any) -> dict[str, Any]:
    values: dict[str, Any] = table.model_dump(exclude_none=True)
    return values


def check(case: Case, torques: Sequence[float], adhesions: Sequence[float], loads: Sequence[float], duration: float,
          refine: int) -> None:  # fmt: skip
    """Refuse what cannot be run, with a ConfigError of all mistakes found; arguments as of `EnvelopeStudy`."""
    problems = []

    def refuse(key: str, value: object, allowed: str) -> None:
        problems.append(ConfigProblem(case.name, f"envelope: {key}", str(value), f"allowed: {allowed}"))

    for key, values, least in (("torques", torques, 2), ("adhesions", adhesions, 2), ("loads", loads, 1)):
        rising = all(a < b for a, b in itertools.pairwise(values))
        if len(values) < least or not rising or not all(map(math.isfinite, values)):
            refuse(key, _few(values), f"at least {least} finite numbers in ascending order")
    if not problems and (not adhesions[0] > 0.0 or not adhesions[-1] <= 1.0):
        refuse("adhesions", _few(adhesions), "above 0 and up to 1")
    bodies = case.vehicle.data.body
    heaviest = max((b.mass for b in bodies if b.kind != "wheelset"), default=0.0)
    for load in (load for load in loads if not _loaded_mass(case, load) > 0.0):
        least_load = 1.0 - heaviest / sum(b.mass for b in bodies)
        allowed = f"above {least_load:.2g}, where nothing is left of the heaviest body, which carries the load"
        refuse("loads", f"{load:g}", allowed if heaviest else "1: there is no body but wheelsets to load")
    if not LEAST_DURATION <= duration <= 60.0:
        refuse("duration", f"{duration:g} s", f"{LEAST_DURATION:g} s to 60 s")
    if not 0 <= refine <= MOST_REFINED:
        refuse("refine", refine, f"0 to {MOST_REFINED}")
    elif (count := len(loads) * len(between(torques, 2**refine)) * len(between(adhesions, 2**refine))) > MOST_RUNS:
        refuse("torques, adhesions, loads", f"{count} points", f"at most {MOST_RUNS}")
    if problems:
        raise ConfigError(problems)


def _few(values: Sequence[float]) -> str:
    shown = ", ".join(f"{value:g}" for value in values[:6])
    return (shown or "none") + (", ..." if len(values) > 6 else "")


def between(values: Sequence[float], parts: int) -> tuple[float, ...]:
    """The values, with each interval divided into so many parts."""
    found = [a + (b - a) * k / parts for a, b in itertools.pairwise(values) for k in range(parts)]
    return (*(float(f"{value:.9g}") for value in found), values[-1])


@dataclass(frozen=True)
class OnTrack:
    """What the virtual train takes from the vehicle on track: the same for all runs of a load; None: no equilibrium."""

    load_transfer: tuple[float, ...] | None = None
    patch: Patch | None = None
    limits: RigLimits | None = None


def find_on_track(case: Case) -> OnTrack:
    """Search on track for the load of a case."""
    model = assemble(case)
    try:
        return OnTrack(tuple(load_transfer(model)), patch_of(model), rig_limits.rig_limits(case))
    except StartError:  # every run of this load fails with the same error, and records it
        return OnTrack()


def run_point(case: Case, point: Point, known: OnTrack, progress: Progress | None = None) -> Record:
    """Run a point and assess its limits."""
    control = case.rig_control
    if known.load_transfer is not None and control is not None:
        control = control.model_copy(update={"load_transfer": known.load_transfer})
        case = case.model_copy(update={"rig_control": control})
    try:
        run = whole_run(case, progress)
    except StartError as error:
        return rig_limits.failed("no_start", str(error))
    assert known.patch is not None  # or the run would not have started
    return rig_limits.assess_limits(run, case, point.torque, grip_slip(case, known.patch, point.adhesion), known.limits)


DIMENSIONS = ("load", "adhesion", "torque")


def map_dataset(
    case: Case,
    loads: Sequence[float],
    adhesions: Sequence[float],
    torques: Sequence[float],
    done: Mapping[Point, Record],
) -> xr.Dataset:
    """The map of the records that there are; see `envelope`."""
    blank: Record = {"region": "", "limits": {}, "status": "", **dict.fromkeys(NUMBERS)}
    records = [done.get(Point(load, t, mu), blank) for load, mu, t in itertools.product(loads, adhesions, torques)]

    def over_map(values: Iterable[Any], kind: type = str) -> Any:
        return np.array(list(values), dtype=kind).reshape(len(loads), len(adhesions), len(torques))

    limits = (", ".join(f"{name} {since:.3g} s" for name, since in one["limits"].items()) for one in records)
    regions, meaning = (
        over_map(one["region"] for one in records),
        "; ".join(f"{k}: {text}" for k, text in REGIONS.items()),
    )
    variables: dict[str, Any] = {
        "region": (DIMENSIONS, regions, {"long_name": meaning}),
        "limits": (DIMENSIONS, over_map(limits), {"long_name": "limits reached and when, the first one first"}),
        "status": (DIMENSIONS, over_map(one["status"] for one in records), {"long_name": "status of the run"}),
    }
    for name, (unit, meaning) in NUMBERS.items():
        variables[name] = variable(DIMENSIONS, over_map((one[name] for one in records), float), unit, meaning)
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
        "runs": int((regions != "").sum()),
        "rollerrig_version": __version__,
    }
    return _with_lines(xr.Dataset(variables, coordinates, attributes), case)


def _with_lines(found: xr.Dataset, case: Case) -> xr.Dataset:
    """The map with its closed forms over `side` (brake, traction), load and adhesion."""
    loads, adhesions = found["load"].to_numpy().tolist(), found["adhesion"].to_numpy()
    sides = [side for side, on in (("brake", found["torque"][0] < 0), ("traction", found["torque"][-1] > 0)) if on]
    fine = np.linspace(adhesions[0], adhesions[-1], 91)
    brakes = [Point(load, -1.0, float(adhesions[0])) for load in loads]
    forms = [[rig_limits.closed_forms(point_case(case, one if side == "brake" else one._replace(torque=1.0), 1.0), fine)
              for one in brakes] for side in sides]  # fmt: skip

    def over(name: str) -> Array:
        return np.array([[one[name] for one in row] for row in forms])

    own = np.array([vehicle_torque(case, side == "brake") for side in sides], dtype=float)  # NaN: no limit is known
    lines = {name: over(name) for name in LINES if name != "line_vehicle"}
    lines["line_vehicle"] = np.broadcast_to(own[:, None, None], (len(sides), len(loads), len(fine)))
    variables: dict[str, Any] = {
        name: variable(("side", "load", "line_adhesion"), values, "N m", LINES[name]) for name, values in lines.items()
    }
    meaning = "on rails with more adhesion than this a sliding wheel slides on its roller, (V3)"
    variables["contact_adhesion"] = variable(("side", "load"), over("contact_adhesion"), "1", meaning)
    variables["axle_load"] = variable("load", over("axle_load")[0], "N", "mean static load of an axle")
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
