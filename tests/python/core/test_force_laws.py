"""Laws of elements by name: the configuration and the core know the same ones, with the same parameters."""

from __future__ import annotations

from typing import Any, get_args

import pytest
from pydantic import ValidationError

from rollerrig import _core
from rollerrig.assembly.laws import direction_law
from rollerrig.assembly.model import AssembledModel
from rollerrig.config import AngularSupport, LinearSupport, load_case
from rollerrig.config.schema.base import Table
from rollerrig.config.schema.vehicle import AngularLaw, AngularSeriesDamper, LinearLaw, SeriesDamper


def parameters(law: type[Table], key: str) -> set[str]:
    """Of the law that a key asks for: those of its table, or the key itself."""
    kinds = (law.model_fields[key].annotation, *get_args(law.model_fields[key].annotation))
    tables = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Table)]
    return set(tables[0].model_fields) if tables else {key}


@pytest.mark.parametrize("law", [LinearLaw, AngularLaw])
def test_configuration_and_core_agree_on_names_and_parameters(law: type[Table]) -> None:
    assert law.model_fields.keys() - {"preload"} == set(_core.force_laws)
    for key, made in _core.force_laws.items():
        assert parameters(law, key) == set(made.fields), key


@pytest.mark.parametrize("support", [LinearSupport, AngularSupport])
def test_supports_are_laws_of_elements(support: type[Table]) -> None:
    assert support.model_fields.keys() <= set(_core.force_laws)


def values(law: Any) -> tuple[str, dict[str, Any]]:
    return type(law).__name__, {name: getattr(law, name) for name in type(law).fields}


def test_what_is_given_reaches_the_core() -> None:
    law = LinearLaw.model_validate(
        {
            "table": [[-0.1, -5.0], [0.1, 7.0]],
            "damping_table": [[-1.0, -2.0], [1.0, 3.0]],
            "damper": {"damping": 40.0, "series_stiffness": 600.0},
            "preload": 5.0,
        }
    )
    made = direction_law(law, 100.0)
    assert made.preload == 95.0
    assert [values(one) for one in made.laws] == [
        ("TableForceLaw", {"table": [[-0.1, -5.0], [0.1, 7.0]]}),
        ("DampingTableForceLaw", {"damping_table": [[-1.0, -2.0], [1.0, 3.0]]}),
        ("DamperForceLaw", {"damping": 40.0, "series_stiffness": 600.0}),
    ]
    linear = direction_law(LinearLaw(stiffness=3.0, damping=0.0), 0.0)
    assert [values(one) for one in linear.laws] == [("StiffnessForceLaw", {"stiffness": 3.0})]
    assert not direction_law(None, 0.0).laws


@pytest.mark.parametrize("damper", [SeriesDamper, AngularSeriesDamper])
def test_a_damper_that_gives_way_within_a_picosecond_is_refused(damper: type[Table]) -> None:
    damper.model_validate({"damping": 1.1e-3, "series_stiffness": 1e9})
    with pytest.raises(ValidationError, match=r"at least 0\.001"):
        damper.model_validate({"damping": 0.9e-3, "series_stiffness": 1e9})


def test_the_core_refuses_such_a_damper_too() -> None:
    parts = AssembledModel(load_case("wheelset_rollers")).parts
    laws = [_core.DirectionLaw(preload=0.0, laws=[_core.force_laws["damper"](damping=1.0, series_stiffness=1e13)])]
    laws += [_core.DirectionLaw(preload=0.0, laws=[])] * 5
    element = _core.ForceElement(body_a=0, body_b=1, point_on_b=(0.0, 0.0, 0.0), law=laws, clamped=False)
    with pytest.raises(ValueError, match="stiffness over damping of its inner node must be at most 1e12"):
        _core.model_of(_core.ModelParts(**parts | {"elements": [element]}))
