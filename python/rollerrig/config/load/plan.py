"""Read a plan of a sweep with the case it varies, and find what each varied key is.

TOML -> plan -> its case, with the changes of the plan -> [plan_of_case] -> the quantity at each varied key
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from rollerrig.config.errors import ConfigError, ConfigProblem, nearest, one_of, show_value, whole
from rollerrig.config.load.case import Case, build_case
from rollerrig.config.load.change import leaves, matching_paths, parts_of, whole_key
from rollerrig.config.load.code import Code, check_new_code, code_of
from rollerrig.config.load.resolve import Problems, refer, relative_to
from rollerrig.config.read import Document, read_document
from rollerrig.config.schema.base import quantity_of
from rollerrig.config.schema.plan import Plan
from rollerrig.config.schema.units import Quantity
from rollerrig.config.validate.messages import NAMING_KEYS, validate
from rollerrig.config.write.differences import tables_of


@dataclass(frozen=True)
class WholePlan:
    """A plan with what it refers to."""

    plan: Plan  # as it was written
    case: Case  # with the changes of the plan
    file: str  # that messages name
    quantities: tuple[Quantity | None, ...]  # of the varied keys, in their order; None where words or lists stand
    varied_code: tuple[Code, ...] = ()  # code that varied values name

    @property
    def code(self) -> tuple[Code, ...]:
        """All code that runs with the plan."""
        return (*code_of(self.case), *self.varied_code)


def load_plan(
    source: str | Path | Document, *, allow_code: bool = False, changes: Mapping[str, object] | None = None
) -> WholePlan:
    """Read a plan, the case it names, and what its keys are.

    Args:
        source: name in the catalogue, path of a TOML file, or its raw tables.
        allow_code: whether controllers of its case, and those that it brings itself, may lie outside the folder of the file
            that names them.
        changes: of the case, beyond those of the plan.

    Raises:
        ConfigError: all mistakes found.
    """
    document = source if isinstance(source, Document) else read_document("plan", source)
    plan = whole(*validate(Plan, document.raw, document.file))
    if not plan.measure:
        allowed = "needed: what is computed of each case, such as [[measure]] with kind = 'critical_speed'"
        raise ConfigError.of(document.file, "measure", "missing", allowed)
    found = whole(*refer("case", plan.case, document, "case"))
    case = build_case(found, own_folder=found.folder, allow_code=allow_code)
    own = {key: relative_to(document.folder, key, value) for key, value in leaves(plan.changes)}
    plan, code = _with_code(plan, own, document, allow=allow_code)
    case = changed_by_plan(case, own, document.file)
    found_keys = plan_of_case(plan, case.with_changes(changes) if changes else case, document.file)
    return replace(found_keys, varied_code=code)


def _with_code(
    plan: Plan, changes: Mapping[str, object], document: Document, *, allow: bool
) -> tuple[Plan, tuple[Code, ...]]:
    """The plan with absolute paths of the code that its varied values name, and that code.

    Raises:
        ConfigError: its changes or its varied values bring code from elsewhere.
    """
    gate = partial(check_new_code, file=document.file, own_folder=document.folder, allow=allow)
    problems = gate(changes, at="changes")[1]
    code: dict[Code, None] = {}
    vary = []
    for number, one in enumerate(plan.vary):
        values = []
        for value in one.values or ():
            absolute = relative_to(document.folder, one.key, value)
            found, mistakes = gate({one.key: absolute}, at=f"vary[{number}].values")
            code |= dict.fromkeys(found)
            problems += mistakes
            values.append(absolute if found else value)
        vary.append(one if one.values is None else one.model_copy(update={"values": tuple(values)}))
    return whole(plan.model_copy(update={"vary": tuple(vary)}), problems), tuple(code)


def plan_of_case(plan: Plan, case: Case, file: str) -> WholePlan:
    """A plan for a case that has its changes already.

    Raises:
        ConfigError: a key that is varied does not exist, or two have one name.
    """
    raw = tables_of(case)
    quantities: list[Quantity | None] = []
    problems: Problems = []
    names = [variation.label for variation in plan.vary]
    for number, variation in enumerate(plan.vary):
        at = f"vary[{number}]"
        if variation.label in names[:number]:
            problems.append(named_twice(file, at, variation.label))
        found = value_at(case, raw, variation.key, file)
        if isinstance(found, ConfigProblem):
            problems.append(replace(found, key=f"{at}.key", value=show_value(variation.key)))
        else:
            quantities.append(found[0])
    return whole(WholePlan(plan, case, file, tuple(quantities)), problems)


def changed_by_plan(case: Case, changes: Mapping[str, object], file: str, at: str = "changes") -> Case:
    """The case with what a plan changes at its key `at`, which the messages of a ConfigError name."""
    try:
        return case.with_changes(changes) if changes else case
    except ConfigError as error:
        raise ConfigError([replace(p, file=file, key=f"{at}.{p.key}") for p in error.problems]) from None


def named_twice(file: str, at: str, label: str) -> ConfigProblem:
    """Two numbers of a plan would have one name in results."""
    allowed = "allowed: each name once; give this one a `name` of its own"
    return ConfigProblem(file, f"{at}.name", show_value(label), allowed)


def numbers_below(case: Case, key: str) -> list[str]:
    """Dotted keys of the numbers in the table at a key; none where no table stands."""
    holder: Any = case
    for part in parts_of(whole_key(key)):
        holder = _inside(holder).get(part)
    if not isinstance(holder, BaseModel):
        return []
    fields = type(holder).model_fields.items()
    return [f"{key}.{name}" for name, field in fields if quantity_of(field.annotation, field.metadata)]


def value_at(case: Case, raw: dict[str, Any], key: str, file: str) -> tuple[Quantity | None, Any] | ConfigProblem:
    """What stands at a dotted key of a case, whose plain tables are `raw`: its quantity and value; with `*` the first of all."""
    path = parts_of(whole_key(key))
    if "*" in key:
        matching = matching_paths(raw, path, key, file)
        if isinstance(matching, ConfigProblem):
            return matching
        path = matching[0]
    holder: Any = case
    quantity: Quantity | None = None
    for number, part in enumerate(path):
        choices = _inside(holder)
        if holder is None:
            allowed = f"the case has no `{'.'.join(path[:number])}`; put it into [changes]"
            return ConfigProblem(file, key, "", allowed)
        if part not in choices:
            return ConfigProblem(file, key, "", one_of(choices), nearest(part, tuple(choices)))
        if isinstance(holder, BaseModel):
            field = type(holder).model_fields[part]
            quantity = quantity_of(field.annotation, field.metadata)
        holder = choices[part]
    return (None if isinstance(holder, BaseModel | dict) else quantity), holder


def _inside(holder: Any) -> dict[str, Any]:
    """What may follow in a dotted key: name -> value; items of a list by their names and numbers."""
    if isinstance(holder, BaseModel):
        return {name: getattr(holder, name) for name in type(holder).model_fields}
    if isinstance(holder, Mapping):
        return dict(holder)
    if not isinstance(holder, list | tuple):
        return {}
    named = {str(name): item for item in holder for k in NAMING_KEYS if isinstance(name := getattr(item, k, None), str)}
    return {**named, **{str(number): item for number, item in enumerate(holder)}}
