"""JSON Schema of a dump, a file of the site, built from the models that write it."""

from __future__ import annotations

import json
from typing import Any

from pydantic.json_schema import models_json_schema

from calibdb.schema import CalibrationDocument, VoteDocument
from calibdb.schema.dump import Dump, Statistics

DUMP_SCHEMA_KEY = "data/schema.json"


def text() -> str:
    """Return the file's content."""
    models = (Dump, Statistics, CalibrationDocument, VoteDocument)
    _, definitions = models_json_schema(
        [(model, "serialization") for model in models], ref_template="#/$defs/{model}"
    )
    document: dict[str, Any] = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Dump of calibDB, version 1",
        "description": "Of /dumps/latest.json. $defs also has Statistics, of /dumps/statistics.json, and the "
        "documents in the files, one a line: CalibrationDocument and VoteDocument.",
        "$ref": "#/$defs/Dump",
        "$defs": definitions["$defs"],
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"
