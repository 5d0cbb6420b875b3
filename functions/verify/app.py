"""Verify: looks for the proof of an origin and stores that it was found. Only `tokens` invokes it.

Only this function connects to a host that a user names. So its role may only write that note.
"""

import os
import time
from collections.abc import Mapping
from typing import Any

from calibdb import proof
from calibdb.schema.managed_token import ProofAnswer, ProofFailure, ProofRequest
from calibdb.schema.origins import proof_content, proof_host
from calibdb.store.proofs import store_proof
from calibdb.store.storage import storage_named


def handler(event: Mapping[str, Any], _: Any) -> dict[str, Any]:
    """Return whether the origin's file has the line of the token."""
    request = ProofRequest.model_validate(dict(event))
    failure = _look_for(request)
    if failure is None:
        region = os.environ["AWS_REGION"]
        table = storage_named(region, os.environ["TABLE_NAME"]).table
        store_proof(table, request.token_id, request.origin, int(time.time()))
    return ProofAnswer(failure=failure).model_dump(mode="json")


def _look_for(request: ProofRequest) -> ProofFailure | None:
    host = proof_host(request.origin)
    if host is None:
        return "name"
    try:
        text = proof.read_proof(host)
    except proof.ProofError as error:
        return error.reason
    lines = {line.strip() for line in text.splitlines()}
    return None if proof_content(request.token_id) in lines else "content"
