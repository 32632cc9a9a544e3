"""Turn references into what they refer to, and raw tables into checked parts of a case.

raw vehicle, support, material, profile + the folder they were read from -> (object | None, problems)
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rollerrig.config.errors import ConfigError, ConfigProblem, nearest, show_value
from rollerrig.config.load.placed import placed
from rollerrig.config.read.document import NO_SUCH_FILE, Document, read_document
from rollerrig.config.read.library import CatalogKind, catalog_names
from rollerrig.config.schema.material import Material
from rollerrig.config.schema.programme import Programme
from rollerrig.config.schema.support import Rig, SupportRoot
from rollerrig.config.schema.track import Track
from rollerrig.config.schema.vehicle import Vehicle
from rollerrig.config.validate.check_profile import check_gauge, check_profile
from rollerrig.config.validate.check_programme import check_programme
from rollerrig.config.validate.check_track import check_line, check_measured_file, check_spot
from rollerrig.config.validate.check_vehicle import check_vehicle, check_vehicle_names
from rollerrig.config.validate.messages import validate

Problems = list[ConfigProblem]

_POINT_FILES = (".txt", ".dat", ".csv", ".prw", ".prr", ".prf", ".xy")


def resolve_vehicle(document: Document) -> tuple[Vehicle | None, Problems]:
    """A vehicle from its raw tables."""
    file = document.file
    raw, problems = placed(document.raw, file)
    problems += check_vehicle_names(raw, file)
    wheel = raw.get("wheel")
    if isinstance(wheel, Mapping):
        raw["wheel"], mistakes = _with_profile(wheel, document, "wheel.profile")
        problems += mistakes
    vehicle, mistakes = validate(Vehicle, raw, file)
    problems += _new(mistakes, problems)
    if vehicle is None or problems:
        return None, problems
    problems += check_vehicle(vehicle, file)
    problems += check_profile(vehicle.wheel.profile, "wheel", file, "wheel.profile")[1]
    return (None if problems else vehicle), problems


def resolve_support(document: Document) -> tuple[Rig | Track | None, Problems]:
    """A rig or track from its raw tables."""
    raw, problems = _with_profile(document.raw, document, "profile")
    raw, mistakes = _with_profile(raw, document, "right_profile")
    problems += mistakes
    if isinstance(raw.get("spot"), Mapping):
        raw["spot"], mistakes = _with_profile(raw["spot"], document, "spot.profile")
        problems += mistakes
    if isinstance(raw.get("segment"), list):
        raw["segment"] = list(raw["segment"])
    for i, segment in enumerate(raw["segment"] if isinstance(raw.get("segment"), list) else ()):
        for key in ("profile", "right_profile") if isinstance(segment, Mapping) else ():
            raw["segment"][i], mistakes = _with_profile(raw["segment"][i], document, f"segment[{i}].{key}")
            problems += mistakes
    if isinstance(raw.get("irregularity"), Mapping):
        raw["irregularity"] = _absolute(raw["irregularity"], document.folder)
    found, mistakes = validate(SupportRoot, raw, document.file)
    problems += _new(mistakes, problems)
    if found is None or problems:
        return None, problems
    support: Rig | Track = found.root
    problems += check_gauge(support, document.file)
    problems += check_line(support, document.file)
    problems += check_measured_file(support, document.file)
    problems += check_spot(support, document.file)
    return (None if problems else support), problems


def resolve_material(document: Document) -> tuple[Material | None, Problems]:
    """A material from its raw tables."""
    return validate(Material, document.raw, document.file)


def resolve_programme(document: Document) -> tuple[Programme | None, Problems]:
    """A test programme from its raw tables."""
    programme, problems = validate(Programme, document.raw, document.file)
    if programme is not None:
        problems += check_programme(programme, document.file)
    return (None if problems else programme), problems


def refer(kind: CatalogKind, name: str, document: Document, key: str) -> tuple[Document | None, Problems]:
    """The document that ``key`` of another one names."""
    try:
        return read_document(kind, name, document.folder), []
    except ConfigError as error:
        if error.problems[0].value != NO_SUCH_FILE:
            return None, list(error.problems)
        problem = error.problems[0]
        return None, [
            ConfigProblem(document.file, key, show_value(name), f"{NO_SUCH_FILE}; {problem.allowed}", problem.hint)
        ]


def resolve_profile(name: str, document: Document, key: str) -> tuple[dict[str, Any] | None, Problems]:
    """Raw tables of the profile that ``name`` stands for: a catalogue entry, a TOML file, or a file of points."""
    if Path(name).suffix.lower() in _POINT_FILES:
        return _absolute({"kind": "file", "path": name}, document.folder), []
    if name in catalog_names("profile") or name.endswith(".toml"):
        found, problems = refer("profile", name, document, key)
        return (_absolute(found.raw, found.folder) if found else None), problems
    names = catalog_names("profile")
    allowed = f"allowed: a table with kind, a file of points, a TOML file, or one of {', '.join(names)}"
    return None, [ConfigProblem(document.file, key, show_value(name), allowed, nearest(name, names))]


def _with_profile(table: Mapping[str, Any], document: Document, key: str) -> tuple[dict[str, Any], Problems]:
    name = key.rpartition(".")[2]
    resolved, written = dict(table), table.get(name)
    problems: Problems = []
    if isinstance(written, str):
        spec, problems = resolve_profile(written, document, key)
        resolved[name] = written if spec is None else spec
    elif isinstance(written, Mapping):
        resolved[name] = _absolute(written, document.folder)
    return resolved, problems


def _absolute(spec: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    path = spec.get("path")
    if not isinstance(path, str) or not path or "\0" in path:
        return dict(spec)
    return {**spec, "path": str((folder / path).absolute())}


def relative_to(folder: Path, key: str, value: object) -> object:
    """A new value as the file in ``folder`` means it: a file of a profile or of code that it names stands relative to it."""
    if isinstance(value, Mapping):
        return {name: relative_to(folder, str(name), inner) for name, inner in value.items()}
    last = key.rpartition(".")[2]
    if not isinstance(value, str) or not value or "\0" in value:
        return value
    names_a_file = last in ("profile", "right_profile") and Path(value).suffix.lower() in (*_POINT_FILES, ".toml")
    names_a_file |= last in ("path", "fmu", "file") or (last == "user" and ".py:" in value)
    return str((folder / value).absolute()) if names_a_file else value


def _new(mistakes: Problems, known: Problems) -> Problems:
    """Mistakes at keys of which nothing has been said yet."""
    keys = {(problem.file, problem.key) for problem in known}
    return [mistake for mistake in mistakes if (mistake.file, mistake.key) not in keys]
