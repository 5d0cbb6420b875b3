"""Models built at their first use."""

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from pydantic import BaseModel
from pydantic._internal import _model_construction

from calibdb import schema
from calibdb.schema import fields
from calibdb.schema.fields import Deferred, Strict

MODELS = [each for each in vars(schema).values() if isinstance(each, type) and issubclass(each, BaseModel)]


class Watched:
    """A lock that tells when a thread asks for it."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self.asked = threading.Semaphore(0)

    def __enter__(self) -> None:
        self.asked.release()
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()


def test_first_use_in_two_threads_builds_the_model_once(monkeypatch: pytest.MonkeyPatch) -> None:
    class Fresh(Strict):
        number: int = 0

    lock, builds = Watched(), 0
    build = _model_construction.complete_model_class

    def build_late(*args: Any, **kwargs: Any) -> bool:
        nonlocal builds
        builds += 1
        if builds == 1:
            for _ in range(2):
                assert lock.asked.acquire(timeout=60)
        else:
            lock.asked.release()
        return build(*args, **kwargs)

    monkeypatch.setattr(_model_construction, "complete_model_class", build_late)
    monkeypatch.setattr(fields, "building", lock)
    assert not Fresh.__pydantic_complete__
    with ThreadPoolExecutor(2) as pool:
        found = pool.map(lambda number: Fresh.model_validate({"number": number}).model_dump(), (1, 2))
        assert list(found) == [{"number": 1}, {"number": 2}]
    assert builds == 1


def test_every_model_of_the_schema_is_deferred_and_can_be_built() -> None:
    assert len(MODELS) > 40
    for each in MODELS:
        assert issubclass(each, Deferred), each.__name__
        each.model_rebuild()
        assert each.__pydantic_complete__, each.__name__
