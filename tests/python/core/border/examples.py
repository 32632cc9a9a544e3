"""Valid objects of rollerrig._core and valid calls of everything in it, for the abuses to spoil.

shipped cases -> parts of models, setups -> [examples] -> calls by name, whole models leaf by leaf
"""

from __future__ import annotations

import dataclasses
import re
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from recipes import recipes

import rollerrig as rr
from rollerrig import _core
from rollerrig.assembly.actuators import electrodynamic_brake, pneumatics, track_brake
from rollerrig.assembly.creep_table import shipped_table
from rollerrig.assembly.laws import part_of
from rollerrig.assembly.model import assemble
from rollerrig.assembly.model_parts import no_parts
from rollerrig.config import Brake
from rollerrig.config.schema.actuators import TableSlideProtection
from rollerrig.config.schema.brakes import ConstantPowerBrake, MagneticTrackBrake, ReservoirAir
from rollerrig.simulation.mechatronics import slide_protection

Arguments = dict[str, Any]


@dataclasses.dataclass(frozen=True)
class Call:
    """A function of the arguments, and arguments with which it works."""

    function: Callable[..., Any]
    arguments: Arguments


def parameters(function: Any) -> list[str]:
    """Names of the parameters that a bound function documents, without self."""
    signature = function.__nb_signature__[0][0]
    depth, flat = 0, ""
    for c in signature[signature.index("(") + 1 :]:
        depth += c in "([" or -(c in ")]")
        if depth < 0:
            break
        flat += c if depth == 0 else ""
    return [name for name in re.findall(r"(\w+):", flat) if name != "self"]


def described(value: Any) -> bool:
    """Whether an object of the core can be made anew from its own attributes."""
    own = type(value)
    return (
        own.__module__ == _core.__name__
        and own is not _core.AssembledModel  # its numbers are spoiled in whole models
        and hasattr(own.__init__, "__nb_signature__")
        and all(isinstance(getattr(own, name, None), property) for name in parameters(own.__init__))
    )


def fields(value: Any) -> Arguments:
    """The arguments that make a described object."""
    return {name: getattr(value, name) for name in parameters(type(value).__init__)}


# ---------------------------------------------------------------------------------------------------- calls


SETTINGS: Arguments = {
    "method": "rodas4", "step": 0.0, "relative_tolerance": 1e-4, "absolute_tolerance": [1e-6], "initial_step": 0.0,
    "maximum_step": 0.01, "final_time": 0.02, "output_step": 0.005, "breakpoints": [0.013],
}  # fmt: skip
"""Of a run by rodas4 over 20 ms."""


def options(**changes: Any) -> Any:
    """Those settings, with some of them changed."""
    return _core.Options(**SETTINGS | changes)


def run_fully(simulation: Any, state: np.ndarray, *, t0: float = 0.0, **changes: Any) -> Any:
    """A whole short run."""
    simulation.start(options=options(**changes), t0=t0, x0=state)
    return simulation.advance(0.02, np.zeros(10), np.zeros((10, simulation.width)), 0)


class Examples:
    """Valid calls of every class, method, attribute and function of the core, by name."""

    def __init__(self) -> None:
        self.recipes = recipes()
        self.models = {name: _core.model_of(recipe.parts) for name, recipe in self.recipes.items()}
        self.plain = assemble(rr.load_case("wheelset_rollers")).core
        self.plain_state = _core.Simulation(self.plain).equilibrium(30.0, 0.0, [])["x"]

    def simulation(self, started: bool = False) -> Any:
        """A fresh simulation of one wheelset."""
        simulation = _core.Simulation(self.plain)
        if started:
            simulation.start(options(), 0.0, self.plain_state)
        return simulation

    def waiting(self) -> Any:
        """A simulation whose external controller waits for an answer."""
        recipe = self.recipes["brake"]
        parts = fields(recipe.setup)
        parts["controllers"] = [
            _core.SampledController(
                sampling=_core.Sampling(every=c.sampling.every, delay=c.sampling.delay, external=True),
                controller=c.controller,
            )
            for c in recipe.setup.controllers
        ]
        simulation = _core.Simulation(self.models["brake"], _core.MechatronicSetup(**parts))
        simulation.start(options(), 0.0, recipe.state)
        simulation.advance(0.02, np.zeros(10), np.zeros((10, simulation.width)), 0)
        assert simulation.waits_for("slide_protection")
        return simulation

    def objects(self) -> dict[str, Any]:
        """One described object of each class, out of the models."""
        found: dict[str, Any] = {}

        def walk(value: Any) -> None:
            if isinstance(value, list | tuple):
                for item in value:
                    walk(item)
            elif described(value):
                found.setdefault(type(value).__name__, value)
                for item in fields(value).values():
                    walk(item)

        for recipe in self.recipes.values():
            walk(recipe.parts)
            walk(recipe.setup)
        walk(self._rarely_used())
        found["ModelParts"] = _core.ModelParts(
            **no_parts(9.81, found["ContactLaws"])
        )  # the rest is spoiled in whole models
        return found

    def _rarely_used(self) -> list[Any]:
        """Objects that the recipes do without."""
        constant = _core.Constant(mu_0=0.3)
        motor = ConstantPowerBrake()
        magnets = MagneticTrackBrake(demand=((0.0, 0.0), (1.0, 1.0)))
        eddies = _core.EddyCurrentTrackBrake(largest_force=1e4, critical_speed=20.0)
        return [
            electrodynamic_brake(Brake(demand=((0.0, 0.0), (1.0, 3e5)), electrodynamic=motor), 0.46),
            _core.TableBrake(forces=[(1.0, 0.0), (3.0, 1e4)]),
            track_brake(magnets, 1),
            eddies,
            options(),
            _core.Disturbance(body=1, coordinate=1, offset=1e-3),
            _core.BodyTrackBrake(body=0, brake=track_brake(magnets, 1)),
            _core.Sanding(start=_core.OnSlideSanding(), flow=0.01, delay=0.5, run_on=1.0, least_speed=2.0, kept=0.7),
            _core.FromDistanceSanding(begin=10.0, end=20.0),
            _core.FromTimeSanding(begin=1.0, end=2.0),
            _core.KalkerSaturated(saturate_spin_moment=True),
            _core.KalkerLinear(),
            _core.Coefficients(f11=1e7, f22=9e6, f23=1.5e4, f33=20.0, saturation=True),
            _core.Fastsim(),
            _core.Hertz(merging_criterion=0.01),
            _core.ModifiedFastsim(k_0=0.7, k_inf=0.1, beta=0.8),
            _core.Polach(k_A=0.8, k_S=0.3),
            _core.Strips(),
            _core.Table(table=shipped_table()),
            _core.StripTheory(table=shipped_table()),
            constant,
            _core.Falling(mu_0=0.3, A=0.4, B=0.6),
            _core.TableForceLaw(table=[(-0.01, -1e4), (0.0, 0.0), (0.01, 1e4)]),
            _core.DampingTableForceLaw(damping_table=[(-1.0, -1e4), (0.0, 0.0), (1.0, 1e4)]),
            _core.DampingForceLaw(damping=1e4),
            _core.StiffnessForceLaw(stiffness=1e6),
            _core.DamperForceLaw(damping=1e4, series_stiffness=1e6),
            part_of(
                _core.ReservoirAir,
                ReservoirAir(kind="reservoir", reservoir_pressure=8e5),
                pipe=_core.CylinderPipe(length=4.0, diameter=0.02, relay_conductance=5e-7),
            ),
            _core.PulsePeriod(teeth=100.0, pitch_error=0.01, averaging_time=5e-3, timeout=0.3, clock=1e6),
            _core.PulseFrequency(teeth=100.0, pitch_error=0.01, gate_time=0.1),
            slide_protection(TableSlideProtection(kind="threshold_table"), 0.46).law,
            _core.BrakeUnit(
                pneumatics=pneumatics(Brake(demand=((0.0, 0.0), (1.0, 1e5)))), reservoir=[0, 0], relay_valve=[0, 0]
            ),
            _core.ForceSensor(bandwidth=100.0, noise=10.0, resolution=1.0, range=1e5),
            _core.AxleTorque(
                wheelset=0, reaction=-1, torque=[(0.0, 0.0), (1.0, 100.0)], link=0.0, gear_ratio=1.0, rotor_inertia=0.0
            ),
            _core.ObserverEstimator(bandwidth=60.0, damping_ratio=0.7),
            _core.FilteredDerivativeEstimator(bandwidth=60.0),
            _core.KalmanEstimator(bandwidth=60.0, speed_noise=1e-3, force_change=1e5, torque_change=1e5),
            _core.ExactEstimator(),
            _core.ProportionalIntegralFeedback(bandwidth=10.0, damping_ratio=0.7, proportional=100.0, integral=10.0),
            _core.SlidingModeFeedback(switching=100.0, boundary_layer=0.1),
            _core.NoneFeedback(),
            _core.EstimatedAxleTorque(),
            _core.KnownAxleTorque(bandwidth=6.0, brake_friction=1.1),
            _core.ExtrapolatedAxleTorque(ahead=8e-3, bandwidth=250.0),
            _core.DirectDriveCommand(),
            _core.LeadDriveCommand(ahead=4e-3),
            _core.TorqueLoopDriveCommand(gain=2.0),
            _core.StandingBody(mass=1e3, position=(0.0, 0.0, 1.0), on_wheels=False),
            _core.LoadSpring(body_a=1, body_b=0, point=(1.0, 1.0, 1.0)),
        ]

    def calls(self) -> dict[str, Call]:
        """Every constructor, method and function with arguments that work."""
        objects = self.objects()
        found = {name: Call(type(value), fields(value)) for name, value in objects.items()}
        found |= (
            self._law_calls(objects) | self._model_calls(objects) | self._contact_calls() | self._simulation_calls()
        )
        found |= self._plant_calls() | self._server_calls()
        return found

    def _law_calls(self, objects: dict[str, Any]) -> dict[str, Call]:
        table = shipped_table()
        coefficients = np.zeros(4 * 4 * 4 * 5 * 4, dtype=np.float32)
        creepage = np.array([[1e-3, 0.0, 0.0], [2e-3, 1e-3, 0.1]])
        assumed, period = objects["AssumedParameters"], 1e-3
        patch = {"a": 6e-3, "b": 4e-3, "load": 5e4, "friction": 0.3, "shear_modulus": 8e10, "poisson_ratio": 0.28}
        reference = _core.RollingReference(1.5, 0.28, 0.5)
        rows = np.array([[-0.3, 0.0, 0.5, 1.0], [0.3, 0.1, 0.6, 1.2]])
        brake = objects["FrictionBrake"]
        return {
            "CreepTable.of": Call(
                _core.CreepTable.of,
                {"log_aspect_end": 2.3, "rho_0": 1.5, "aspects": 1, "cells": (1, 1, 1), "coefficients": coefficients},
            ),
            "hertz_ellipse": Call(
                _core.hertz_ellipse, {"load": 5e4, "d1": 2.0, "d2": 3.0, "shear_modulus": 8e10, "poisson_ratio": 0.28}
            ),
            "kalker_coefficients": Call(_core.kalker_coefficients, {"a_over_b": 1.5, "poisson_ratio": 0.28}),
            "kalker_stiffness": Call(
                _core.kalker_stiffness, {"a": 6e-3, "b": 4e-3, "shear_modulus": 8e10, "poisson_ratio": 0.28}
            ),
            "creepage_units": Call(_core.creepage_units, {"a_over_b": 1.5, "poisson_ratio": 0.28}),
            "friction_at": Call(_core.friction_at, {"law": objects["Falling"], "slip": np.linspace(0.0, 5.0, 4)}),
            "creep_forces": Call(
                _core.creep_forces,
                {"creepage": creepage, **patch, "law": _core.Table(table=table), "direction": 1.0, "reduction": None},
            ),
            "creep_forces, polach": Call(
                _core.creep_forces,
                {"creepage": creepage, **patch, "law": objects["Polach"], "direction": 1.0, "reduction": (0.8, 0.4)},
            ),
            "creep_forces, fastsim": Call(
                _core.creep_forces,
                {"creepage": creepage, **patch, "law": objects["Fastsim"], "direction": 1.0, "reduction": None},
            ),
            "rail_friction": Call(
                _core.rail_friction, {"map": objects["AdhesionMap"], "at": np.linspace(0.0, 50.0, 4)}
            ),
            "RollingReference": Call(_core.RollingReference, {"a_over_b": 1.5, "poisson_ratio": 0.28, "fineness": 0.5}),
            "RollingReference.on_rows": Call(
                _core.RollingReference.on_rows,
                {
                    "rows": rows,
                    "spacing": 0.6,
                    "poisson_ratio": 0.28,
                    "elements": 4,
                },
            ),
            "RollingReference.solve": Call(reference.solve, {"creepage": np.array([[0.5, 0.1, 0.2]])}),
            "RollingReference.solve_rows": Call(
                _core.RollingReference.on_rows(rows=rows, spacing=0.6, poisson_ratio=0.28, elements=4).solve_rows,
                {"creepage": np.array([[0.5, 0.1, 0.2], [0.4, 0.1, 0.2]])},
            ),
            "reflected_inertia": Call(_core.reflected_inertia, {"rotor_inertia": 2.0, "gear_ratio": 3.0}),
            "FrictionBrake.torque": Call(brake.torque, {"cylinder_pressure": 3e5, "axle_speed": 60.0}),
            "ElectrodynamicBrake.largest": Call(objects["ElectrodynamicBrake"].largest, {"axle_speed": 60.0}),
            "TrackBrake.force": Call(objects["TrackBrake"].force, {"speed": 30.0}),
            "estimator_response": Call(
                _core.estimator_response,
                {"estimator": objects["ObserverEstimator"], "assumed": assumed, "period": period},
            ),
            "estimate": Call(
                _core.estimate,
                {
                    "estimator": objects["KalmanEstimator"],
                    "assumed": assumed,
                    "period": period,
                    "samples": np.ones((3, 3)),
                },
            ),
            "feedback_gains": Call(
                _core.feedback_gains, {"feedback": objects["ProportionalIntegralFeedback"], "assumed": assumed}
            ),
            "equivalent_patch": Call(_core.equivalent_patch, {"load": 5e4, "a": [6e-3, 3e-3], "b": [4e-3, 2e-3]}),
            "torque_lag": Call(
                _core.torque_lag, {"motor": objects["Motor"], "period": period, "delay": 2e-3, "gain": 1.0}
            ),
        }

    def _model_calls(self, objects: dict[str, Any]) -> dict[str, Call]:
        bodies = [objects["StandingBody"], _core.StandingBody(mass=1.0, position=(0.0, 0.0, 0.0), on_wheels=True)]
        return {
            "model_of": Call(_core.model_of, {"parts": objects["ModelParts"]}),
            "Model.with_speed": Call(self.plain.with_speed, {"speed": [(0.0, 30.0), (1.0, 20.0)]}),
            "coasting_model": Call(_core.coasting_model, {"model": self.models["brake"]}),
            "starting_state": Call(
                _core.starting_state, {"model": self.plain, "t": 0.0, "disturbances": [objects["Disturbance"]]}
            ),
            "static_loads": Call(
                _core.static_loads, {"bodies": bodies, "springs": [objects["LoadSpring"]], "gravity": 9.81}
            ),
        }

    def _contact_calls(self) -> dict[str, Call]:
        contact = _core.StaticWheelsetContact(self.plain, 0, 1)
        place = {"x": 0.0, "y": 1e-3, "yaw": 1e-3, "roll": 0.0}
        at_height = {"x": 0.0, "y": 1e-3, "z": -1e-4, "yaw": 1e-3, "roll": 0.0, "right": True}
        return {
            "StaticWheelsetContact": Call(_core.StaticWheelsetContact, {"model": self.plain, "left": 0, "right": 1}),
            "StaticWheelsetContact.solve": Call(contact.solve, place | {"load": 1e5, "free_to_roll": True}),
            "StaticWheelsetContact.touch_height": Call(contact.touch_height, place | {"right": True}),
            "StaticWheelsetContact.patches": Call(contact.patches, at_height),
            "StaticWheelsetContact.seconds_per_contact": Call(
                contact.seconds_per_contact, at_height | {"wheels": 2, "repeats": 2}
            ),
            "StaticWheelsetContact.minima": Call(contact.minima, at_height | {"reach": 1e-3}),
        }

    def _assembled(self) -> Arguments:
        """Of an assembled model with brakes."""
        brake = self.recipes["brake"]
        bodies = [f"body_{i}" for i in range(len(brake.parts.bodies))]
        elements = [f"element_{i}" for i in range(len(brake.parts.elements))]
        names = _core.PartNames(bodies=bodies, elements=elements, axles=["axle_1", "axle_2"])
        start = {"options": options(output_step=0.0), "t0": 0.0, "x0": brake.state.tolist()}
        given = {"name": "brake", "model": self.models["brake"], "setup": brake.setup, "names": names}
        return (
            given
            | start
            | {"disturbances": [_core.Disturbance(body=brake.setup.axles[0].wheelset, coordinate=1, offset=0.0)]}
        )

    def _server_calls(self) -> dict[str, Call]:
        assembled = _core.AssembledModel(**self._assembled())
        chosen = {"inputs": [0, 1], "outputs": [_core.Plant(assembled).find("body_0.lateral")]}
        settings = {
            "period": 2e-3, "periods": 5, "session": 7, "oldest": 3, "patience": 10, "ramp": 5, "lock_step": True,
            "at_once": True, "give_up": 1.0, "spin": 1e-5, "record": True,
        }  # fmt: skip
        place = {"safe": [0.0, 0.0], "description": "{}", "address": "127.0.0.1", "port": 0}

        def run(**given: Any) -> Any:
            return _core.RigServer(**given).run()

        rig = {"assembled": assembled} | chosen
        served = rig | place | {"settings": _core.ServerSettings(**settings)}

        def after_a_run(method: str) -> Call:
            def call() -> Any:
                server = _core.RigServer(**served)
                return server.run() if method == "run" else (server.run(), getattr(server, method)())

            return Call(call, {})

        methods = ("run", "stop", "statistics", "histogram", "commands", "sensors")
        calls = {f"RigServer.{method}": after_a_run(method) for method in methods} | {
            "ServerSettings": Call(_core.ServerSettings, settings),
            "RigServer": Call(run, served),
            # short periods: a thousand more of them are an abuse, and take what they take
            "measure_rig": Call(_core.measure_rig, rig | {"period": 1e-4, "periods": 5, "repeats": 2}),
            "replay_rig": Call(_core.replay_rig, rig | {"period": 2e-3, "commands": np.zeros((5, 2))}),
            "require_real_time": Call(_core.require_real_time, {}),
        }
        if not sys.platform.startswith("linux"):  # where nothing of it can be called
            calls |= {
                name: Call(lambda: None, {}) for name in calls if name.startswith(("RigServer", "measure_", "require_"))
            }
        return calls

    def _plant_calls(self) -> dict[str, Call]:
        given = self._assembled()
        assembled = _core.AssembledModel(**given)
        a_mass = next(v.name for v in _core.Plant(assembled).variables if v.name.endswith(".mass"))

        def started(method: str) -> Callable[..., Any]:
            def call(**given: Any) -> Any:
                plant = _core.Plant(assembled)
                plant.start(final_time=1.0)
                return getattr(plant, method)(**given)

            return call

        part = {
            "name": "small", "step": 1e-3, "controller": assembled.setup.controllers[0],
            "axles": ["axle_1"], "train_speed": 20.0, "axle_speed": [43.0], "roller_speed": [27.0],
        }  # fmt: skip
        alone = _core.ControllerPart(**part)
        return {
            "ControllerPart": Call(_core.ControllerPart, part),
            "write_part": Call(_core.write_part, {"part": alone}),
            "ControllerPlant": Call(_core.ControllerPlant, {"part": alone}),
            "ControllerPlant.start": Call(lambda: _core.ControllerPlant(alone).start(), {}),
            "ControllerPlant.advance": Call(lambda **given: _core.ControllerPlant(alone).advance(**given), {"t": 0.01}),
            "ControllerPlant.set_input": Call(
                lambda **given: _core.ControllerPlant(alone).set_input(**given), {"index": 0, "value": 43.0}
            ),
            "ControllerPlant.jacobian": Call(
                lambda **given: _core.ControllerPlant(alone).jacobian(**given), {"moves": [(0, 1e-3)]}
            ),
            "ControllerPlant.get": Call(lambda **given: _core.ControllerPlant(alone).get(**given), {"index": 0}),
            "PartNames": Call(_core.PartNames, fields(given["names"])),
            "AssembledModel": Call(_core.AssembledModel, given),
            "write_model": Call(_core.write_model, {"assembled": assembled}),
            "continuous_variables": Call(_core.continuous_variables, {"assembled": assembled}),
            "model_token": Call(_core.model_token, {"content": _core.write_model(assembled)}),
            "read_model": Call(_core.read_model, {"content": _core.write_model(assembled)}),
            "Plant": Call(_core.Plant, {"assembled": assembled}),
            "Plant.find": Call(started("find"), {"name": "body_0.lateral"}),
            "Plant.start": Call(started("start"), {"final_time": 1.0}),
            "Plant.advance": Call(started("advance"), {"t": 0.02}),
            "Plant.set_input": Call(started("set_input"), {"index": 0, "value": 1e5}),
            "Plant.set_parameter": Call(
                lambda **given: _core.Plant(assembled).set_parameter(**given),
                {"index": _core.Plant(assembled).find(a_mass), "value": 1e4},
            ),
            "Plant.save": Call(started("save"), {}),
            "Plant.restore": Call(started("restore"), {"state": started("save")()}),
            "Plant.get": Call(started("get"), {"index": 0}),
            "Plant.values": Call(started("values"), {"indices": [0, 1, 10**6]}),
        }

    def _simulation_calls(self) -> dict[str, Call]:
        x, brake = self.plain_state, self.recipes["brake"]
        width = self.simulation().width
        quadratures = np.zeros(self.simulation().quadrature_count)
        states = np.stack([x, x])

        def fresh(method: str, started: bool = False) -> Callable[..., Any]:
            return lambda **given: getattr(self.simulation(started), method)(**given)

        def run(**given: Any) -> Any:
            return run_fully(self.simulation(), **given)

        def read(**given: Any) -> Any:
            simulation = self.simulation(True)
            simulation.keep_readings(**given)
            return simulation.advance(0.02, np.zeros(10), np.zeros((10, width)), 0)

        sampled_state = self.recipes["brake"].state
        sampled = SETTINGS | {"t0": 0.0}
        sampled_start = {"state": sampled_state, **sampled, "method": "rk4", "step": 1e-3}

        return {
            "Simulation": Call(_core.Simulation, {"model": self.models["brake"], "setup": brake.setup}),
            "Simulation.start": Call(run, {"state": x} | sampled),
            "Simulation.start, rk4": Call(run, {"state": x} | sampled | {"method": "rk4", "step": 1e-3}),
            "Simulation.start, dormand_prince": Call(run, {"state": x} | sampled | {"method": "dormand_prince"}),
            "Simulation.start, sampled": Call(
                lambda **given: run_fully(_core.Simulation(self.models["brake"], brake.setup), **given), sampled_start
            ),
            "Simulation.advance": Call(
                fresh("advance", started=True),
                {"t_stop": 0.02, "times": np.zeros(10), "rows": np.zeros((10, width)), "filled": 0},
            ),
            "Simulation.keep_readings": Call(
                read,
                {"every": 2, "times": np.zeros(10), "values": np.zeros((10, self.simulation().reading_width))},
            ),
            "Simulation.waits_for": Call(
                lambda **given: self.waiting().waits_for(**given), {"controller": "slide_protection"}
            ),
            "Simulation.measurement": Call(
                lambda controller: self.waiting().measurement(controller), {"controller": "slide_protection"}
            ),
            "Simulation.set_command": Call(
                lambda **given: self.waiting().set_command(**given),
                {"controller": "slide_protection", "command": [0.0, 1.0]},
            ),
            "Simulation.derivative": Call(fresh("derivative"), {"t": 0.0, "x": x}),
            "Simulation.jacobian": Call(fresh("jacobian"), {"t": 0.0, "x": x}),
            "Simulation.linear_model": Call(
                fresh("linear_model"), {"t": 0.0, "x": x, "pressure": [], "roller_torque": []}
            ),
            "Simulation.hold_speed": Call(fresh("hold_speed"), {"t": 0.0, "x": x, "pressure": []}),
            "Simulation.step_amplification": Call(
                fresh("step_amplification"), {"method": "rk4", "step": 1e-3, "t": 0.0, "x": x}
            ),
            "Simulation.equilibrium": Call(
                fresh("equilibrium"), {"speed": 30.0, "t": 0.0, "fixed": [(0, 1, 1e-3)], "near": x, "only_near": True}
            ),
            "Simulation.record": Call(fresh("record"), {"t": 0.0, "x": x, "z": quadratures}),
            "Simulation.derivatives": Call(fresh("derivatives"), {"t": 0.0, "states": states}),
            "Simulation.statistics": Call(fresh("statistics"), {}),
            "Simulation.counters": Call(fresh("counters"), {}),
            "Simulation.contact_losses": Call(fresh("contact_losses"), {}),
            "TangentRun": Call(
                self.tangent, {"directions": np.ones((len(x), 1)), "kept": [0, 1], "breakpoints": [0.01]}
            ),
            "TangentRun.advance": Call(lambda **given: self.tangent().advance(**given), {"t": 2e-3}),
            "TangentRun.take_outputs": Call(lambda: self.tangent().take_outputs(), {}),
            "status_sentence": Call(_core.status_sentence, {"status": 0}),
        }

    def tangent(self, **given: Any) -> Any:
        """Derivatives beside a run of one wheelset, by a number that two others have."""
        run, above, below = (self.simulation(started=True) for _ in range(3))
        run.start(options(method="exponential_adams", step=1e-3), 0.0, self.plain_state)
        more = {"directions": np.zeros((0, 0)), "kept": [], "breakpoints": []} | given
        return _core.TangentRun(run=run, changed=[(above, below, 1e-5, True)], **more)


def public_names() -> Iterator[str]:
    """Every constructor, method, writable attribute and function of the core."""
    for name, item in vars(_core).items():
        if name.startswith("_"):
            continue
        if isinstance(item, type):
            if hasattr(item.__init__, "__nb_signature__"):
                yield name
            for attribute, own in vars(item).items():
                writable = isinstance(own, property) and own.fset is not None
                if not attribute.startswith("_") and (writable or callable(own)):
                    yield f"{name}.{attribute}"
        elif callable(item):
            yield name
