"""Sphinx extension: the configuration reference, written from the JSON schema of the configuration models.

rollerrig.config (pydantic) -> JSON schema -> [this file] -> reference/generated/configuration.md
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

Schema = dict[str, Any]


def write_reference(app: Sphinx) -> None:
    """Write the tables that reference/configuration.md includes."""
    from rollerrig.config import Case, FitPlan, Plan, Programme

    target = Path(app.srcdir) / "reference" / "generated" / "configuration.md"
    text = "\n".join(reference(*(root.model_json_schema() for root in (Case, Programme, Plan, FitPlan))))
    target.parent.mkdir(exist_ok=True)
    if not target.is_file() or target.read_text() != text:  # an unchanged file keeps its date: no rebuild
        target.write_text(text)


def reference(case: Schema, programme: Schema, plan: Schema, fit: Schema) -> list[str]:
    """The whole reference as lines of MyST Markdown: one section per kind of file, one table per TOML table."""
    tables: dict[str, Schema] = {"Case": case, **case["$defs"], "Programme": programme, **programme["$defs"]}
    tables |= {"Plan": plan, **plan["$defs"], "FitPlan": fit, **fit["$defs"]}
    profiles = list(references(tables["Wheel"]["properties"]["profile"]))
    sections = {
        "Case file": ["Case"],
        "Vehicle file": ["Vehicle"],
        "Support file": [name for name in ("Rig", "Track") if name in tables],
        "Profiles": profiles,
        "Materials": ["Material"],
        "Programme file": ["Programme"],
        "Plan file": ["Plan"],
        "Plan of a fit": ["FitPlan"],
    }
    roots = {name for names in sections.values() for name in names}
    written: set[str] = set()
    lines: list[str] = []
    for title, names in sections.items():
        lines += [f"## {title}", ""]
        for name in names:
            for table in reachable(tables, name, roots - {name}):
                if table not in written:
                    written.add(table)
                    lines += table_section(table, tables[table])
    missing = set(tables) - written
    if missing:
        raise RuntimeError(f"configuration tables without a section in the reference: {', '.join(sorted(missing))}")
    return lines


def references(schema: Any) -> list[str]:
    """Names of the tables that a piece of schema refers to, in order, each once."""
    if isinstance(schema, dict):
        found = [schema["$ref"].split("/")[-1]] if "$ref" in schema else []
        for key, value in schema.items():
            found += references(value) if key not in ("$defs", "discriminator") else []
        return list(dict.fromkeys(found))
    if isinstance(schema, list):
        return list(dict.fromkeys(name for item in schema for name in references(item)))
    return []


def reachable(tables: dict[str, Schema], start: str, border: set[str]) -> list[str]:
    """`start` and the tables below it, without those behind the border."""
    found, waiting = [], [start]
    while waiting:
        name = waiting.pop(0)
        if name not in found:
            found.append(name)
            waiting += [n for n in references(tables[name].get("properties", {})) if n not in border]
    return found


def table_section(name: str, schema: Schema) -> list[str]:
    """Heading, docstring and key table of one TOML table."""
    lines = [f"(config-{name.lower()})=", f"### {name}", "", schema.get("description", ""), ""]
    lines += ["| key | value | unit | default | meaning |", "|---|---|---|---|---|"]
    required = schema.get("required", [])
    for key, field in schema.get("properties", {}).items():
        cells = [
            f"`{key}`",
            value_text(field),
            ", ".join(dict.fromkeys(units(field))),
            "*required*" if key in required else default_text(field),
            field.get("description", ""),
        ]
        lines.append("| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |")
    return [*lines, ""]


def default_text(field: Schema) -> str:
    """The default as TOML would have it; empty where absence is the default."""
    default = field.get("default")
    return "" if default in (None, "", [], {}) else f"`{json.dumps(default)}`"


def units(schema: Any) -> list[str]:
    """Every unit in a piece of schema; a pure number has none."""
    if isinstance(schema, dict):
        own = [f"`{schema['x-unit']}`"] if schema.get("x-unit", "1") != "1" else []
        return own + [unit for value in schema.values() for unit in units(value)]
    return [unit for item in schema for unit in units(item)] if isinstance(schema, list) else []


def value_text(schema: Schema) -> str:
    """What may stand at a key, in words."""
    if "$ref" in schema:
        name = schema["$ref"].split("/")[-1]
        return f"[{name}](#config-{name.lower()})"
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    if "enum" in schema:
        return ", ".join(f"`{json.dumps(item)}`" for item in schema["enum"])
    if "x-unit" in schema:
        return number_text(next(item for item in schema["anyOf"] if item.get("type") == "number"))
    for choice in ("oneOf", "anyOf"):
        if choice in schema:
            texts = [value_text(item) for item in schema[choice] if item.get("type") != "null"]
            return " or ".join(dict.fromkeys(texts))
    match schema.get("type"):
        case "array" if "prefixItems" in schema:
            items = [value_text(item) for item in schema["prefixItems"]]
            return f"{len(items)} × {items[0]}" if len(set(items)) == 1 else f"[{', '.join(items)}]"
        case "array":
            return f"list of {value_text(schema['items'])}" if "items" in schema else "list"
        case "object":
            inner = schema.get("additionalProperties") or next(iter(schema.get("patternProperties", {}).values()), None)
            return f"tables by name: {value_text(inner)}" if isinstance(inner, dict) else "table"
        case "number" | "integer":
            return number_text(schema)
        case "boolean":
            return "`true` or `false`"
        case "string":
            return "text"
    return "any"


def number_text(schema: Schema) -> str:
    """A number with its bounds."""
    bounds = [
        f"{sign} {schema[key]:g}"
        for key, sign in (("exclusiveMinimum", ">"), ("minimum", "≥"), ("exclusiveMaximum", "<"), ("maximum", "≤"))
        if key in schema
    ]
    return " ".join(["number", ", ".join(bounds)]).strip()


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("builder-inited", write_reference)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
