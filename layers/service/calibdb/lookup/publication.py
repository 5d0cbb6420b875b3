"""Publication of lookups' answers at the edge: objects that say what a lookup would say at this moment.

Whoever changes what a lookup answers calls `refresh` before the change is acknowledged. It compares, alias by
alias, what a lookup answers now with what was written, under a lock for each camera key, and reads the index
only once it holds the lock: so whoever changed the index last also writes last.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace

from calibdb.camera_key import identify
from calibdb.errors import UnavailableError
from calibdb.lookup.edge_content import (
    Answers,
    Name,
    Read,
    answers,
    has_hit,
    is_public,
    name_keys,
    object_of,
    reader,
)
from calibdb.schema import Sighting
from calibdb.settings import Settings
from calibdb.store import Alias, Store, StreamMode
from calibdb.store.aliases import MAX_ALIASES
from calibdb.store.edge_answers import etag_of
from calibdb.store.locks import LEASE_S
from calibdb.store.ports import READERS

MAX_PENDING_PER_SOURCE = 8  # aliases of a camera that one source alone asked by
PENDING_DAYS, ASKED_DAYS = 7, 90  # days after which an alias that no calibration bears is forgotten
_DAY_S = 86_400
_BATCH = 2 * READERS  # objects that are written between two renewals of the lock
_MAX_WAIT_S = LEASE_S + 5.0  # for a lock
_MIN_PAUSE_S, _MAX_PAUSE_S = 0.02, 1.0  # between two attempts to take it
_MAX_PUTS = 3  # at one object that is not what was written down


@dataclass(frozen=True)
class _Write:
    """One object to write. `before`: ETag of the one that is there, None: there is none."""

    digest: str  # of the alias
    mode: str
    name: str
    content: bytes
    before: str | None


class Publication:
    """Answers at the edge of one deployment.

    Parameters
    ----------
    store, settings
        Of the deployment.
    clock
        Unix seconds.
    me
        Holder of the locks: the same for every attempt of one request.
    wait
        Waits so many seconds for a lock that another holds.
    """

    def __init__(
        self,
        store: Store,
        settings: Settings,
        clock: Callable[[], float],
        me: str,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self._store = store
        self._thresholds = settings.thresholds
        self._on = settings.edge_answers
        self._clock = clock
        self._me = me
        self._wait = wait

    @property
    def _now(self) -> int:
        return int(self._clock())

    def refresh(
        self,
        mode: StreamMode,
        seen: Iterable[Name] = (),
        *,
        changed: bool,
    ) -> None:
        """Let the edge say what lookups answer, under every alias that depends on this camera.

        Parameters
        ----------
        mode
            The camera whose entries in the index changed, and where.
        seen
            Labels and platforms of calibrations that count, which become aliases.
        changed
            Whether the caller changed something. If not, only what a crash left behind is looked for.
        """
        if self._store.edge_answers.bucket is None:
            return
        camera_key, seen = mode.camera_key, list(dict.fromkeys(seen))
        # Of one calibration at least the name is known, even where none counts.
        called = self._store.calibrations.name_at(mode)
        names = {*seen, *(alias.name for alias in self._store.aliases.of(camera_key))}
        names |= {called} if called else set()
        new = [name for name in seen if is_public(name) and identify(*name).key == camera_key]
        self._refresh_one(camera_key, new, changed=changed)
        for key in sorted(name_keys(names) - {camera_key}):
            self._refresh_one(key, (), changed=changed)

    def rebuild(
        self, camera_key: str, etags: Mapping[str, str], borne: Set[Name], *, forget_pending: bool
    ) -> None:
        """Refresh one camera key, whatever was written down; for operators.

        Parameters
        ----------
        camera_key
            The key that has the aliases.
        etags
            ETags of the objects in the bucket by name. What differs is written anew.
        borne
            Labels and platforms of all calibrations. Aliases that none of them bears are forgotten, unless
            lookups still hit under them.
        forget_pending
            Whether to forget aliases that are not confirmed.
        """
        if self._store.edge_answers.bucket is None:
            return
        with self._hold_lock(camera_key):
            read = reader(self._store)
            for alias in self._store.aliases.of(camera_key):
                wanted = self._required_objects(read, alias)
                gone = alias.name not in borne if alias.seen else alias.confirmed and not wanted
                if gone or (forget_pending and not alias.confirmed):
                    self._evict(camera_key, alias)
            self._rewrite(camera_key, (), etags)

    def record(self, sighting: Sighting) -> None:
        """Write down an alias under which a lookup hit; its objects follow once enough have asked by it."""
        name = sighting.label, sighting.platform
        key = identify(*name).key
        if self._store.edge_answers.bucket is None or not self._on or not is_public(name):
            return
        if not has_hit(reader(self._store), name, private=self._private):
            return
        with self._hold_lock(key):
            aliases = self._store.aliases.of(key)
            merged = self._with_sighting(aliases, sighting)
            if merged is not None:
                self._store.aliases.put(key, merged)
                self._rewrite(key, ())

    def _refresh_one(self, key: str, seen: Sequence[Name], *, changed: bool) -> None:
        if not seen and not self._store.aliases.of(key):
            return
        # A writer that took the lock before may have read the index before it was changed.
        unchanged = not changed and not self._store.locks.is_held(key, self._now)
        if unchanged and not self._is_outdated(key, seen):
            return
        with self._hold_lock(key):
            self._rewrite(key, seen)

    def _is_outdated(self, key: str, seen: Sequence[Name]) -> bool:
        read, aliases = reader(self._store), self._store.aliases.of(key)
        if set(seen) - {alias.name for alias in aliases if alias.seen} and len(aliases) < MAX_ALIASES:
            return True
        return any(_etags(self._required_objects(read, alias)) != dict(alias.objects) for alias in aliases)

    def _rewrite(self, key: str, seen: Sequence[Name], etags: Mapping[str, str] | None = None) -> None:
        """Make the objects of every alias of the key what lookups answer. The lock is held."""
        aliases = self._admit(key, seen)
        read = reader(self._store)  # only now: whoever changes the index sees the aliases, and waits
        wanted = {alias.digest: self._required_objects(read, alias) for alias in aliases}
        writes: list[_Write] = []
        removals: list[str] = []
        changed: list[Alias] = []
        for alias in aliases:
            pending = self._compare(alias, wanted[alias.digest], etags, writes, removals)
            if pending != dict(alias.objects):
                self._store.aliases.put(key, replace(alias, objects=pending))
            if "" in pending.values():
                changed.append(alias)
        if removals:
            self._renew(key)
            self._store.edge_answers.delete(removals)
        written = self._write(key, writes)
        for alias in changed:
            done = _etags(wanted[alias.digest]) | written.get(alias.digest, {})
            self._store.aliases.put(key, replace(alias, objects=done))
        self._store.aliases.put_list(key, aliases)

    def _compare(
        self,
        alias: Alias,
        wanted: Answers,
        etags: Mapping[str, str] | None,
        writes: list[_Write],
        removals: list[str],
    ) -> dict[str, str]:
        """Collect what is to be written and removed; return the objects as they are written down ahead."""
        objects = dict(alias.objects)
        for mode in objects.keys() - wanted.keys():
            removals.append(object_of(alias.name, mode))
            objects[mode] = ""
        for mode, (name, content) in wanted.items():
            recorded = alias.objects.get(mode)
            there = etags.get(name) if etags is not None else recorded
            if there == "":  # a writer crashed, and what is there may be anything
                removals.append(name)
                there = None
            if there != etag_of(content) or recorded != there:
                writes.append(_Write(alias.digest, mode, name, content, there))
                objects[mode] = ""
        return objects

    def _write(self, key: str, writes: Sequence[_Write]) -> dict[str, dict[str, str]]:
        """Write the objects; return their ETags by alias and mode."""
        done: dict[str, dict[str, str]] = {}
        for start in range(0, len(writes), _BATCH):
            batch = writes[start : start + _BATCH]
            self._renew(key)
            with ThreadPoolExecutor(min(READERS, len(batch))) as writers:
                for write, etag in zip(batch, writers.map(self._put, batch), strict=True):
                    done.setdefault(write.digest, {})[write.mode] = etag
        return done

    def _put(self, write: _Write) -> str:
        before = write.before
        for _ in range(_MAX_PUTS):
            if before == etag_of(write.content):
                return before
            etag = self._store.edge_answers.put(write.name, write.content, before)
            if etag is not None:
                return etag
            self._store.edge_answers.delete([write.name])
            before = None
        raise UnavailableError("An answer at the edge keeps being written by others; try again.")

    def _admit(self, key: str, seen: Sequence[Name]) -> list[Alias]:
        """Return the aliases of the key with those newly seen, and without those that nobody asks by."""
        aliases = {alias.digest: alias for alias in self._store.aliases.of(key)}
        for alias in list(aliases.values()):
            if not alias.seen and self._is_expired(alias):
                self._evict(key, alias)
                del aliases[alias.digest]
        for label, platform in seen:
            new = Alias(label, platform, seen=True)
            known = aliases.get(new.digest)
            if (known is None and len(aliases) < MAX_ALIASES) or (known is not None and not known.seen):
                aliases[new.digest] = replace(new, objects=known.objects if known else {})
                self._store.aliases.put(key, aliases[new.digest])
        return [aliases[digest] for digest in sorted(aliases)]

    def _evict(self, key: str, alias: Alias) -> None:
        """Forget an alias with its objects. The lock is held."""
        self._store.edge_answers.delete([object_of(alias.name, mode) for mode in alias.objects])
        self._store.aliases.remove(key, alias)

    def _is_expired(self, alias: Alias) -> bool:
        days = ASKED_DAYS if alias.confirmed else PENDING_DAYS
        return self._now - alias.time > days * _DAY_S

    def _with_sighting(self, aliases: Sequence[Alias], sighting: Sighting) -> Alias | None:
        """Return the alias with one more source behind it; None where nothing is to be written down."""
        asked = Alias(sighting.label, sighting.platform)
        known = next((alias for alias in aliases if alias.digest == asked.digest), None)
        if known is not None and (known.confirmed or sighting.source in known.sources):
            return None
        sources = (*(known.sources if known else ()), sighting.source)
        if len(sources) >= self._thresholds.min_contributors:
            sources = ()
        elif known is None and (
            sum(sighting.source in alias.sources for alias in aliases) >= MAX_PENDING_PER_SOURCE
        ):
            return None
        if known is None and len(aliases) >= MAX_ALIASES:
            return None
        return replace(known or asked, sources=sources, time=self._now)

    def _required_objects(self, read: Read, alias: Alias) -> Answers:
        """Return the objects that the alias must have."""
        return answers(read, alias.name, private=self._private) if self._on and alias.confirmed else {}

    @property
    def _private(self) -> bool:
        return self._thresholds.min_contributors == 1

    @contextmanager
    def _hold_lock(self, key: str) -> Iterator[None]:
        """Hold the lock of a camera key within the block; raises UnavailableError if others do not let go."""
        waited, pause = 0.0, _MIN_PAUSE_S
        while not self._store.locks.take(key, self._me, self._now):
            if waited >= _MAX_WAIT_S:
                raise UnavailableError("Others keep writing the answers of this camera; try again.")
            self._wait(pause)
            waited, pause = waited + pause, min(2 * pause, _MAX_PAUSE_S)
        try:
            yield
        finally:
            self._store.locks.release(key, self._me)

    def _renew(self, key: str) -> None:
        if not self._store.locks.renew(key, self._me, self._now):
            raise UnavailableError("Another computation took over the answers of this camera; try again.")


def _etags(wanted: Answers) -> dict[str, str]:
    return {mode: etag_of(content) for mode, (_, content) in wanted.items()}
