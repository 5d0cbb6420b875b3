"""Examples of all calls, in an order in which each finds what it needs."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from infra.web_build.operations import OPERATIONS

TOKEN = "cdb_dev_local"  # noqa: S105 - that of local stacks; pages put the visitor's in its place
CREDENTIALS = {"apiToken": TOKEN, "sessionId": "SESSION_ID", "managementToken": "MANAGEMENT_TOKEN"}
"""Placeholders of credentials in code, by their names in the OpenAPI document."""
SCENARIO = (
    *("health", "createToken", "showToken", "changeToken", "verifyToken", "rotateToken", "showUsage"),
    *("lookup", "visitLookup", "searchCameras", "showCamera", "showCalibration", "showBadge", "convertFile"),
    "lookupKnown",
    *("openSession", "startSession", "showPose", "submitView", "showSession", "undoView", "checkCalibration"),
    *("licenseSession", "forgetSession", "submitViews", "finishSession"),
    *("createRig", "openMoment", "showRig", "undoMoment", "forgetRig", "finishRig", "showRigResult"),
    "revokeToken",
)
"""Names of all operations. `recorded_examples.prepare_call` makes what some of them want."""


@dataclass(frozen=True)
class Call:
    """One example as it is sent."""

    name: str
    method: str
    path: str
    credential: str | None
    body: Any = None
    query: Mapping[str, str] = field(default_factory=dict)
    accept: str | None = None
    path_values: Mapping[str, str] = field(default_factory=dict)
    """Example values of the path's parameters, without those of ids."""


def calls() -> Iterator[Call]:
    """Yield the example of each operation in the order of `SCENARIO`, with its placeholders."""
    operations = {operation.name: operation for operation in OPERATIONS}
    for name in SCENARIO:
        operation = operations[name]
        credential = next((CREDENTIALS[one] for one in operation.credentials if one in CREDENTIALS), None)
        identity = "RIG_ID" if operation.tag == "Rigs" else "CALIBRATION_ID"
        path = operation.path.format(**{"id": identity, "key": "CAMERA_KEY", **operation.example_path})
        yield Call(
            name,
            operation.method.upper(),
            path,
            credential,
            operation.example,
            dict(operation.example_query),
            operation.example_accept,
            operation.example_path,
        )


def learn(values: dict[str, str], name: str, answer: Any) -> None:
    """Store values of a response for the placeholders of later examples."""
    match name:
        case "createToken":
            values["MANAGEMENT_TOKEN"] = answer["management_token"]
        case "openSession":
            values["SESSION_ID"] = answer["session_id"]
        case "lookup":
            values["CALIBRATION_ID"] = answer["id"]
        case "createRig":
            values["RIG_ID"] = answer["rig_id"]
        case "searchCameras":
            values["CAMERA_KEY"] = answer["cameras"][0]["key"]


def fill_in(text: str, values: Mapping[str, str]) -> str:
    """Put values in the place of their placeholders."""
    for placeholder, value in values.items():
        text = text.replace(placeholder, value)
    return text
