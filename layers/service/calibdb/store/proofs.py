"""Proofs of origins that were found: `PROOF#<token id>/<origin>`, the unix time."""

from calibdb.errors import UnavailableError
from calibdb.schema.managed_token import ProofAnswer, ProofRequest
from calibdb.store.ports import Jobs, Table, encoded

_EXPIRY_S = 3600


def store_proof(table: Table, token_id: str, origin: str, now: int) -> None:
    """Store that the proof was found."""
    table.put({"pk": _pk(token_id), "sk": origin, "found": now, "ttl": now + _EXPIRY_S})


class Proofs:
    """Proofs, fetched by the job `verify`."""

    def __init__(self, table: Table, jobs: Jobs) -> None:
        self._table = table
        self._jobs = jobs

    def fetch(self, token_id: str, origin: str, now: int) -> ProofAnswer:
        """Have the proof fetched; raises UnavailableError if the service itself fails."""
        request = ProofRequest(token_id=token_id, origin=origin)
        content = self._jobs.now("verify", encoded(request))
        if content is None:
            raise UnavailableError("The service could not look for the proof; try again.")
        answer = ProofAnswer.model_validate_json(content)
        if answer.failure is None and not self._is_found(token_id, origin, now):
            raise UnavailableError("The service could not keep the proof; try again.")
        return answer

    def _is_found(self, token_id: str, origin: str, now: int) -> bool:
        item = self._table.get(_pk(token_id), origin)
        return item is not None and item["found"] >= now - _EXPIRY_S  # clocks may differ by some seconds


def _pk(token_id: str) -> str:
    return f"PROOF#{token_id}"
