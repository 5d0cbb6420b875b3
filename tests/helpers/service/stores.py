"""Stores of the functions with single methods replaced: failures and races of storage in a test's hands."""

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store


class _Override:
    def __init__(self, part: Any, methods: dict[str, Callable[..., Any]]) -> None:
        self._part = part
        self.__dict__.update(methods)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._part, name)


def with_methods(part: Any, **methods: Callable[..., Any]) -> Any:
    """Return a part of storage with these methods in the place of its own."""
    return _Override(part, methods)


@contextmanager
def override_service(change: Callable[[Store], Store] = lambda store: store, **build: Any) -> Iterator[None]:
    """Have the functions use what `change` makes of their storage; `build`: more for `Service.build`."""

    @functools.cache
    def make(settings: Settings) -> Service:
        return Service.build(settings, change(Store.of(settings)), **build)

    with Service.override(make):
        yield
