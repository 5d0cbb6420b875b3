"""API tokens: objects `tokens/<id>.json`, written by the operator, and index items, read by functions."""

from __future__ import annotations

from collections.abc import Iterator

from calibdb.access.tokens import ApiToken
from calibdb.schema import TokenDocument
from calibdb.store.objects import Objects
from calibdb.store.table import Item, Table

PREFIX = "tokens/"


class Tokens:
    """Store of issued API tokens."""

    def __init__(self, table: Table, objects: Objects) -> None:
        self._table = table
        self._objects = objects

    def get(self, token_id: str) -> ApiToken | None:
        """Return the token, None when there is none (any more)."""
        item = self._table.get(_pk(token_id), "META", consistent=False)
        return _token(token_id, item) if item else None

    def create(self, token: ApiToken) -> bool:
        """Store a new token; False when the id is taken, be it by one that was revoked."""
        if not self._objects.create(_name(token.id), _content(token, None)):
            return False
        self.index(token)
        return True

    def change(self, token: ApiToken) -> None:
        """Store the token in the place of the one with its id."""
        self._objects.put(_name(token.id), _content(token, None))
        self.index(token)

    def revoke(self, token: ApiToken, now: int) -> None:
        """Refuse the token from now on; functions that remember it do so for half a minute more.

        The object says so first: an index that is made anew does not bring a revoked token back.
        """
        self._objects.put(_name(token.id), _content(token, now))
        self._table.delete(_pk(token.id), "META")

    def index(self, token: ApiToken) -> None:
        """Write the index item; it follows from the token."""
        self._table.put(_item(token))

    def all(self) -> Iterator[ApiToken]:
        """Yield every token in the bucket that was not revoked. For operators."""
        for document in self._documents():
            if document.revoked is None:
                yield ApiToken(
                    id=document.id,
                    secret_sha256=document.secret_sha256,
                    origins=document.origins,
                    plan=document.plan,
                    created=document.created,
                    former_sha256=document.former_sha256,
                    former_until=document.former_until,
                )

    def ids(self) -> Iterator[str]:
        """Yield the id of every token that there ever was, revoked ones, too. For operators."""
        for name in self._objects.names(PREFIX):
            yield name.removeprefix(PREFIX).removesuffix(".json")

    def reindex(self) -> int:
        """Let the index know every token that there is, none that was revoked; return how many there are."""
        tokens = list(self.all())
        for token in tokens:
            self.index(token)
        for document in self._documents():
            if document.revoked is not None:
                self._table.delete(_pk(document.id), "META")
        return len(tokens)

    def _documents(self) -> Iterator[TokenDocument]:
        for name in self._objects.names(PREFIX):
            content = self._objects.get(name)
            if content is not None:
                yield TokenDocument.model_validate_json(content)


def _pk(token_id: str) -> str:
    return f"TOKEN#{token_id}"


def _name(token_id: str) -> str:
    return f"{PREFIX}{token_id}.json"


def _content(token: ApiToken, revoked: int | None) -> bytes:
    return TokenDocument(**vars(token), revoked=revoked).model_dump_json().encode()


def _item(token: ApiToken) -> Item:
    item: Item = {
        "pk": _pk(token.id),
        "sk": "META",
        "secret_sha256": token.secret_sha256,
        "origins": list(token.origins),
        "plan": token.plan,
        "created": token.created,
    }
    if token.former_sha256 is not None:
        item |= {"former_sha256": token.former_sha256, "former_until": token.former_until}
    return item


def _token(token_id: str, item: Item) -> ApiToken:
    origins = item.get("origins", [])
    former = item.get("former_sha256")
    return ApiToken(
        id=token_id,
        secret_sha256=str(item["secret_sha256"]),
        origins=tuple(origins) if isinstance(origins, list) else (),
        plan=str(item.get("plan", "free")),
        created=int(str(item.get("created", 0))),
        former_sha256=None if former is None else str(former),
        former_until=int(str(item.get("former_until", 0))),
    )
