"""Calls of the ports of storage in a test's hands: counted, refused, lost."""

import threading
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from calibdb.errors import UnavailableError
from calibdb.store.ports import Storage
from calibdb.store.storage import opened
from tests.helpers.service.stores import override_service, with_methods

#: operations of AWS that calls of the ports are
OPERATIONS: Mapping[str, Mapping[str, str]] = {
    "table": {
        "get": "GetItem",
        "put": "PutItem",
        "put_transaction": "TransactWriteItems",
        "add": "UpdateItem",
        "remove": "UpdateItem",
        "delete": "DeleteItem",
        "query": "Query",
    },
    "objects": {
        "get": "GetObject",
        "get_version": "GetObject",
        "replace": "PutObject",
        "create": "PutObject",
        "put": "PutObject",
        "delete": "DeleteObjects",
        "names": "ListObjectsV2",
    },
    "site": {"put": "PutObject", "purge_all_versions": "DeleteObjects"},
    "jobs": {"later": "Invoke", "now": "Invoke"},
}
#: operations that change something
WRITES = {"PutItem", "TransactWriteItems", "UpdateItem", "DeleteItem", "PutObject", "DeleteObjects"}
#: all that read or write table or bucket
STORING = {*OPERATIONS["table"].values(), *OPERATIONS["objects"].values()}

#: is given the name of an operation and what performs it, and returns its result
Around = Callable[[str, Callable[[], Any]], Any]


@contextmanager
def intercepted(storage: Storage, around: Around) -> Iterator[Storage]:
    """Have every call of the ports go through `around` within the block; yields these ports."""

    def wrap(method: Callable[..., Any], operation: str) -> Callable[..., Any]:
        return lambda *arguments, **options: around(operation, lambda: method(*arguments, **options))

    def port(name: str) -> Any:
        original = getattr(storage, name)
        return with_methods(
            original, **{method: wrap(getattr(original, method), o) for method, o in OPERATIONS[name].items()}
        )

    changed = replace(storage, **{name: port(name) for name in OPERATIONS})
    with opened(changed):
        yield changed


@contextmanager
def intercepted_service(storage: Storage, around: Around, **build: Any) -> Iterator[Storage]:
    """As `intercepted`, for services that exist already; `build`: arguments of `Service.build`."""
    with intercepted(storage, around) as changed, override_service(**build):
        yield changed


@contextmanager
def failing(
    storage: Storage,
    error: UnavailableError,
    which: Callable[[int], bool] = lambda _: True,
    operations: Collection[str] = STORING,
    *,
    heard: bool = True,
) -> Iterator[list[str]]:
    """Raise the error for the calls whose number, from 0, is one of `which`; yields all of these calls.

    `heard`: they do nothing; else they are done, and only their result gets lost.
    """
    lock, calls = threading.Lock(), []

    def around(operation: str, call: Callable[[], Any]) -> Any:
        if operation not in operations:
            return call()
        with lock:
            fails = which(len(calls))
            calls.append(operation)
        if fails and heard:
            raise error
        result = call()
        if fails:
            raise error
        return result

    with intercepted_service(storage, around):
        yield calls


@contextmanager
def crash_after(storage: Storage, writes: int, **build: Any) -> Iterator[Storage]:
    """Lose every write after so many that wrote something: those of a process that was killed there."""
    done, lock = [0], threading.Lock()

    def around(operation: str, call: Callable[[], Any]) -> Any:
        if operation not in WRITES:
            return call()
        with lock:
            if done[0] >= writes:
                raise UnavailableError("Storage did not answer.")
            result = call()
            done[0] += result is not False
        return result

    with intercepted_service(storage, around, **build) as changed:
        yield changed
