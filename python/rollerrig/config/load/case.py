"""Read cases, and the vehicles, supports and materials they refer to.

    TOML -> references resolved -> fields validated -> checks across fields -> frozen objects in SI

All mistakes of a case and of the files it names are collected before ConfigError is raised.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

from rollerrig.config.errors import ConfigError, ConfigProblem, nearest, one_of, problems_of, show_value, whole
from rollerrig.config.load.adhesion_file import read_adhesion_file
from rollerrig.config.load.change import (
    BASE,
    WITHOUT,
    apply_changes,
    changed_tables,
    changes_in,
    new_leaves,
    parts_of,
    value_in,
)
from rollerrig.config.load.code import place_code
from rollerrig.config.load.contact_distance import with_gauge
from rollerrig.config.load.resolve import (
    placed,
    refer,
    relative_to,
    resolve_material,
    resolve_profile,
    resolve_programme,
    resolve_support,
    resolve_vehicle,
)
from rollerrig.config.read import CatalogKind, Document, catalog_names, parse_document, read_document
from rollerrig.config.schema.base import Table
from rollerrig.config.schema.case import CaseTables
from rollerrig.config.schema.contact import Material
from rollerrig.config.schema.profile import ProfileRoot, ProfileSpec
from rollerrig.config.schema.programme import Programme
from rollerrig.config.schema.support import Rig
from rollerrig.config.schema.track import Track
from rollerrig.config.schema.vehicle import Vehicle
from rollerrig.config.validate.check_case import check_case, check_case_names, check_drive
from rollerrig.config.validate.check_profile import check_profile
from rollerrig.config.validate.messages import validate
from rollerrig.config.write.differences import OWN_KEYS, Differences, differences, in_words, tables_of, text_from_base
from rollerrig.config.write.toml import plain, to_short_toml, to_toml

T = TypeVar("T")
Problems = list[ConfigProblem]


class Case(CaseTables):
    """Everything one simulation needs; read by `load_case`, in SI, never changed: `with_changes` makes another.

    Example:
        >>> case = load_case("bogie_track").with_changes({"motion.speed": "100 km/h"})
        >>> print(case.to_short_toml())
        base = "bogie_track"
        <BLANKLINE>
        [motion]
        speed = "100 km/h"
        <BLANKLINE>
    """

    def __repr__(self) -> str:
        return repr(in_words(self))

    __str__ = __repr__

    def _repr_html_(self) -> str:
        return in_words(self)._repr_html_()

    def with_changes(self, changes: Mapping[str, object]) -> "Case":
        """A copy with some values replaced, checked like a file.

        Args:
            changes: dotted key -> value as a file would give it, e.g. `{"motion.speed": "120 km/h",
                "support.roller_radius": 10, "vehicle.body.car_body.mass": "30 t"}`. Items of a list are addressed
                by name or index, with `*` all that match (`vehicle.element.primary_*.x.stiffness`); numbers of NumPy and
                quantities of pint are numbers too; None takes a key away; `vehicle.data.` and `support.data.` may be
                shortened to `vehicle.` and `support.`.

        Raises:
            ConfigError: a key does not exist or a value is not allowed.
        """
        file = f"{self.name} (changed)"
        raw, problems = changed_tables(self, {str(key): value for key, value in changes.items()}, file)
        # the case's code is allowed, new code is the caller's
        return _built(problems, Document(raw, file, Path()), allow_code=True)

    def diff(self, other: "Case") -> Differences:
        """What is different in another case: dotted key -> (value here, value there), in SI; it prints a line per key."""
        return differences(tables_of(self), tables_of(other))

    def to_toml(self) -> str:
        """The whole case, nothing referred to by name, as TOML text that `load_case` reads again."""
        return to_toml(self, shared=[(part, "data") for part in OWN_KEYS])  # with_changes shares them

    def to_short_toml(self, base: str = "") -> str:
        """What differs from a case of the catalogue, or all that has not its default value: a file to read and edit.

        Args:
            base: name of that case; "": of the same name.

        Raises:
            ConfigError: no case of the catalogue has the name that is given.
        """
        name, full, names = base or self.name, to_short_toml(self), catalog_names("case")
        if base and base not in names:
            raise ConfigError.of(self.name, "base", repr(base), one_of(names), nearest(base, names))
        if name not in names:
            return full
        try:
            start, used = load_case(name), Differences()
            for part in OWN_KEYS:
                old, new = (getattr(case, part).use for case in (start, self))
                used |= {f"{part}.use": (old, new)} if old != new else {}
            near = start.with_changes({key: use for key, (_, use) in used.items() if use})
            text = text_from_base(name, Differences({**used, **differences(plain(near), plain(self))}))
            same = case_from_toml(text, allow_code=True) == self
        except ConfigError:
            return full
        return text if same and len(text) < len(full) else full

    def save(self, path: str | Path, base: str = "") -> None:
        """Write `to_short_toml` to a file that `load_case` reads.

        Raises:
            ConfigError: see `to_short_toml`.
            OSError: it cannot be written.
        """
        Path(path).write_text(self.to_short_toml(base), encoding="utf-8")


def load_case(source: str | Path, *, allow_code: bool = False) -> Case:
    """Read a case, with the vehicle, support, material and profiles it names.

    Args:
        source: name in the catalogue, or path of a TOML file.
        allow_code: whether controllers that it names may lie outside its own folder; none is run here.

    Raises:
        ConfigError: all mistakes found.

    Example:
        >>> load_case("bogie_track").support.data.kind
        'track'
    """
    kind, document = read_known(source)
    if kind != "case":
        needed = {
            "plan": f"needed: a case; the plan is run by `rollerrig sweep {source}`",
            "fit": f"needed: a case; the plan is run by `rollerrig fit {source} LOG`",
            "programme": f"needed: a case; the programme is run by `rollerrig wsp CASE --programme {source}`",
        }
        use = f"needed: a case that uses it, e.g. a copy of `rollerrig catalog show bogie_track` with this {kind} in it"
        raise ConfigError.of(str(source), "", f"a {kind}, not a case", needed.get(kind, use))
    return build_case(document, own_folder=document.folder, allow_code=allow_code)


def read_known(source: str | Path) -> tuple[CatalogKind, Document]:
    """An entry of the catalogue or a file of any kind, with its kind: by its name, or by its keys."""
    kinds: tuple[CatalogKind, ...] = get_args(CatalogKind)
    named = next((kind for kind in kinds if str(source) in catalog_names(kind)), None)
    document = read_document(named or "case", source)
    return named or kind_of(document.raw), document


def case_from_toml(text: str, file: str = "case", folder: Path | None = None, *, allow_code: bool = False) -> Case:
    """The case in a TOML text, e.g. the one stored in a result file.

    Args:
        text: the TOML.
        file: what messages call it.
        folder: where relative paths in it start, its own folder; by default the current one, and it has no own folder.
        allow_code: whether controllers that it names may lie outside its own folder; none is run here.

    Raises:
        ConfigError: all mistakes found.
    """
    return build_case(parse_document(text, file, folder), own_folder=folder, allow_code=allow_code)


def load_vehicle(source: str | Path) -> Vehicle:
    """Read a vehicle by catalogue name or path; raises ConfigError with all mistakes."""
    return whole(*resolve_vehicle(read_document("vehicle", source)))


def load_support(source: str | Path) -> Rig | Track:
    """Read a rig or track by catalogue name or path; raises ConfigError with all mistakes."""
    support, problems = resolve_support(read_document("support", source))
    if support is None:
        raise ConfigError(problems)
    return support


def load_material(source: str | Path) -> Material:
    """Read a material by catalogue name or path; raises ConfigError with all mistakes."""
    return whole(*resolve_material(read_document("material", source)))


def load_programme(source: str | Path) -> Programme:
    """Read a test programme by catalogue name or path; raises ConfigError with all mistakes."""
    return whole(*resolve_programme(read_document("programme", source)))


def load_profile(source: str | Path, kind: Literal["wheel", "rail"] | None = None) -> ProfileSpec:
    """Read a profile specification by catalogue name or path; raises ConfigError with all mistakes.

    Args:
        source: name in the catalogue, TOML file, or file of points.
        kind: what it is for; if given, the curve is built once to see that it can be used so.
    """
    file = str(source)
    raw, problems = resolve_profile(file, Document({}, file, Path()), "")
    root = whole(*validate(ProfileRoot, whole(raw, problems), file))
    return whole(root.root, problems_of(file, check_profile(root.root, kind, "")) if kind else [])


def kind_of(raw: Mapping[str, Any]) -> CatalogKind:
    """What a document is meant to be; a case if nothing tells."""
    if raw.keys() & {"vary", "free"}:
        return "plan" if "vary" in raw else "fit"
    if raw.keys() & {BASE, "vehicle", "motion", "time"}:
        return "case"
    if raw.keys() & {"stop", "limit"}:
        return "programme"
    if raw.keys() & {"body", "wheel", "element"}:
        return "vehicle"
    if raw.keys() & {"poisson_ratio", "young_modulus", "shear_modulus"}:
        return "material"
    if raw.get("kind") in ("rig", "track") or raw.keys() & {"gauge", "roller_radius"}:
        return "support"
    return "profile" if "kind" in raw else "case"


def build_case(
    document: Document, *, own_folder: Path | None = None, allow_code: bool = False, above: tuple[str, ...] = ()
) -> Case:
    """Resolve, validate and check a case.

    Args:
        document: its raw tables.
        own_folder: where its controllers may lie; None: nowhere.
        allow_code: whether they may lie anywhere.
        above: files that start from this one.

    Raises:
        ConfigError: all mistakes found.
    """
    if BASE in document.raw:
        return _build_from_base(document, own_folder, allow_code=allow_code, above=above)
    raw: dict[str, Any] = _copied(document.raw)
    file = document.file
    if WITHOUT in raw:
        allowed = "allowed: beside `base`, whose keys it takes away"
        raise ConfigError.of(file, WITHOUT, show_value(raw[WITHOUT]), allowed)
    vehicle, problems = _part(raw, "vehicle", resolve_vehicle, document)
    support: Rig | Track | None
    support, mistakes = _part(raw, "support", resolve_support, document)
    problems += mistakes
    if vehicle is not None and support is not None:
        raw["support"]["data"], mistakes = with_gauge(support, vehicle.wheel, file)
        problems += mistakes
    problems += _material(raw, document)
    if isinstance(raw.get("adhesion"), dict) and "file" in raw["adhesion"]:
        raw["adhesion"], mistakes = read_adhesion_file(raw["adhesion"], file, document.folder)
        problems += mistakes
    problems += place_code(raw, file, document.folder, own_folder, allow=allow_code)
    case, mistakes = validate(Case, raw, file)
    if any(mistake.hint == BASE for mistake in mistakes):  # what is missing then stands in the base
        mistakes = [mistake for mistake in mistakes if mistake.value != "missing"]
    unresolved = {f"{key}.data" for key, part in (("vehicle", vehicle), ("support", support)) if part is None}
    problems += (drive := check_drive(raw, file))
    known = {problem.key for problem in problems if problem.file == file}
    known |= {"motion.torque_table"} if drive else set()
    problems += [m for m in mistakes if m.key not in known and not (m.key in unresolved and problems)]
    if vehicle is not None:
        problems += [ConfigProblem(file, *mistake) for mistake in check_case_names(raw, vehicle)]
    if case is not None and not problems:
        problems += check_case(case, file)
    return whole(case, problems)


def _build_from_base(document: Document, own_folder: Path | None, *, allow_code: bool, above: tuple[str, ...]) -> Case:
    """A case that says what is different from its `base`."""
    name, file = document.raw[BASE], document.file
    if not isinstance(name, str):
        raise ConfigError.of(file, BASE, show_value(name), "allowed: a case of the catalogue or a file")
    found = whole(*refer("case", name, document, BASE))
    here = str((found.folder / Path(name).name).absolute())
    if here in above:
        allowed = "allowed: a case that does not start from this one again"
        raise ConfigError.of(file, BASE, show_value(name), allowed)
    base = build_case(found, own_folder=found.folder, allow_code=allow_code, above=(*above, here))
    changes, problems = changes_in(document, base)
    raw, mistakes = changed_tables(base, changes, file)
    return _built(problems + mistakes, replace(document, raw=raw), own_folder=own_folder, allow_code=allow_code)


def _built(problems: Problems, document: Document, **options: Any) -> Case:
    """The case of a document as `build_case` makes it; its mistakes come after those that are known of its changes."""
    try:
        case = build_case(document, **options)
    except ConfigError as error:
        problems = problems + [problem.shortened() for problem in error.problems]
    return whole(None if problems else case, problems)


def _copied(value: Any) -> Any:
    """Tables and lists anew; their contents are constant."""
    if isinstance(value, dict):
        return {key: _copied(item) for key, item in value.items()}
    return [_copied(item) for item in value] if isinstance(value, list) else value


def _part(
    raw: dict[str, Any],
    key: Literal["vehicle", "support"],
    resolve: Callable[[Document], tuple[T | None, Problems]],
    document: Document,
) -> tuple[T | None, Problems]:
    """Resolve ``[vehicle]`` or ``[support]`` of a case, with its other keys in place of the part's own, into its ``data``."""
    choice = raw.get(key)
    if not isinstance(choice, dict):
        return None, []
    if isinstance(choice.get("data"), Table):  # checked before: of a case that is changed elsewhere
        return choice["data"], []
    own, problems, prefix = _own_document(choice, key, document)
    if own is None and "use" not in choice:
        return None, problems
    beside = {name: choice.pop(name) for name in [*choice] if name not in OWN_KEYS[key]}
    if own is None:  # what its keys may be is not known
        return None, problems
    tables = plain(own.raw)
    changes = {name: relative_to(document.folder, name, value) for name, value in new_leaves(beside, tables)}
    if key == "vehicle":
        tables, mistakes = placed(tables, own.file)
        problems += mistakes
    problems += apply_changes(tables, changes, document.file, key)
    part, mistakes = resolve(replace(own, raw=tables))
    for mistake in mistakes:
        if mistake.file == own.file and _is_of_case(mistake.key, changes, own.raw):
            problems.append(replace(mistake, file=document.file, key=f"{key}.{mistake.key}"))
        else:
            problems.append(mistake.within(prefix) if mistake.file == document.file else mistake)
    if part is None or problems:
        choice.pop("data", None)
        return None, problems
    choice["data"] = part
    return part, []


def _is_of_case(key: str, changes: Mapping[str, object], own: dict[str, Any]) -> bool:
    """Whether a mistake is one of the case, not of the part's own file: in or around a change, or missing from a new table."""
    path = parts_of(key)
    if len(path) > 1 and not isinstance(value_in(own, path[:-1]), dict):
        path.pop()
    return any(all(map(fnmatchcase, path, parts_of(change))) for change in changes)


def _own_document(
    choice: dict[str, Any], key: CatalogKind, document: Document
) -> tuple[Document | None, Problems, str]:
    """The tables of a part, the problems met, and their key in the case's own file."""
    data, use = choice.get("data"), choice.get("use")
    if isinstance(data, dict):
        return replace(document, raw=data), [], f"{key}.data"
    if data is not None:  # validation will say that it is not a table
        return None, [], ""
    if isinstance(use, str):
        found, problems = refer(key, use, document, f"{key}.use")
        return found, problems, ""
    if use is not None:
        return None, [], ""
    allowed = f"needed: a {key} of the catalogue or a file; one of {', '.join(catalog_names(key))}"
    return None, [ConfigProblem(document.file, f"{key}.use", "missing", allowed)], ""


def _material(raw: dict[str, Any], document: Document) -> Problems:
    """Resolve ``contact.material`` of a case in place."""
    contact = raw.get("contact")
    if not isinstance(contact, dict) or not isinstance(contact.get("material"), str):
        return []
    found, problems = refer("material", contact["material"], document, "contact.material")
    material, mistakes = resolve_material(found) if found else (None, [])
    if material is not None:
        contact["material"] = material
    return problems + mistakes
