"""Proofs of origins that were found: `PROOF#<token id>/<origin>`, the unix time. And asking for them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from calibdb.errors import UnavailableError
from calibdb.schema.managed_token import ProofAnswer, ProofRequest
from calibdb.store.clients import available
from calibdb.store.table import Table

if TYPE_CHECKING:
    from collections.abc import Callable

    from mypy_boto3_lambda import LambdaClient

_EXPIRY_S = 3600  # s; whoever asked reads it at once


def store_proof(table: Table, token_id: str, origin: str, now: int) -> None:
    """Note that the proof was found."""
    table.put({"pk": _pk(token_id), "sk": origin, "found": now, "ttl": now + _EXPIRY_S})


class Proofs:
    """Proofs, fetched by another function, which notes what it found."""

    def __init__(self, table: Table, client: Callable[[], LambdaClient], function: str | None) -> None:
        self._table = table
        self._client = client
        self._function = function

    def fetch(self, token_id: str, origin: str, now: int) -> ProofAnswer:
        """Have the proof fetched; raises UnavailableError where that fails for a reason of ours."""
        if self._function is None:
            raise ValueError("VERIFY_FUNCTION is not set for a function that needs it")
        request = ProofRequest(token_id=token_id, origin=origin)
        with available():
            answer = self._client().invoke(
                FunctionName=self._function,
                InvocationType="RequestResponse",
                Payload=request.model_dump_json().encode(),
            )
            content = answer["Payload"].read()
        if "FunctionError" in answer:
            raise UnavailableError("The service could not look for the proof; try again.")
        found = ProofAnswer.model_validate_json(content)
        if found.failure is None and not self._is_found(token_id, origin, now):
            raise UnavailableError("The service could not keep the proof; try again.")
        return found

    def _is_found(self, token_id: str, origin: str, now: int) -> bool:
        """Tell whether a proof was stored lately: the clocks of two functions may differ by some seconds."""
        item = self._table.get(_pk(token_id), origin)
        return item is not None and int(str(item["found"])) >= now - _EXPIRY_S


def _pk(token_id: str) -> str:
    return f"PROOF#{token_id}"
