"""A case at another scale: every value of every table times the factor of its unit.

    Case, Similitude, what stays as it is -> [scale_case] -> Case of the model, with the table [similitude]

The units are those of the configuration itself (`Quantity`): a new key is scaled without a line here. What a unit does not tell
is in SPECIAL; a test walks all tables and fails where a number has no unit.
"""

from collections.abc import Callable, Iterable, Mapping
from types import UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel

from rollerrig.config import Case, ConfigError, ConfigProblem, Rig, case_from_toml
from rollerrig.config.errors import nearest, one_of, show_value
from rollerrig.config.schema.actuators import Controller, Motor
from rollerrig.config.schema.adhesion import Adhesion
from rollerrig.config.schema.base import quantity_of
from rollerrig.config.schema.brakes import ElectrodynamicBrake, ReservoirAir, Sanding
from rollerrig.config.schema.case import KEPT, Contact, ScaledFrom, SupportChoice, TimeSettings, VehicleChoice
from rollerrig.config.schema.contact import Material
from rollerrig.config.schema.profile import ProfileSpec
from rollerrig.config.schema.track import Deviation
from rollerrig.config.validate.check_actuators import simulated_axles
from rollerrig.config.validate.messages import alternatives
from rollerrig.similitude.factors import Similitude, factors_in

M = TypeVar("M", bound=BaseModel)


class NoUnitError(TypeError):
    """A number of the configuration has no unit: nobody can say how it scales."""


def scale_case(
    case: Case,
    factors: Similitude,
    *,
    strategy: str,
    keep: Iterable[str] = ("gravity", "material"),
    changes: Mapping[str, object] | None = None,
) -> Case:
    """The model of a full-scale rig.

    Args:
        case: of a rig, at full scale.
        factors: full/model.
        strategy: its name, for the record.
        keep: names of KEPT that stay as they are at full scale; none of them: ideal similitude, which reproduces the
            full-scale case exactly.
        changes: what the model has of its own, at its own scale, by dotted key as in `Case.with_changes`.

    Raises:
        ConfigError: the case is none of a rig or scaled already, a name in `keep` is unknown, or the model is not allowed,
            e.g. for rollers that are too small.
    """
    kept = tuple(dict.fromkeys(keep))
    _check(case, kept)
    scaled = _scaled(case, factors, SPECIAL | _exceptions(kept))
    record = ScaledFrom(
        case=case.name,
        strategy=strategy,  # type: ignore[arg-type]
        length=factors.length,
        time=factors.time,
        density=factors.density,
        keep=kept,  # type: ignore[arg-type]
    )
    name = f"{case.name}_{strategy}"
    description = f"{case.description} (1:{factors.length:g} model, {strategy})".strip()
    update: dict[str, Any] = {"name": name, "description": description, "similitude": record}
    if "clock" in kept:
        step = case.time.sampling_step  # which stays as it is
        own = {"output_step": max(1, round(scaled.time.output_step / step)) * step}
        update["time"] = scaled.time.model_copy(update=own)
    model = scaled.model_copy(update=update)
    checked = case_from_toml(model.to_toml(), name, allow_code=True)
    return checked.with_changes(changes) if changes else checked


def scaled_table(table: M, factors: Similitude) -> M:
    """A table of full-scale numbers at the scale of a model."""
    return _scaled(table, factors, SPECIAL)


def factors_of(case: Case) -> Similitude:
    """The factors in a scaled case.

    Raises:
        ConfigError: it has none.
    """
    return factors_in(case.similitude, case.name)


def _check(case: Case, kept: tuple[str, ...]) -> None:
    problems = simulated_axles(case, "a scaled rig")
    if case.similitude is not None:
        allowed = f"allowed: a full-scale case; this one is a model of {case.similitude.case} already"
        problems.append(ConfigProblem(case.name, "similitude", "a table", allowed))
    if not isinstance(case.support.data, Rig):
        problems.append(ConfigProblem(case.name, "support", "a track", "allowed: rollers; a scaled rig has no track"))
    for name in kept:
        if name not in KEPT:
            problems.append(ConfigProblem("similitude", "keep", show_value(name), one_of(KEPT), nearest(name, KEPT)))
    if problems:
        raise ConfigError(problems)


# ---------------------------------------------------------------------------------------------------- exceptions

Exceptions = dict[tuple[type[BaseModel], str], Callable[[Any, Similitude], Any]]


def _exceptions(kept: tuple[str, ...]) -> Exceptions:
    """Fields that stay as they are because a real model cannot, or does not, scale them."""
    fields: dict[str, tuple[tuple[type[BaseModel], str], ...]] = {
        "gravity": ((Case, "gravity"),),
        "material": ((Material, "young_modulus"), (Material, "shear_modulus"), (Contact, "friction")),
        "clock": (
            *((ReservoirAir, key) for key in ("opening_time", "closing_time", "least_pulse")),
            (ElectrodynamicBrake, "blending_delay"),
            (Sanding, "delay"),
            (Controller, "sample_time"),
            (Controller, "delay"),
            (TimeSettings, "sampling_step"),
        ),
        "drives": ((Motor, "bandwidth"),),
    }
    return {field: lambda value, _factors: value for name in kept for field in fields[name]}


SPECIAL: Exceptions = {
    (TimeSettings, "absolute_tolerance"): lambda value, factors: value / factors.length  # of lengths and angles alike
}
"""Fields of which the unit does not say how they scale."""


# ---------------------------------------------------------------------------------------------------- the walk


def _scaled(table: M, factors: Similitude, exceptions: Exceptions) -> M:
    """A copy of a table at model scale."""
    if isinstance(table, ProfileSpec | Deviation):  # given by drawing, spectrum or file: only its size changes
        size = {"length_scale": table.length_scale / factors.length}
        return table.model_copy(update=size)  # type: ignore[return-value]
    update: dict[str, Any] = {}
    for name, field in type(table).model_fields.items():
        value = getattr(table, name)
        rule = next((exceptions[c, name] for c in type(table).__mro__ if (c, name) in exceptions), None)
        if rule is not None:
            update[name] = rule(value, factors)
        else:
            where = f"{type(table).__name__}.{name}"
            annotation = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
            update[name] = _value(value, annotation, factors, exceptions, where)
    if isinstance(table, Adhesion):
        update["blend"] = table.blend / (factors.time if table.over_time else factors.length)
        update["recovery_constant"] = table.recovery_constant / factors.factor(table.recovery_unit)
    if isinstance(table, VehicleChoice | SupportChoice):  # after loading `data` holds everything
        update["use"] = None
    return table.model_copy(update=update)


def _value(value: Any, annotation: Any, factors: Similitude, exceptions: Exceptions, where: str) -> Any:
    """One value, list or table, with the units that its annotation names."""
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, BaseModel):
        return _scaled(value, factors, exceptions)
    own = own_quantity(annotation)
    if own is not None and isinstance(value, int | float):
        return value / factors.factor(own)
    if isinstance(value, int):  # a count
        return value
    inner = inner_annotations(annotation)
    if isinstance(value, tuple):
        kinds = inner[:1] * len(value) if len(inner) == 2 and inner[1] is Ellipsis else inner
        if len(kinds) != len(value):
            raise NoUnitError(f"{where}: {annotation} does not say the unit of each number")
        return tuple(_value(v, kind, factors, exceptions, where) for v, kind in zip(value, kinds, strict=True))
    if isinstance(value, Mapping):
        return {key: _value(item, (inner or (None,))[-1], factors, exceptions, where) for key, item in value.items()}
    raise NoUnitError(f"{where}: a number without a unit")


def own_quantity(annotation: Any) -> str | None:
    """Unit of an annotation that is one number, None if it is anything else."""
    if get_origin(annotation) in (Union, UnionType):
        return next((unit for part in get_args(annotation) if (unit := own_quantity(part)) is not None), None)
    if get_origin(annotation) is Annotated and get_origin(get_args(annotation)[0]) is not tuple:
        quantity = quantity_of(None, annotation.__metadata__)
        return quantity.unit if quantity else own_quantity(get_args(annotation)[0])
    return None


def inner_annotations(annotation: Any) -> tuple[Any, ...]:
    """Annotations of the items of a list or table of numbers; () if it is none."""
    return next((get_args(one) for one in alternatives(annotation) if get_origin(one) in (tuple, dict)), ())
