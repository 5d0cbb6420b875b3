"""API tokens: objects `tokens/<id>.json`, the truth, and index items, read by functions.

Every change reads the object and replaces that very version of it, then writes the index item, which grows
by the same version. A writer that was overtaken, or killed in between, leaves an older index item. The next
change or read by its manager writes it again.
"""

import functools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from pydantic import TypeAdapter

from calibdb.access.tokens import ApiToken
from calibdb.errors import UnavailableError
from calibdb.store.ports import IF_NOT_EXISTS, DocumentStore, Item, compared

PREFIX = "tokens/"
_TOMBSTONE_S = 86_400  # s for which a revoked token's item keeps writers away that were overtaken
_ORPHANED_S = 7 * 86_400  # s after its end from which an unused trial token is removed
_MAX_ATTEMPTS = 8  # to replace an object that others replace, too


class Tokens(DocumentStore):
    """Store of issued API tokens."""

    def get(self, token_id: str) -> ApiToken | None:
        """Token."""
        item = self._item(token_id)
        return _token(token_id, item) if item and "revoked" not in item else None

    def keep(self, token_id: str) -> None:
        """Note that the token was used, so that it does not expire."""
        self._table.remove(_pk(token_id), "META", "ttl")

    def create(self, token: ApiToken) -> bool:
        """Store a new token; False if the id is taken, be it by one that was revoked."""
        if not self._objects.create(_name(token.id), _content(token)):
            return False
        self.index(token)
        return True

    def read(self, token_id: str) -> ApiToken | None:
        """Read the token from the bucket, also if revoked, and update the index.

        Its `expires` follows the index, where the first use is noted.
        """
        content = self._objects.get(_name(token_id))
        if content is None:
            return None
        token = _from_document(content)
        item = self._item(token_id)
        if item is not None and "ttl" not in item and "revoked" not in item:
            token = replace(token, expires=None)
        if item is None or item["version"] < token.version:
            self.index(token)
        return token

    def update(self, token_id: str, change: Callable[[ApiToken], ApiToken]) -> ApiToken | None:
        """Replace the token by what `change` makes of it; None, and nothing changed, if it was revoked.

        `change` is called again if another change was faster. Raises UnavailableError if that continues.
        """
        for _ in range(_MAX_ATTEMPTS):
            version = self._objects.get_version(_name(token_id))
            if version is None:
                return None
            content, tag = version
            stored = _from_document(content)
            if stored.revoked is not None:
                self.index(stored)
                return None
            item = self._item(token_id)
            used = item is not None and "ttl" not in item
            changed = change(replace(stored, expires=None) if used else stored)
            if changed == stored:
                self.index(replace(changed, version=stored.version))
                return changed
            changed = replace(changed, version=stored.version + 1)
            if self._objects.replace(_name(token_id), _content(changed), tag):
                self.index(changed)
                return changed
        raise UnavailableError("Other requests keep changing this token; send this one again.")

    def change(self, token: ApiToken) -> None:
        """Store the token in the place of the one with its id, if there is one."""
        if self.update(token.id, lambda _: token) is None:
            self._objects.put(_name(token.id), _content(token))
            self.index(token)

    def revoke(self, token: ApiToken, now: int) -> None:
        """Refuse the token from now on; functions that remember it do so for half a minute more.

        The object says so first: a rebuilt index does not revive a revoked token.
        """
        if self.update(token.id, lambda known: replace(known, revoked=now)) is None:
            self._table.delete(_pk(token.id), "META")

    def index(self, token: ApiToken) -> None:
        """Write the index item, unless it is of a later version."""
        self._table.put(_to_item(token), IF_NOT_EXISTS | compared("version", "<=", token.version))

    def all(self) -> Iterator[ApiToken]:
        """Yield every token in the bucket that was not revoked."""
        return (token for token in self._documents() if token.revoked is None)

    def ids(self) -> Iterator[str]:
        """Yield the ids of all tokens ever issued, including revoked ones."""
        for name in self._objects.names(PREFIX):
            yield name.removeprefix(PREFIX).removesuffix(".json")

    def reindex(self, now: int = 0, trial_period_s: int = 0) -> int:
        """Index every token in the bucket, remove revoked ones; return the number of valid ones.

        A rebuilt index does not know which tokens were used. So a token that the index lacks, and
        that might have expired, has its time once more.
        """
        count = 0
        for token in self._documents():
            if token.revoked is not None:
                if now < token.revoked + _TOMBSTONE_S:
                    self.index(token)
                else:
                    self._table.delete(_pk(token.id), "META")
                continue
            count += 1
            item = self._item(token.id)
            if token.expires is not None:
                expires = max(token.expires, now + trial_period_s)
                token = replace(token, expires=item.get("ttl") if item else expires)
            self.index(token)
        return count

    def orphans(self, now: int) -> list[str]:
        """List the ids of trial tokens that expired without use a week ago or earlier. For operators.

        The first use is noted in the index only. Raises UnavailableError if that lacks a token which does not
        expire: it is incomplete, and may lack trial tokens that were used.
        """
        orphans = []
        for token in self.all():
            item = self._item(token.id)
            if token.expires is None and item is None:
                raise UnavailableError(f"The index lacks the token {token.id}: run `reindex` first.")
            unused = item is None or "ttl" in item
            if token.expires is not None and unused:
                end = max(token.expires, item["ttl"] if item else 0)
                if end + _ORPHANED_S < now:
                    orphans.append(token.id)
        return orphans

    def remove(self, token_ids: Iterable[str]) -> int:
        """Remove tokens for good, every version of them; return how many."""
        ids = list(token_ids)
        for token_id in ids:
            self._table.delete(_pk(token_id), "META")
        self._objects.purge_all_versions([_name(token_id) for token_id in ids])
        return len(ids)

    def _item(self, token_id: str) -> Item | None:
        return self._table.get(_pk(token_id), "META")

    def _documents(self) -> Iterator[ApiToken]:
        for name in self._objects.names(PREFIX):
            content = self._objects.get(name)
            if content is not None:
                yield _from_document(content)


def _pk(token_id: str) -> str:
    return f"TOKEN#{token_id}"


def _name(token_id: str) -> str:
    return f"{PREFIX}{token_id}.json"


@functools.cache
def _adapter() -> TypeAdapter[ApiToken]:
    return TypeAdapter(ApiToken)


def _content(token: ApiToken) -> bytes:
    return _adapter().dump_json(token)


def _from_document(content: bytes) -> ApiToken:
    return _adapter().validate_json(content)


def _to_item(token: ApiToken) -> Item:
    item: Item = {"pk": _pk(token.id), "sk": "META", "version": token.version}
    if token.revoked is not None:
        return item | {"revoked": token.revoked, "ttl": token.revoked + _TOMBSTONE_S}
    item |= {
        "secret_sha256": token.secret_sha256,
        "origins": list(token.origins),
        "plan": token.plan,
        "created": token.created,
    }
    if token.former_sha256 is not None:
        item |= {"former_sha256": token.former_sha256, "former_until": token.former_until}
    if token.earlier:
        item["earlier"] = [f"{sha256} {until}" for sha256, until in token.earlier]
    if token.pending:
        item["pending"] = list(token.pending)
    if token.expires is not None:
        item["ttl"] = token.expires
    return item


def _token(token_id: str, item: Item) -> ApiToken:
    earlier = [text.split() for text in item.get("earlier", [])]
    return ApiToken(
        id=token_id,
        secret_sha256=item["secret_sha256"],
        origins=tuple(item["origins"]),
        plan=item["plan"],
        created=item["created"],
        former_sha256=item.get("former_sha256"),
        former_until=item.get("former_until", 0),
        earlier=tuple((sha256, int(until)) for sha256, until in earlier),
        pending=tuple(item.get("pending", [])),
        expires=item.get("ttl"),
        version=item["version"],
    )
