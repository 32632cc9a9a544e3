"""modelDescription.xml: what a tool reads of an FMU before it loads its library.

"kg/m^2" -> {"kg": 1, "m": -2}
variables of a plant -> [description] -> XML of FMI 2.0 or 3.0
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from rollerrig import __version__, _core
from rollerrig.config.schema.units import base_powers

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""Names and order of the standard, FMI 2.0.4 section 2.2.2."""


def base_units(unit: str) -> dict[str, int]:
    """Powers of the base units of a unit such as 'N m', 'J/m^2' or '1', in the standard's order.

    Raises:
        ValueError: it is no unit of SI without a prefix.
    """
    size, powers = base_powers(unit)
    if size != 1.0:
        raise ValueError(f"{unit!r} is not a unit of SI without a prefix")
    return {base: powers[base] for base in BASE if base in powers}


TOOL = f"rollerrig {__version__}"
LOG = {
    "logStatusDiscard": "the run ended, or left the validity of the model: time and wheel",
    "logStatusError": "calls that were refused",
}


@dataclass(frozen=True)
class Unit:
    """What a description says of an FMU as a whole."""

    name: str  # of the case
    token: str  # of the model among the resources; the library refuses another
    final_time: float  # where the case ends [s]
    step: float  # a step at which to exchange values [s]
    sampled: bool  # whether there are sensors and controllers with a sample time
    variables: Sequence[_core.Variable]  # of the plant, in its order
    kind: str = "cs"  # 'cs', 'me' or 'both'
    # that a tool integrates, their rates, and event indicators; empty without model exchange
    states: Sequence[_core.Variable] = ()
    rates: Sequence[_core.Variable] = ()
    indicators: Sequence[_core.Variable] = ()

    @property
    def identifier(self) -> str:
        """Name of the library's file, a word of C."""
        return re.sub(r"\W", "_", self.name, flags=re.ASCII)

    @property
    def outputs(self) -> list[int]:
        """References of the outputs: 1 for the first variable of the plant; 0 is the time."""
        return [i for i, variable in enumerate(self.variables, start=1) if variable.causality == "output"]

    def behind(self, part: str) -> range:
        """References of 'states', 'rates' or 'indicators': behind the variables of the plant, in this order."""
        first = len(self.variables) + 1
        for name in ("states", "rates", "indicators"):
            count = len(getattr(self, name))
            if name == part:
                return range(first, first + count)
            first += count
        raise KeyError(part)

    @property
    def scalars(self) -> Iterator[tuple[int, _core.Variable, int | None]]:
        """Reference and variable of everything but the time, and of a rate the reference of its state."""
        state_of = dict(zip(self.behind("rates"), self.behind("states"), strict=True))
        everything = [*self.variables, *self.states, *self.rates, *self.indicators]
        for reference, variable in enumerate(everything, start=1):
            yield reference, variable, state_of.get(reference)


def number(value: float) -> str:
    """The shortest text that is read back as the same number."""
    return repr(float(value))


def model_description_2(unit: Unit) -> bytes:
    """Model description of FMI 2.0 (2.0.4, section 2.2).

    The time is none of the variables: FMI Library 2 takes its missing start for an error (its issue 21).
    """
    root = ET.Element("fmiModelDescription", fmiVersion="2.0", modelName=unit.name, guid=unit.token)
    _about(root, unit, "FMUstate", "providesDirectionalDerivative")
    if unit.kind != "cs":
        root.set("numberOfEventIndicators", str(len(unit.indicators)))
    variables = ET.SubElement(root, "ModelVariables")
    for reference, variable, state in unit.scalars:
        scalar = ET.SubElement(variables, "ScalarVariable", _heading(variable, reference))
        ET.SubElement(scalar, "Real", _value(variable, unit, reference, state))
    structure = ET.SubElement(root, "ModelStructure")
    for name, references in (
        ("Outputs", unit.outputs),
        ("Derivatives", unit.behind("rates")),
        ("InitialUnknowns", [*unit.outputs, *unit.behind("states"), *unit.behind("rates")]),
    ):
        if not references:
            continue
        unknowns = ET.SubElement(structure, name)
        for reference in references:
            ET.SubElement(unknowns, "Unknown", index=str(reference))
    return _written(root)


def model_description_3(unit: Unit) -> bytes:
    """Model description of FMI 3.0 (3.0.2, section 2.4)."""
    root = ET.Element("fmiModelDescription", fmiVersion="3.0", modelName=unit.name, instantiationToken=unit.token)
    _about(root, unit, "FMUState", "providesDirectionalDerivatives")
    variables = ET.SubElement(root, "ModelVariables")
    time = {"name": "time", "valueReference": "0", "description": "time", "causality": "independent"}
    ET.SubElement(variables, "Float64", time | {"variability": "continuous", "unit": "s"})
    for reference, variable, state in unit.scalars:
        ET.SubElement(variables, "Float64", _heading(variable, reference) | _value(variable, unit, reference, state))
    structure = ET.SubElement(root, "ModelStructure")
    for name, references in (
        ("Output", unit.outputs),
        ("ContinuousStateDerivative", unit.behind("rates")),
        ("InitialUnknown", [*unit.outputs, *unit.behind("states"), *unit.behind("rates")]),
        ("EventIndicator", unit.behind("indicators")),
    ):
        for reference in references:
            ET.SubElement(structure, name, valueReference=str(reference))
    return _written(root)


def _about(root: ET.Element, unit: Unit, state: str, directional: str) -> None:
    """Elements before the variables, alike in both versions but for the names of two abilities."""
    root.set("description", "roller rig, axes x forward, y to the left, z upwards; SI")
    root.set("generationTool", TOOL)
    root.set("variableNamingConvention", "structured")
    able = {f"canGetAndSet{state}": "true", f"canSerialize{state}": "true"}
    exchange = {directional: "true"}
    if unit.kind != "cs":
        ET.SubElement(root, "ModelExchange", {"modelIdentifier": unit.identifier} | able | exchange)
    if unit.kind != "me":
        steps = {"canHandleVariableCommunicationStepSize": "true"}
        ET.SubElement(root, "CoSimulation", {"modelIdentifier": unit.identifier} | steps | able)
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in sorted({"s", *(variable.unit for _, variable, _ in unit.scalars)}):
        powers = {base: str(power) for base, power in base_units(name).items()}
        ET.SubElement(ET.SubElement(definitions, "Unit", name=name), "BaseUnit", powers)
    categories = ET.SubElement(root, "LogCategories")
    for name, meaning in LOG.items():
        ET.SubElement(categories, "Category", name=name, description=meaning)
    ET.SubElement(
        root, "DefaultExperiment", startTime="0.0", stopTime=number(unit.final_time), stepSize=number(unit.step)
    )


def _heading(variable: _core.Variable, reference: int) -> dict[str, str]:
    """Attributes of a variable that do not depend on its type."""
    found = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
    }
    if variable.causality == "input":  # whose initial is exact; FMI 2.0 does not allow to say so
        return found
    return found | {"initial": "exact" if variable.causality == "parameter" else "calculated"}


def _value(variable: _core.Variable, unit: Unit, reference: int, state: int | None) -> dict[str, str]:
    """Unit, limits and start of a variable; of a state its nominal value, of a rate the reference of its state."""
    found = {"unit": variable.unit}
    if state is not None:
        return found | {"derivative": str(state)}
    if variable.causality == "local":
        return found | ({"nominal": number(variable.most)} if reference in unit.behind("states") else {})
    found |= {key: number(limit) for key, limit in (("min", variable.least), ("max", variable.most))
              if math.isfinite(limit)}  # fmt: skip
    return found if variable.causality == "output" else found | {"start": number(variable.start)}


def _written(root: ET.Element) -> bytes:
    ET.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode").encode() + b"\n"
