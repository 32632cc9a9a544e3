"""Models and reference tables that the validation tests share; what the tables are: data/README.md."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from catalogued import profile_table
from rollerrig import _core
from rollerrig.assembly.laws import creep_law
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.assembly.model_parts import Parts, add_part, no_parts
from rollerrig.config import load_case
from rollerrig.profiles import ProfileTable, gauge_point

mm = 1e-3
kmh = 1 / 3.6
DATA = Path(__file__).with_name("data")

#: The steel of the reference tables.
SHEAR_MODULUS, POISSON_RATIO = 82e9, 0.28


def rows(file: str) -> list[dict[str, float | str]]:
    """Rows of a reference table; numbers as float."""

    def value(text: str) -> float | str:
        try:
            return float(text)
        except ValueError:
            return text

    with (DATA / file).open() as lines:
        return [{key: value(text) for key, text in row.items()} for row in csv.DictReader(lines)]


def rail_origin(table: ProfileTable, gauge: float = 1.435, depth: float = 14 * mm) -> float:
    """Lateral position of the rail's highest point for a gauge taken `depth` below it [m]."""
    return gauge / 2 + abs(gauge_point(table, depth))


def benchmark_contact(roller_radius: float | None, normal: str = "hertz") -> _core.StaticWheelsetContact:
    """The wheelset of the Manchester contact benchmark on its rails, or on rollers of the rails' head."""
    wheel, rail = profile_table("s1002", "wheel"), profile_table("uic60_benchmark_1_40", "rail")
    return static_contact_of(wheel, rail, roller_radius, rail_origin(rail), normal)


def static_contact_of(
    wheel: ProfileTable, rail: ProfileTable, roller_radius: float | None, origin: float, normal: str = "hertz"
) -> _core.StaticWheelsetContact:
    """A wheelset of radius 460 mm and these profiles, ready to be pressed down."""
    parts = wheelset_parts(wheel, rail, roller_radius, origin, normal)
    return _core.StaticWheelsetContact(_core.model_of(_core.ModelParts(**parts)), 0, 1)


def wheelset_parts(
    wheel: ProfileTable,
    rail: ProfileTable,
    roller_radius: float | None,
    origin: float,
    normal: str = "hertz",
    creep: str = "kalker_saturated",
    normal_damping: float = 1e5,
    friction: float = 0.3,
) -> Parts:
    """Of a wheelset of radius 460 mm, left wheel first; no roller radius: on rails."""
    laws = _core.ContactLaws(
        material=_core.Material(shear_modulus=SHEAR_MODULUS, poisson_ratio=POISSON_RATIO),
        normal=_core.Hertz(merging_criterion=0.0) if normal == "hertz" else _core.Strips(),
        damping=_core.NormalDamping(damping=normal_damping, smoothing_speed=1e-4),
        creep=creep_law(creep),
        kalker_factor=1.0,
        creepage_regularisation_speed=0.1,
        roller=_core.RollerEffects(curvature=True, conicity=True, spin=True, yaw=True),
    )
    parts = no_parts(9.81, laws)
    for height in (0.46, -roller_radius) if roller_radius else (0.46,):
        add_part(parts, "bodies", axisymmetric(height))
    for profile in (wheel, rail):
        add_part(parts, "profiles", _core.UniformSpline(profile.start, profile.step, profile.coefficients))
    for right in (False, True):
        contact = _core.ContactDescription(
            wheelset=0,
            roller=1 if roller_radius else -1,
            roller_radius=roller_radius or 0.0,
            right=right,
            wheel_profile=0,
            rail_profile=1,
            wheel_radius=0.46,
            tape_circle_y=0.75,
            rail_origin_y=origin,
            size=1.0,
            friction=_core.Friction(law=_core.Constant(mu_0=friction), map=None, gauge_face=-1.0),
        )
        add_part(parts, "contacts", contact)
    return parts


def axisymmetric(height: float) -> _core.Body:
    """A wheelset or a roller whose centre is at a height [m]; only its place counts."""
    return _core.Body(
        mass=2000.0,
        inertia=(1000.0, 100.0, 1000.0),
        position=(0.0, 0.0, height),
        axisymmetric=True,
        locked=[False] * 6,
        speed_controlled_radius=0.0,
        in_moving_frame=True,
        loss_constant=0.0,
        loss_linear=0.0,
        loss_quadratic=0.0,
    )


def bogie(support: str = "full_scale_rig", speed: float = 60 * kmh, **changes: object) -> AssembledModel:
    """The leading bogie of the Manchester vehicle, rollers held at `speed` [m/s]; no disturbance, no torque."""
    return cut("leading_bogie", support, speed, **changes)


def cut(name: str, support: str, speed: float, **changes: object) -> AssembledModel:
    """A part of the Manchester vehicle on a support, speed held; keys of changes with `__` for the dots."""
    dotted = {key.replace("__", "."): value for key, value in changes.items()}
    case = load_case("bogie_rollers_constant").with_changes(
        {"vehicle.cut": name, "support.use": support, "motion.speed": f"{speed} m/s", "disturbance": [], **dotted}
    )
    return assemble(case)


def equilibrium(
    simulation: _core.Simulation, speed: float, held: tuple[tuple[int, int, float], ...] = ()
) -> np.ndarray:
    """State of steady running [m/s]."""
    result = simulation.equilibrium(speed, 0.0, list(held))
    assert result["converged"], result
    return result["x"]


def settings(
    simulation: _core.Simulation, duration: float, tolerance: float = 1e-7, **given: object
) -> dict[str, object]:
    """Arguments of Simulation.start: rodas4; `tolerance` is relative, 1e-3 of it absolute on displacements [m, rad]."""
    absolute = np.full(simulation.state_count, 1e-3 * tolerance)
    absolute[[i for body in simulation.rate_index for i in body if i >= 0]] = 1e-1 * tolerance  # at some 100 rad/s
    defaults: dict[str, object] = {
        "method": "rodas4",
        "step": 0.0,
        "relative_tolerance": tolerance,
        "absolute_tolerance": absolute.tolist(),
        "initial_step": 1e-6,
        "maximum_step": 0.01,
        "final_time": duration,
        "output_step": 0.01,
        "breakpoints": [],
    }
    return defaults | given


class Run:
    """A finished run: times and fields by name."""

    def __init__(
        self,
        simulation: _core.Simulation,
        x0: np.ndarray,
        duration: float,
        t_stop: float | None = None,
        t0: float = 0.0,
        **given: object,
    ) -> None:
        arguments = settings(simulation, duration, **given)
        count = round(duration / float(arguments["output_step"])) + 2  # type: ignore[arg-type]
        self.time = np.full(count, np.nan)
        self.rows = np.full((count, simulation.width), np.nan)
        simulation.start(_core.Options(**arguments), t0=t0, x0=x0)  # type: ignore[arg-type]
        self.status, filled = simulation.advance(t_stop or duration, self.time, self.rows, 0)
        self.time, self.rows = self.time[:filled], self.rows[:filled]
        self.statistics, self.counters, self.final_state = (
            simulation.statistics(),
            simulation.counters(),
            simulation.state,
        )
        self.bodies = len(simulation.rate_index)

    def body(self, index: int, field: str) -> np.ndarray:
        """A field of a body over time."""
        names = [name for name, _, _ in _core.body_fields]
        return self.rows[:, index * len(names) + names.index(field)]

    def wheel(self, index: int, field: str) -> np.ndarray:
        """A field of a wheel over time."""
        names = [name for name, _, _ in _core.wheel_fields]
        start = self.bodies * len(_core.body_fields)
        return self.rows[:, start + index * len(names) + names.index(field)]

    def energy(self, field: str) -> np.ndarray:
        """An energy of the whole run over time, from the end of the row."""
        names = [name for name, _, _ in _core.run_fields]
        return self.rows[:, self.rows.shape[1] - len(names) + names.index(f"energy_{field}")]

    def energy_residual(self) -> np.ndarray:
        """Work put in less what became of it [J]."""
        stored = self.energy("kinetic") + self.energy("gravity") + self.energy("elements")
        put_in = self.energy("work_of_drive") + self.energy("work_of_torque")
        heat = sum(self.energy(f"dissipated_{where}") for where in ("elements", "normal", "creep"))
        return put_in - heat - self.energy("stored_contacts") - (stored - stored[0])
