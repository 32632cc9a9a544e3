"""What a case can name is what the core has, parameter by parameter."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, get_args

import pytest
from pydantic import BaseModel

import rollerrig as rr
from rollerrig import _core
from rollerrig.assembly.actuators import friction_brake, pneumatics
from rollerrig.assembly.laws import part_of
from rollerrig.assembly.model import assemble
from rollerrig.config import Brake, Case, Encoder, ForceSensor, Motor, RigControl, Sensors
from rollerrig.config.schema.actuators import AnySlideProtection, SlipSearch
from rollerrig.config.schema.brakes import (
    MOST_AXLES,
    AnyAir,
    AnyElectrodynamicBrake,
    AnySandingStart,
    AnyTrackBrake,
    CylinderPipe,
    Sanding,
    Train,
)
from rollerrig.config.schema.contact import kinds
from rollerrig.config.schema.rig_control import AnyEstimator, AnyFeedback, AnySpeedSensor, Assumed, Protection
from rollerrig.config.schema.units import Quantity

TIMING = {"sample_time", "delay", "user", "fmu"}
BLENDING = {"axles", *_core.ElectrodynamicBrake.fields}
FAMILIES = {
    "airs": (_core.airs, AnyAir, {"axles_per_reservoir"}),
    "electrodynamic_brakes": (_core.electrodynamic_brakes, AnyElectrodynamicBrake, BLENDING),
    "track_brakes": (_core.track_brakes, AnyTrackBrake, {"demand", "delay", "rise_time", "release_speed"}),
    "sanding_starts": (_core.sanding_starts, AnySandingStart, set()),
    "estimators": (_core.estimators, AnyEstimator, {"torque"}),
    "speed_sensors": (_core.speed_sensors, AnySpeedSensor, set()),
    "slide_protections": (_core.slide_protections, AnySlideProtection, TIMING | set(_core.SlideProtection.fields)),
    "feedbacks": (_core.feedbacks, AnyFeedback, {"largest"}),
}
"""Registry, the tables that choose from it, and what of a table is not the law's."""


SAME = {("Hz", "rad/s"), ("1", "N or N m")}
"""Units of a key and of the number in the core that differ: frequencies, and readings of a force or a torque."""


def units_agree(table: type[BaseModel], units: Mapping[str, str]) -> bool:
    """Whether the keys of a table have the units of the core's fields of the same names."""
    for name, info in table.model_fields.items():
        annotated = [info.metadata, *(getattr(one, "__metadata__", ()) for one in get_args(info.annotation))]
        keys = {one.unit for metadata in annotated for one in metadata if isinstance(one, Quantity)}
        core = units.get(name, "")
        if core and any(key != core and (key, core) not in SAME for key in keys):
            raise AssertionError(f"{table.__name__}.{name}: {keys} in a case, {core} in the core")
    return True


@pytest.mark.parametrize("family", FAMILIES)
def test_a_case_can_name_exactly_the_laws_of_the_core(family: str) -> None:
    registry, tables, _ = FAMILIES[family]
    assert kinds(tables) == tuple(registry)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_table_has_exactly_the_parameters_of_its_law(family: str) -> None:
    registry, tables, others = FAMILIES[family]
    for name, table in zip(kinds(tables), get_args(get_args(tables)[0]), strict=True):
        assert set(table.model_fields) - {"kind"} - others == set(registry[name].fields) - others
        assert units_agree(table, registry[name].fields)


def test_each_controller_of_the_core_is_a_table_of_the_case() -> None:
    for name, law in _core.controllers.items():
        table = get_args(Case.model_fields[name].annotation)[0]
        if name == "slide_protection":  # one of several laws
            continue
        assert set(table.model_fields) >= TIMING
        if name not in ("rig_control", "brake_unit"):  # which are made of parts, those of [brake] the second one
            assert set(table.model_fields) - TIMING | {"wheel_radius"} == set(law.fields)
            assert units_agree(table, law.fields)


OF_THE_VEHICLE = {"wheel_radius", "gravity", "position", "load_transfer", "static_load", "wheelset_inertia"}
OF_THE_TRAIN = OF_THE_VEHICLE | {"axles", "brake_signal_speed"}
MADE = {"train", "commanded_torque", "measured_loads", "rail", "largest"}
OF_THE_RIG = TIMING | MADE | {"motor", "load_transfer", "loads", "protection"}


@pytest.mark.parametrize(
    ("struct", "table", "others"),
    [
        (_core.Motor, Motor, {"rotor_inertia", "gear_ratio"}),
        (_core.ForceSensor, ForceSensor, set()),
        (_core.Sensors, Sensors, set()),
        (_core.RollerProtection, Protection, set()),
        (_core.AssumedParameters, Assumed, set()),
        (_core.CylinderPipe, CylinderPipe, {"axles_per_relay_valve"}),
        (_core.Sanding, Sanding, {"axles", "saturation", "rail"}),
        (_core.SlipSearch, SlipSearch, {"axle_inertia"}),
        (_core.VirtualTrain, Train, OF_THE_TRAIN),
        (_core.RigControl, RigControl, OF_THE_RIG),
    ],
)
def test_tables_and_structs_have_the_same_fields(struct: Any, table: type[BaseModel], others: set[str]) -> None:
    assert set(table.model_fields) ^ set(struct.fields) == others
    assert units_agree(table, struct.fields)


def test_a_brake_s_table_has_the_fields_of_its_parts() -> None:
    parts = _core.FrictionBrake.fields | _core.ControlValve.fields
    assert set(Brake.model_fields) - {"demand", "by_traction_motors", "air", "electrodynamic"} == set(parts)
    assert units_agree(Brake, parts)


def test_every_number_of_the_core_has_a_unit_and_a_meaning() -> None:
    kalman = _core.estimators["kalman"]
    assert kalman.force_change.__doc__ == "standard deviation of the contact force's change over 1 s [N]"
    structs = [
        one for one in vars(_core).values() if isinstance(one, type) and isinstance(getattr(one, "fields", None), dict)
    ]
    assert len(structs) > 80
    for struct in structs:
        for name, unit in struct.fields.items():
            doc = getattr(struct, name).__doc__ or ""
            if unit:
                assert re.fullmatch(rf"\S.{{3,}} \[{re.escape(unit)}\]", doc), (struct, name)
            else:  # nanobind's own: the type
                assert doc.startswith("(self) -> "), (struct, name)
                assert "float" not in doc, (struct, name)


def test_the_configuration_allows_as_many_axles_as_the_core_has_room_for() -> None:
    assert _core.most_axles == MOST_AXLES


def test_a_parameter_that_is_missing_or_too_many_is_an_error() -> None:
    made = part_of(_core.Encoder, Encoder(counts=100, window=3))
    assert (made.counts, made.jitter, made.window) == (100.0, 0.0, 3)
    with pytest.raises(TypeError):
        part_of(_core.Encoder, Encoder(), windw=3)
    with pytest.raises(TypeError):
        _core.Encoder(counts=100.0, jitter=0.0)


def test_too_many_axles_are_refused_by_number() -> None:
    setup = _setup(axles=33)
    with pytest.raises(ValueError, match="at most 32 axles have sensors and actuators, not 33"):
        _core.Simulation(assemble(rr.load_case("wheelset_rollers")).core, setup)


def _setup(axles: int) -> _core.MechatronicSetup:
    none = {"wheelset": 0} | dict.fromkeys(("axle_torque", "brake", "roller", "roller_torque"), -1)
    drive = part_of(_core.Motor, Motor(), envelope=[])
    encoder = part_of(_core.Encoder, Encoder())
    brake = Brake(demand=((0.0, 0.0), (1.0, 0.0)))
    return _core.MechatronicSetup(
        step=1e-3,
        speed=10.0,
        stop_speed=1.0,
        axles=[
            _core.AxleParts(
                **none, contacts=[-1, -1], electrodynamic=False, has_brake=False, has_motor=False, sands=False
            )
            for _ in range(axles)
        ],
        actuators=_core.Actuators(
            brake=friction_brake(brake),
            pneumatics=pneumatics(brake),
            by_traction_motors=False,
            electrodynamic=None,
            track_brake=None,
            brake_demand=[],
            motor=drive,
            torque_demand=[],
            roller_drive=drive,
        ),
        sensors=_core.Sensors(
            axles=encoder,
            rollers=encoder,
            vehicle=None,
            roller_torque=None,
            axle_load=part_of(_core.ForceSensor, ForceSensor()),
            seed=1,
        ),
        controllers=[],
        protection=_core.RollerProtection(slip=1.0, time=0.2),
        frame=_core.TravellingFrame(train_mass=0.0, fixed_mass=0.0),
        rail_cell=0.05,
        energy_width=0.0,
        wheel_memory=0.0,
        sanding=None,
        simulated=_core.SimulatedAxles(
            wheelset_inertia=0.0,
            wheel_radius=0.0,
            gradient_force=0.0,
            static_load=[],
            load_transfer=[],
            position=[],
        ),
        rail=None,
        brake_delay=[],
        reservoir=[],
        relay_valve=[],
    )
