"""The public dump, written in parts: bounded in memory, and continued after a crash.

A part is one object of JSON Lines, compressed. After each part the draft says how far the dump is, so that an
invocation works as long as its time allows and the next one continues. `latest.json` names a dump only when
it is complete; until then it names the previous one.
"""

from __future__ import annotations

import gzip
import hashlib
import io
import itertools
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import UTC, datetime

from pydantic import ValidationError

from calibdb.dump.figures import Figures
from calibdb.dump.public_copy import Alias, aliases, public_copy
from calibdb.schema import CalibrationDocument, VoteDocument
from calibdb.schema.documents import GivenDocument
from calibdb.schema.dump import Dump, DumpCounts, DumpDraft, DumpedKind, DumpFile, Tally
from calibdb.store.dumps import FOLDER, GZIP, LATEST, Dumps
from calibdb.store.keys import with_tombstones
from calibdb.store.ports import READERS

PERIOD_S = 6 * 86_400  # from one dump to the next at least: a little less than the week of the schedule
MAX_PART_BYTES = 32 * 2**20  # of documents, before compression
MIN_PART_S = 60.0  # that an invocation must have left to begin another batch
_MAX_BATCH_DOCUMENTS = 64  # read at a time
_DIGITS = 12  # of a digest that is counted: 48 bits, which two of a million share with a chance of 0.2 %
_STALE_S = 5 * 86_400  # an abandoned draft is started again
_MODELS: dict[DumpedKind, type[GivenDocument]] = {
    "calibrations": CalibrationDocument,
    "votes": VoteDocument,
}
_FOLLOWING: dict[DumpedKind, DumpedKind | None] = {"calibrations": "votes", "votes": None}


@dataclass(frozen=True)
class WeeklyDump:
    """Writer of dumps.

    Attributes
    ----------
    dumps, figures
        Store of dumps, and counter of the database's figures.
    now
        Unix time, seconds.
    random_hex
        Random text of so many bytes.
    seconds_left
        Seconds left of this invocation.
    max_part_bytes
        Size of a part before compression.
    """

    dumps: Dumps
    figures: Figures
    now: Callable[[], int]
    random_hex: Callable[[int], str]
    seconds_left: Callable[[], float]
    max_part_bytes: int = MAX_PART_BYTES

    def run(self, *, force: bool = False) -> Dump | None:
        """Continue the dump that is due; return it once it is whole, None if it is not or none is due.

        `force`: one is due now.
        """
        version = self.dumps.draft()
        if version is not None and version[0].started < self.now() - _STALE_S:
            self.dumps.end()
            version = None
        if version is None:
            if not force and not self._is_due():
                return None
            self.dumps.begin(self._new_draft())
            version = self.dumps.draft()
            if version is None:
                return None
        draft, tag = version
        while True:
            following = self._write_part(draft)
            if following is None:
                return self._publish(draft)
            # Another writer is at it, or this one was; the draft decides whose part counts.
            advanced = self.dumps.advance(following, tag)
            if advanced is None or self.seconds_left() < MIN_PART_S:
                return None
            draft, tag = following, advanced

    def _is_due(self) -> bool:
        latest = self.dumps.latest()
        return latest is None or latest.created <= self.now() - PERIOD_S

    def _new_draft(self) -> DumpDraft:
        now = self.now()
        name = datetime.fromtimestamp(now, UTC).strftime("%Y-%m-%dT%H%M%SZ")
        return DumpDraft(name=name, started=now, key=self.random_hex(32))

    def _write_part(self, draft: DumpDraft) -> DumpDraft | None:
        """Write the next part; return the draft after it, None if the dump is whole."""
        if draft.complete:
            return None
        alias = aliases(draft.key)
        counting = Counting(draft.tally, alias)
        count, written, after, whole = 0, 0, draft.after, True
        buffer = io.BytesIO()
        with gzip.GzipFile(fileobj=buffer, mode="wb", mtime=0) as lines:
            for name, content, withdrawn in self._documents(f"{draft.kind}/", draft.after):
                late = self.seconds_left() < MIN_PART_S and after != draft.after
                if late or written >= self.max_part_bytes:
                    whole = False
                    break
                after = name
                document = _parse(draft.kind, content)
                if document is None or withdrawn:
                    continue
                copy = public_copy(document, alias)
                counting.add(document, given=copy is not None)
                if copy is not None:
                    line = copy.model_dump_json().encode() + b"\n"
                    lines.write(line)
                    written += len(line)
                    count += 1
        files = draft.files
        if count or (whole and not any(file.kind == draft.kind for file in files)):
            files = (*files, self._store(draft, buffer.getvalue(), count))
        changed = draft.model_copy(update={"after": after, "files": files, "tally": counting.tally()})
        if not whole:
            return changed
        following = _FOLLOWING[draft.kind]
        # A dump is published from a draft that says so: a crash until then repeats only that step.
        ended = {"complete": True} if following is None else {"kind": following, "after": ""}
        return changed.model_copy(update=ended)

    def _store(self, draft: DumpDraft, content: bytes, count: int) -> DumpFile:
        number = sum(file.kind == draft.kind for file in draft.files) + 1
        digest = hashlib.sha256(content).hexdigest()
        # With its digest: a writer that was overtaken replaces no part that another has named.
        name = f"{draft.name}/{draft.kind}-{number:05}-{digest[:8]}.jsonl.gz"
        self.dumps.write(FOLDER + name, content, GZIP)
        return DumpFile(name=name, kind=draft.kind, count=count, size=len(content), sha256=digest)

    def _documents(self, prefix: str, after: str) -> Iterator[tuple[str, bytes | None, bool]]:
        """Yield name, content and withdrawal of stored documents in order."""
        with ThreadPoolExecutor(READERS) as readers:
            for batch in _batches(with_tombstones(self.dumps.sources(prefix, after)), _MAX_BATCH_DOCUMENTS):
                contents = readers.map(self.dumps.read, [source for _, source, _ in batch])
                for (last, _, withdrawn), content in zip(batch, contents, strict=True):
                    yield last, content, withdrawn

    def _publish(self, draft: DumpDraft) -> Dump:
        counts = draft.tally.given.model_copy(
            update={"cameras": len(draft.tally.given_cameras), "contributors": len(draft.tally.givers)}
        )
        dump = Dump(
            name=draft.name,
            created=draft.started,
            counts=counts,
            size=sum(file.size for file in draft.files),
            files=draft.files,
        )
        self.figures.write(draft)
        self.dumps.write(LATEST, dump.model_dump_json(indent=1).encode())
        self.dumps.end()
        return dump


class Counting:
    """Tally that continues another."""

    def __init__(self, begun: Tally, alias: Alias) -> None:
        self._alias = alias
        self._calibrations = begun.calibrations
        self._given, self._votes = begun.given.calibrations, begun.given.votes
        self._contributors, self._cameras = set(begun.contributors), set(begun.cameras)
        self._givers, self._given_cameras = set(begun.givers), set(begun.given_cameras)

    def add(self, document: GivenDocument, *, given: bool) -> None:
        """Count a document; `given`: it is in the dump."""
        contributor = self._alias(document.counted_as)[:_DIGITS]
        if given:
            self._givers.add(contributor)
        if isinstance(document, VoteDocument):
            self._votes += given
            return
        camera = self._alias(document.current_key)[:_DIGITS]
        self._calibrations += 1
        self._contributors.add(contributor)
        self._cameras.add(camera)
        if given:
            self._given += 1
            self._given_cameras.add(camera)

    def tally(self) -> Tally:
        """Return the tally as it is now."""
        return Tally(
            calibrations=self._calibrations,
            contributors=frozenset(self._contributors),
            cameras=frozenset(self._cameras),
            given=DumpCounts(calibrations=self._given, votes=self._votes),
            givers=frozenset(self._givers),
            given_cameras=frozenset(self._given_cameras),
        )


def _batches(items: Iterator[tuple[str, str, bool]], size: int) -> Iterator[list[tuple[str, str, bool]]]:
    while batch := list(itertools.islice(items, size)):
        yield batch


def _parse(kind: DumpedKind, content: bytes | None) -> GivenDocument | None:
    """Parse a stored document; None of one that is gone, or of a later version."""
    if content is None:
        return None
    try:
        return _MODELS[kind].model_validate_json(content)
    except ValidationError:
        return None
