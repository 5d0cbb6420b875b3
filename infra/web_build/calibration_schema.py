"""JSON Schema of a calibration document, a file of the site, built from the models of the service."""

from __future__ import annotations

import json

from pydantic.json_schema import models_json_schema

from calibdb.schema import GivenCalibration, LookupAnswer, ReportedCalibration

VERSION = 1
"""Another one removes a member, or gives it another meaning; new members do not change it."""
CALIBRATION_SCHEMA_KEY = f"docs/schema/calibration-{VERSION}.json"


def text() -> str:
    """Return the file's content."""
    models = (LookupAnswer, ReportedCalibration, GivenCalibration)
    _, schema = models_json_schema(
        [(model, "validation") for model in models], ref_template="#/$defs/{model}"
    )
    lookup, reported, stored = (schema["$defs"].pop(model.__name__) for model in models)
    document = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"/{CALIBRATION_SCHEMA_KEY}",
        "title": f"Calibration of calibDB, version {VERSION}",
        "description": "As a lookup, GET /v1/calibrations/{id} and the export format calibdb return it, and "
        "as the Python client saves it. Only what makes a camera is required.",
        "type": "object",
        "properties": lookup["properties"] | reported["properties"],
        "required": stored["required"],
        "$defs": schema["$defs"],
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"
