"""API tokens in the index: `TOKEN#<id>/META`."""

from __future__ import annotations

from calibdb.store.table import ABSENT, Table
from calibdb.tokens import ApiToken


class Tokens:
    """What the operator issued."""

    def __init__(self, table: Table) -> None:
        self._table = table

    def get(self, token_id: str) -> ApiToken | None:
        """Return the token, None when there is none (any more)."""
        item = self._table.get(f"TOKEN#{token_id}", "META", consistent=False)
        if item is None:
            return None
        origins = item.get("origins", [])
        return ApiToken(
            id=token_id,
            secret_sha256=str(item["secret_sha256"]),
            origins=tuple(origins) if isinstance(origins, list) else (),
            plan=str(item.get("plan", "free")),
            created=int(str(item.get("created", 0))),
        )

    def create(self, token: ApiToken) -> bool:
        """Store a new token; False when the id is taken."""
        return self._table.put(
            {
                "pk": f"TOKEN#{token.id}",
                "sk": "META",
                "secret_sha256": token.secret_sha256,
                "origins": list(token.origins),
                "plan": token.plan,
                "created": token.created,
            },
            ABSENT,
        )

    def revoke(self, token_id: str) -> None:
        """Forget the token; functions that remember it do so for a minute more."""
        self._table.delete(f"TOKEN#{token_id}", "META")
