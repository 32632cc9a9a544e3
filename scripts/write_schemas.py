#!/usr/bin/env python
"""Write the JSON Schemas that ship with the catalogue: python/rollerrig/catalog/schema/KIND.json.

Each is one line, read by editors and not by people (`rollerrig schema` prints it for those). A test says when one of them is no
longer that of the models.
"""

import json
from pathlib import Path

from rollerrig.catalog import KINDS
from rollerrig.config import json_schema

SCHEMAS = Path(__file__).parents[1] / "python" / "rollerrig" / "catalog" / "schema"

for kind in KINDS:
    (SCHEMAS / f"{kind}.json").write_text(
        json.dumps(json_schema(kind), separators=(",", ": "), ensure_ascii=False) + "\n", encoding="utf-8"
    )
