#!/usr/bin/env python
"""Write the JSON Schemas that ship with the catalogue: python/rollerrig/catalog/schema/KIND.json.

Each is one line, read by editors and not by people (`rollerrig schema` prints it for those). A test says when one of them is no
longer that of the models.
"""

import json

from rollerrig.catalog import KINDS
from rollerrig.config import json_schema
from rollerrig.config.read import schema_file

for kind in KINDS:
    schema_file(kind).write_text(
        json.dumps(json_schema(kind), separators=(",", ": "), ensure_ascii=False) + "\n", encoding="utf-8"
    )
