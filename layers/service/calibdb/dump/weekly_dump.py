"""The public dump, written in parts: bounded in memory, and continued after a crash.

A part is one object of JSON Lines, compressed. After each part the draft records the progress, so that the
next invocation can continue. `latest.json` names only complete dumps.
"""

import gzip
import hashlib
import io
import itertools
import secrets
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime

from pydantic import ValidationError

from calibdb.dump.figures import Figures
from calibdb.dump.public_copy import Alias, aliases, public_copy
from calibdb.schema import CalibrationDocument, VoteDocument
from calibdb.schema.documents import GivenDocument
from calibdb.schema.dump import Dump, DumpDraft, DumpedKind, DumpFile, Tally
from calibdb.store.dumps import FOLDER, GZIP, LATEST, Dumps
from calibdb.store.keys import with_tombstones
from calibdb.store.ports import read_together

PERIOD_S = 6 * 86_400  # from one dump to the next at least: a little less than the week of the schedule
MAX_PART_BYTES = 32 * 2**20  # of documents, before compression
MIN_PART_S = 60.0  # left of an invocation that begins another batch
_MAX_BATCH_DOCUMENTS = 64  # read at a time
_DIGITS = 12  # of a digest that is counted: 48 bits, which two of a million share with a chance of 0.2 %
_STALE_S = 5 * 86_400  # after which an abandoned draft is started again
_MODELS: dict[DumpedKind, type[GivenDocument]] = {
    "calibrations": CalibrationDocument,
    "votes": VoteDocument,
}
_FOLLOWING: dict[DumpedKind, DumpedKind | None] = {"calibrations": "votes", "votes": None}


@dataclass(frozen=True)
class WeeklyDump:
    """Writer of dumps."""

    dumps: Dumps
    figures: Figures
    now: Callable[[], int]  # unix seconds
    seconds_left: Callable[[], float]  # of this invocation

    def run(self, *, force: bool = False) -> Dump | None:
        """Continue the dump that is due, or with `force` a new one; return it if it is complete."""
        version = self.dumps.draft()
        if version is not None and version[0].started < self.now() - _STALE_S:
            self.dumps.end()
            version = None
        if version is None:
            latest = self.dumps.latest()
            if not force and latest is not None and latest.created > self.now() - PERIOD_S:
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
            advanced = self.dumps.advance(following, tag)
            # Another writer may be at it; the draft decides whose part counts.
            if advanced is None or self.seconds_left() < MIN_PART_S:
                return None
            draft, tag = following, advanced

    def _new_draft(self) -> DumpDraft:
        now = self.now()
        name = datetime.fromtimestamp(now, UTC).strftime("%Y-%m-%dT%H%M%SZ")
        return DumpDraft(name=name, started=now, key=secrets.token_hex(32))

    def _write_part(self, draft: DumpDraft) -> DumpDraft | None:
        if draft.complete:
            return None
        alias = aliases(draft.key)
        tally = draft.tally.model_copy(deep=True)
        count, written, after, whole = 0, 0, draft.after, True
        buffer = io.BytesIO()
        with gzip.GzipFile(fileobj=buffer, mode="wb", mtime=0) as lines:
            for name, content, withdrawn in self._documents(f"{draft.kind}/", draft.after):
                late = self.seconds_left() < MIN_PART_S and after != draft.after
                if late or written >= MAX_PART_BYTES:
                    whole = False
                    break
                after = name
                document = _parse(draft.kind, content)
                if document is None or withdrawn:
                    continue
                copy = public_copy(document, alias)
                _count(tally, document, alias, given=copy is not None)
                if copy is not None:
                    line = copy.model_dump_json().encode() + b"\n"
                    lines.write(line)
                    written += len(line)
                    count += 1
        files = draft.files
        if count or (whole and not any(file.kind == draft.kind for file in files)):
            files = (*files, self._store(draft, buffer.getvalue(), count))
        changed = draft.model_copy(update={"after": after, "files": files, "tally": tally})
        if not whole:
            return changed
        following = _FOLLOWING[draft.kind]
        # A dump is published from a complete draft: a crash before that repeats only this step.
        ended = {"complete": True} if following is None else {"kind": following, "after": ""}
        return changed.model_copy(update=ended)

    def _store(self, draft: DumpDraft, content: bytes, count: int) -> DumpFile:
        number = sum(file.kind == draft.kind for file in draft.files) + 1
        digest = hashlib.sha256(content).hexdigest()
        # With its digest, so that a writer that was overtaken does not replace a part that another has named.
        name = f"{draft.name}/{draft.kind}-{number:05}-{digest[:8]}.jsonl.gz"
        self.dumps.write(FOLDER + name, content, GZIP)
        return DumpFile(name=name, kind=draft.kind, count=count, size=len(content), sha256=digest)

    def _documents(self, prefix: str, after: str) -> Iterator[tuple[str, bytes | None, bool]]:
        documents = self.dumps.documents
        sources = with_tombstones(documents.names(prefix, after))
        while batch := list(itertools.islice(sources, _MAX_BATCH_DOCUMENTS)):
            contents = read_together(documents, [source for _, source, _ in batch])
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


def _count(tally: Tally, document: GivenDocument, alias: Alias, *, given: bool) -> None:
    """Count a document in `tally`; `given`: it is in the dump."""
    counts = tally.given
    contributor = alias(document.counted_as)[:_DIGITS]
    if given:
        tally.givers.add(contributor)
    if isinstance(document, VoteDocument):
        tally.given = counts.model_copy(update={"votes": counts.votes + given})
        return
    camera = alias(document.current_key)[:_DIGITS]
    tally.calibrations += 1
    tally.contributors.add(contributor)
    tally.cameras.add(camera)
    if given:
        tally.given = counts.model_copy(update={"calibrations": counts.calibrations + 1})
        tally.given_cameras.add(camera)


def _parse(kind: DumpedKind, content: bytes | None) -> GivenDocument | None:
    try:
        return None if content is None else _MODELS[kind].model_validate_json(content)
    except ValidationError:  # of a later version
        return None
