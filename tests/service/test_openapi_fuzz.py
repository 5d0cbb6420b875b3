"""Every operation of the OpenAPI document under requests made of it, right ones and wrong ones.

No 500, no status, content type, header or body that the document does not promise. `make fuzz` sends 5,000;
with `SEED=1` other ones.
"""

import math
import os

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from schemathesis import APIOperation, Case, GenerationMode
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from calibdb.store.aliases import alias_digest
from infra.server.server import Server
from infra.web_build import openapi
from tests.helpers.service.client import CAMERA, TOKEN, Client, Truth
from tests.helpers.service.published import calibration, publish
from tests.helpers.service.rigs import RigTruth

JOBS = False

CASES = int(os.environ.get("CASES", "50"))
MAX_ANSWER_S = 120
"""Seconds to wait for an answer: only a failure takes them, and a busy machine is none."""
SEED = int(os.environ.get("SEED", "0"))
CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
]
API = schemathesis.openapi.from_dict(openapi.document())
OPERATIONS = {operation.ok().label: operation.ok() for operation in API.get_all_operations()}
#: Nothing is a wrong question about health, a badge or a known camera: of texts, all are taken.
NEVER_WRONG = {
    ("GET /healthz", GenerationMode.NEGATIVE),
    ("GET /badge/{key}/{file}", GenerationMode.NEGATIVE),
    ("GET /known/v1/{digest}/{size}/{zoom}/{file}", GenerationMode.NEGATIVE),
}
EACH = math.ceil(CASES / (2 * len(OPERATIONS) - len(NEVER_WRONG)))  # of the right ones, and of the wrong ones


@pytest.fixture(scope="module")
def known(stack: Server) -> dict[str, list[str]]:
    client = Client(stack)
    documents = [calibration(str(CAMERA["camera"]), n) for n in range(5)]
    publish(stack, *documents)
    consensus = client.lookup().json["id"]
    return {
        "id": [documents[0].id, consensus],
        "key": [documents[0].camera_key],
        "index": ["0", "1"],
        "file": ["1280x720.svg", "1x1.svg", "rectilinear.json", "fisheye.json"],
        "digest": [alias_digest(CAMERA["camera"], CAMERA["platform"]), "0" * 32],
        "size": ["1280x720", "640x360", "0x1"],
        "zoom": ["0", "1.5"],
    }


@pytest.fixture(scope="module")
def rigs() -> list[RigTruth]:
    """Rigs that were made; the last of them is still as `running_rig` wants it, or not."""
    return []


def running_rig(stack: Server, rigs: list[RigTruth]) -> RigTruth:
    if rigs:
        found = rigs[-1].call("GET")
        there = [moment["id"] for moment in found.json.get("moments", ())]
        if found.status == 200 and found.json["status"] == "capturing" and there == ["m0"]:
            return rigs[-1]
    rigs.append(RigTruth(stack).open())
    for moment in ("m0", "m1"):
        rigs[-1].moment(moment)
    rigs[-1].call("DELETE", "/moments/m1")
    return rigs[-1]


def requests(operation: APIOperation, known: dict[str, list[str]]) -> st.SearchStrategy[Case]:
    anything = operation.as_strategy()
    names = {parameter.name for parameter in operation.path_parameters}
    if not names:
        return anything
    there = st.fixed_dictionaries({name: st.sampled_from(known[name]) for name in names})
    return anything | there.flatmap(lambda found: operation.as_strategy(path_parameters=found))


@pytest.mark.parametrize(
    ("label", "mode"),
    [(label, mode) for label in OPERATIONS for mode in GenerationMode if (label, mode) not in NEVER_WRONG],
)
def test_every_response_conforms_to_openapi(
    stack: Server,
    url: str,
    known: dict[str, list[str]],
    finished_rig: RigTruth,
    rigs: list[RigTruth],
    label: str,
    mode: GenerationMode,
) -> None:
    operation = OPERATIONS[label]
    client = Client(stack)
    credential = TOKEN
    if operation.path.startswith("/v1/rigs"):
        rig = running_rig(stack, rigs)
        credential = rig.clients[0].session_id
        known = {"id": [rig.rig_id, finished_rig.rig_id], "moment": ["m0", "m1"]}
    elif any("sessionId" in security for security in operation.definition.raw.get("security", ())):
        client.open()
        Truth().show(client)
        credential = client.session_id
    right = mode is GenerationMode.POSITIVE
    cases = requests(operation, known) if right else operation.as_strategy(generation_mode=mode)

    @seed(SEED)
    @settings(
        max_examples=EACH,
        deadline=None,
        database=None,
        phases=[Phase.generate],  # a failure is reported as it was found; shrinking sends thousands more
        suppress_health_check=list(HealthCheck),
    )
    @given(case=cases)
    def sent(case: Case) -> None:
        headers = {"Authorization": f"Bearer {credential}"}
        response = case.call(base_url=url, headers=headers, timeout=MAX_ANSWER_S)
        case.validate_response(response, checks=CHECKS)

    sent()
