"""Durable storage in one process: moto's DynamoDB and S3 in memory, the journal on disk.

An operation is applied in memory, one at a time, and answered once everything applied before it, itself
included, is on disk. So neither a writer nor a reader is told of a write that a crash could undo. All threads
that wait share one sync (group commit). A write that cannot be made durable is rolled back in memory too, and
the operations that waited for it fail.
"""

from __future__ import annotations

import gc
import json
import logging
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from xml.sax.saxutils import escape

from botocore.awsrequest import AWSPreparedRequest
from moto.core.botocore_stubber import BotocoreStubber

from tests.aws.emulator import dynamodb
from tests.aws.emulator.journal import ITEM, OBJECT, Address, Change, Journal, JournalError
from tests.aws.emulator.memory import Memory
from tests.aws.emulator.operations import Call, bucket_and_key, written_keys
from tests.aws.emulator.template import BucketSpec, TableSpec
from tests.aws.emulator.versions import listing, prefix_of

_log = logging.getLogger("tests.aws.emulator.storage")


@dataclass(frozen=True)
class Answer:
    """The HTTP response of a service."""

    status: int
    headers: Mapping[str, str]
    body: bytes


class NotDurableError(Exception):
    """A write could not be made durable, and was rolled back."""


@dataclass
class _Batch:
    """Changes that go to disk together, and what became of them."""

    changes: list[Change] = field(default_factory=list)
    committed: bool = False
    error: JournalError | None = None


class Storage:
    """The template's tables and buckets, restored from the journal. Safe from many threads at once.

    Parameters
    ----------
    journal
        Where it is kept; `close` closes it.
    tables, buckets
        What there is.
    now
        Unix seconds. Items past their time to live and objects past their bucket's expiration are not
        restored.
    """

    def __init__(
        self, journal: Journal, tables: Iterable[TableSpec], buckets: Iterable[BucketSpec], now: float
    ):
        self._tables = {table.name: table for table in tables}
        self._buckets = {bucket.name: bucket for bucket in buckets}
        self._journal = journal
        self._memory = Memory(self._tables.values(), self._buckets.values())
        self._moto = BotocoreStubber()
        # Whoever needs both takes the journal's first; nobody syncs with memory locked.
        self._journal_lock = threading.Lock()
        self._memory_lock = threading.Lock()
        self._open = _Batch()
        self._in_flight: _Batch | None = None
        self._broken = False
        with _gc_paused():
            self.restored = self._restore(now)
        """How many items and objects were found."""

    def handle(self, service: str, operation: str, request: AWSPreparedRequest) -> Answer:
        """Answer a request to "dynamodb" or "s3" in the place of AWS."""
        body = request.body if isinstance(request.body, bytes) else b""
        try:
            addresses = written_keys(Call(service, operation, request.url, body), self._memory.item_address)
        except LookupError as error:
            return _error(service, 400, "ValidationException", f"no such table, or no such key: {error}")
        ask = self._denying_missing if operation == "GetObject" else self._ask_s3
        if service == "dynamodb":
            ask = partial(_ask_dynamodb, operation)
        if operation == "TransactWriteItems":
            ask = partial(self._transact, addresses or ())
        if operation == "ListObjectVersions":
            addresses, ask = (), self._list_versions
        if addresses is None:
            return _error(service, 501, "NotImplemented", f"the local storage does not know {operation}")
        try:
            return self._apply(addresses, lambda: ask(request))
        except NotDurableError as error:
            # Not 500, which clients try again for seconds: a full disk stays full.
            return _error(service, 507, "InsufficientStorage", str(error))

    def read_object(self, bucket: str, name: str) -> tuple[bytes, str] | None:
        """Return content and ETag of an object, None where there is none; past moto, which takes a while.

        As with every read, nothing is told that a crash could undo.
        """
        with self._memory_lock:
            found = self._memory.read_object(bucket, name)
            batch = self._enqueue([])
        self._await_commit(batch)
        return found

    def persist(self, *changes: Change) -> None:
        """Make changes durable together that are neither of items nor of objects.

        Raises
        ------
        NotDurableError
            If it could not be.
        """
        with self._memory_lock:
            batch = self._enqueue(changes)
        self._await_commit(batch)

    def persisted(self, kind: str) -> list[Change]:
        """List the records of a kind of its own, in the order they came."""
        with self._journal_lock:
            return list(self._journal.load(kind))

    def limit(self, pages: int) -> None:
        """Let the journal grow to so many pages at most; for rehearsing a full disk."""
        with self._journal_lock:
            self._journal.limit(pages)

    def close(self) -> None:
        """Let go of journal and memory."""
        with self._journal_lock:
            if self._open.changes:
                self._flush()  # changes that nobody waited for
            with self._memory_lock:
                self._broken = True
                self._journal.close()
                self._memory.reset()

    def _list_versions(self, request: AWSPreparedRequest) -> Answer:
        bucket, _ = bucket_and_key(request.url)
        names = self._memory.names(bucket, prefix_of(request.url))
        return Answer(200, {"content-type": "application/xml"}, listing(names))

    def _ask_s3(self, request: AWSPreparedRequest) -> Answer:
        answer = self._moto.process_request(request)
        return Answer(404, {}, b"") if answer is None else _answer(*answer)

    def _transact(self, addresses: Sequence[Address], request: AWSPreparedRequest) -> Answer:
        """Let moto make a transaction's writes, all of them or none."""
        before = self._changes_at(addresses)
        answer = None
        try:
            answer = _ask_dynamodb("TransactWriteItems", request)
        finally:
            if answer is None or answer.status >= 300:
                for change in before:
                    self._memory.write(change)
        return answer

    def _denying_missing(self, request: AWSPreparedRequest) -> Answer:
        """Say of a missing object what S3 says to whom may not list the bucket, as no function may."""
        answer = self._ask_s3(request)
        return _error("s3", 403, "AccessDenied", "Access Denied") if answer.status == 404 else answer

    def _apply(self, addresses: Sequence[Address], operation: Callable[[], Answer]) -> Answer:
        with self._memory_lock:
            if self._broken:
                raise NotDurableError("the storage is closed, or memory and journal may differ: restart")
            try:
                answer = operation()
            except BaseException:
                # moto broke down in the middle: what it changed until then stays, so it must be on disk too.
                self._enqueue(self._changes_at(addresses))
                raise
            finally:
                self._memory.forget_instances()
            batch = self._enqueue(self._changes_at(addresses) if answer.status < 300 else [])
        self._await_commit(batch)
        return answer

    def _changes_at(self, addresses: Iterable[Address]) -> list[Change]:
        return [Change(address, self._memory.read(address)) for address in addresses]

    def _enqueue(self, changes: Sequence[Change]) -> _Batch | None:
        """Return the batch to wait for, the latest that is not on disk yet, if any. Memory is locked."""
        self._open.changes.extend(changes)
        return self._open if self._open.changes else self._in_flight

    def _await_commit(self, batch: _Batch | None) -> None:
        if batch is None:
            return
        if not batch.committed:
            # The first to come takes along all that has gathered; the others find it done.
            with self._journal_lock:
                if not batch.committed:
                    self._flush()
        if batch.error or not batch.committed:
            raise NotDurableError("it could not be made durable and was rolled back") from batch.error

    def _flush(self) -> None:
        """Write the open batch. The journal is locked."""
        with self._memory_lock:
            batch, self._open = self._open, _Batch()
            self._in_flight = batch
        error: JournalError | None = None
        try:
            self._journal.commit(batch.changes)
        except JournalError as caught:
            error = caught
            _log.error("a write failed and is rolled back: %s", caught)
        with self._memory_lock:
            committed = [batch]
            if error:
                # What was applied meanwhile rests on what is rolled back now.
                committed.append(self._open)
                self._open = _Batch()
                self._roll_back(change.address for group in committed for change in group.changes)
            for group in committed:
                group.error, group.committed = error, True
            self._in_flight = None

    def _roll_back(self, addresses: Iterable[Address]) -> None:
        try:
            for address in addresses:
                if address.kind in (ITEM, OBJECT):
                    self._memory.write(Change(address, self._journal.fetch(address)))
        except JournalError as error:
            self._broken = True
            _log.critical("the journal cannot be read, nothing is answered from now on: %s", error)

    def _restore(self, now: float) -> int:
        expired: list[Change] = []
        damaged: list[str] = []
        restored = 0
        for kind, containers in ((ITEM, self._tables), (OBJECT, self._buckets)):
            for change in self._journal.load(kind):
                restored += 1
                try:
                    if self._is_expired(change, now):
                        expired.append(Change(change.address, None))
                    elif change.address.container in containers:
                        self._memory.write(change)
                except (ValueError, KeyError, TypeError, AttributeError):  # one that has no checksum yet
                    damaged.append(f"{kind} {change.address.container} {change.address.key}"[:120])
        self._journal.leave_out(damaged)
        self._memory.forget_instances()
        if expired:
            self._journal.commit(expired)
        return restored

    def _is_expired(self, change: Change, now: float) -> bool:
        address, content = change.address, change.content
        if content is None:
            return False
        if address.kind == ITEM:
            table = self._tables.get(address.container)
            if table is None or table.ttl_attribute is None:
                return False
            attribute = json.loads(content.body).get(table.ttl_attribute, {})
            return "N" in attribute and float(attribute["N"]) <= now
        bucket = self._buckets.get(address.container)
        age = (now - json.loads(content.about)["modified"]) / 86400
        return bucket is not None and any(
            address.key.startswith(rule.prefix) and age >= rule.days for rule in bucket.expirations
        )


@contextmanager
def _gc_paused() -> Iterator[None]:
    """Keep the cyclic collector out while much is made and nothing dropped: it doubles the time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _ask_dynamodb(operation: str, request: AWSPreparedRequest) -> Answer:
    return _answer(*dynamodb.ask(operation, request))


def _answer(status: int, headers: Mapping[str, str], body: bytes | str) -> Answer:
    return Answer(status, headers, body.encode() if isinstance(body, str) else body)


def _error(service: str, status: int, code: str, text: str) -> Answer:
    if service == "s3":
        document = f"<Error><Code>{code}</Code><Message>{escape(text)}</Message></Error>"
        return Answer(status, {"content-type": "application/xml"}, document.encode())
    body = json.dumps({"__type": f"com.amazonaws.dynamodb.v20120810#{code}", "message": text})
    return Answer(status, {"content-type": "application/x-amz-json-1.0"}, body.encode())
