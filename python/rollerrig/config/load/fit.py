"""Read a plan of a fit with its cases, and find what each free key is.

TOML -> FitPlan -> a case for each [[log]], with its changes and the starts -> [free_keys] -> quantity, range, start, prior
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NoReturn

from rollerrig.common.free_number import FreeNumber
from rollerrig.config.errors import ConfigError, ConfigProblem, show_value, whole
from rollerrig.config.load.case import Case, build_case
from rollerrig.config.load.change import leaves
from rollerrig.config.load.code import Code, check_new_code, code_of
from rollerrig.config.load.plan import changed_by_plan, named_twice, numbers_below, value_at
from rollerrig.config.load.resolve import refer, relative_to
from rollerrig.config.read import Document, read_document
from rollerrig.config.schema.fit import FitPlan, FreeKey
from rollerrig.config.schema.units import Quantity
from rollerrig.config.validate.messages import validate
from rollerrig.config.write.differences import tables_of


@dataclass(frozen=True, kw_only=True)
class FreeKeyNumber(FreeNumber):
    """The number at a free key, in SI: dotted key, quantity there, where the search begins."""

    key: str
    quantity: Quantity
    start: float


@dataclass(frozen=True)
class WholeFit:
    """A plan of a fit with the cases of its tables of logs, in their order, and its free numbers."""

    plan: FitPlan
    cases: tuple[Case, ...]
    file: str
    free: tuple[FreeKeyNumber, ...]

    @property
    def code(self) -> tuple[Code, ...]:
        """All code that runs with the plan."""
        return tuple(dict.fromkeys(code for case in self.cases for code in code_of(case)))


def load_fit(
    source: str | Path | Document | Mapping[str, object],
    *,
    allow_code: bool = False,
    changes: Mapping[str, object] | None = None,
) -> WholeFit:
    """Read a plan of a fit and the cases it names.

    Args:
        source: name in the catalogue, path of a TOML file, or its raw tables.
        allow_code: whether controllers of its cases may lie outside the folder of the file that names them.
        changes: of all cases, beyond those of the plan.

    Raises:
        ConfigError: all mistakes found.
    """
    tables = Document(dict(source), "plan", Path()) if isinstance(source, Mapping) else source
    document = tables if isinstance(tables, Document) else read_document("fit", tables)
    plan = whole(*validate(FitPlan, document.raw, document.file))
    cases = []
    starts = {one.key: one.start for one in plan.free if one.start is not None}
    for number, log in enumerate(plan.log):
        at = f"log[{number}].case" if log.case else "case"
        found = whole(*refer("case", log.case or plan.case, document, at))
        case = build_case(found, own_folder=found.folder, allow_code=allow_code)
        for given, at in ((plan.changes, "changes"), (log.changes, f"log[{number}].changes")):
            own = {key: relative_to(document.folder, key, value) for key, value in leaves(given)}
            whole(*check_new_code(own, file=document.file, own_folder=document.folder, allow=allow_code, at=at))
            case = changed_by_plan(case, own, document.file, at)
        cases.append(changed_by_plan(case.with_changes(changes or {}), starts, document.file, "free"))
    free, problems = [], list[ConfigProblem]()
    for number, one in enumerate(plan.free):
        try:
            if one.label in [other.label for other in plan.free[:number]]:
                raise ConfigError([named_twice(document.file, f"free[{number}]", one.label)])
            found_in = [_number(one, case, document.file, f"free[{number}]") for case in cases]
            free.append(found_in[0])
        except ConfigError as error:
            problems += error.problems
    return whole(WholeFit(plan, tuple(cases), document.file, tuple(free)), problems)


def _number(one: FreeKey, case: Case, file: str, at: str) -> FreeKeyNumber:
    """A free key in SI; a ConfigError where it leads nowhere, or its numbers do not fit."""

    def refuse(key: str, value: object, allowed: str) -> NoReturn:
        raise ConfigError.of(file, f"{at}.{key}", show_value(value), allowed)

    there = value_at(case, tables_of(case) if "*" in one.key else {}, one.key, file)
    if isinstance(there, ConfigProblem):
        allowed = there.allowed.replace("put it into [changes]", "give the key a `start`")
        raise ConfigError([replace(there, key=f"{at}.key", value=show_value(one.key), allowed=allowed)])
    quantity, value = there
    if quantity is None or not isinstance(value, int | float):
        below = numbers_below(case, one.key)
        numbers = f"; its numbers are {', '.join(below)}" if below else ""
        refuse("key", one.key, f"needed: the key of a number{numbers}")

    def parsed(key: str, text: object, within: Quantity) -> float:
        try:
            return within.parse(text)
        except ValueError as error:
            refuse(key, text, str(error))

    least, most = parsed("least", one.least, quantity), parsed("most", one.most, quantity)
    logarithmic, prior, spread = one.scale == "logarithmic", None, one.prior
    if not least < most:
        refuse("most", one.most, f"allowed: more than `least`, {one.least}")
    if logarithmic and not least > 0.0:
        refuse("scale", one.scale, "allowed: with a positive `least`")
    if not least <= value <= most:
        refuse(
            "least", one.least, f"allowed: a range with the start in it, {value:g} {quantity.unit}; or another `start`"
        )
    if spread is not None:
        if (spread.kind == "lognormal") != logarithmic:
            refuse("prior.kind", spread.kind, "allowed: normal with a linear scale, lognormal with a logarithmic one")
        any_size = Quantity(quantity.unit, 0.0, 1e300)
        if spread.kind == "normal":
            prior = parsed("prior.mean", spread.mean, quantity), parsed("prior.deviation", spread.deviation, any_size)
        else:
            prior = math.log(parsed("prior.median", spread.median, any_size)), spread.deviation
        if not prior[1] > 0.0:
            refuse("prior.deviation", spread.deviation, "allowed: positive")
    return FreeKeyNumber(one.label, least, most, logarithmic, prior, key=one.key, quantity=quantity, start=float(value))
