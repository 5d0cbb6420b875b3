"""JSON Schemas that are files of the site, built from the models of the service."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import JsonSchemaMode, models_json_schema

from calibdb.schema import (
    CalibrationDocument,
    GivenCalibration,
    LookupAnswer,
    ReportedCalibration,
    VoteDocument,
)
from calibdb.schema.dump import Dump, Statistics

CALIBRATION_VERSION = 1
"""Another one removes a member, or gives it another meaning; new members do not change it."""
CALIBRATION_SCHEMA_KEY = f"docs/schema/calibration-{CALIBRATION_VERSION}.json"
DUMP_SCHEMA_KEY = "data/schema.json"


def files() -> dict[str, str]:
    """Return the content of each file, by its key."""
    return {CALIBRATION_SCHEMA_KEY: calibration(), DUMP_SCHEMA_KEY: dump()}


def calibration() -> str:
    """Return the schema of a calibration document."""
    models = (LookupAnswer, ReportedCalibration, GivenCalibration)
    definitions = _definitions(models, "validation")
    lookup, reported, stored = (definitions.pop(model.__name__) for model in models)
    return _text(
        {
            "$id": f"/{CALIBRATION_SCHEMA_KEY}",
            "title": f"Calibration of calibDB, version {CALIBRATION_VERSION}",
            "description": "As a lookup, GET /v1/calibrations/{id} and the export format calibdb return it, "
            "and as the Python client saves it. Only what makes a camera is required.",
            "type": "object",
            "properties": lookup["properties"] | reported["properties"],
            "required": stored["required"],
            "$defs": definitions,
        }
    )


def dump() -> str:
    """Return the schema of a dump."""
    return _text(
        {
            "title": "Dump of calibDB, version 1",
            "description": "Of /dumps/latest.json. $defs also has Statistics, of /dumps/statistics.json, and "
            "the documents in the files, one a line: CalibrationDocument and VoteDocument.",
            "$ref": "#/$defs/Dump",
            "$defs": _definitions((Dump, Statistics, CalibrationDocument, VoteDocument), "serialization"),
        }
    )


def _definitions(models: tuple[type[BaseModel], ...], mode: JsonSchemaMode) -> dict[str, Any]:
    _, schema = models_json_schema([(model, mode) for model in models], ref_template="#/$defs/{model}")
    definitions: dict[str, Any] = schema["$defs"]
    return definitions


def _text(members: Mapping[str, Any]) -> str:
    document = {"$schema": "https://json-schema.org/draft/2020-12/schema", **members}
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"
