"""Storage calls of a server's functions, counted where nothing else can be counted along."""

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from calibdb.lookup.reports import AliasFilter
from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store
from infra.server.server import Server
from tests.helpers.service.client import TOKEN
from tests.helpers.service.intercepted import intercepted

IDLE_S = 60.0


class _NothingNew(AliasFilter):
    def admit(self, *_: object) -> bool:
        return False


@contextmanager
def lasting_tokens(*, report: bool = True) -> Iterator[None]:
    """Read each API token once within the block, and not again after half a minute.

    `report`: whether lookups report the labels under which they hit, and an instance its first miss.
    """

    @functools.cache
    def service(settings: Settings) -> Service:
        built = Service.build(settings, Store.of(settings), token_ttl_s=float("inf"))
        if report:
            return built
        built.misses.count("", built.clock())  # the first miss of an instance is reported at once
        return replace(built, aliases=_NothingNew())

    with Service.override(service):
        yield


@contextmanager
def storage_calls(stack: Server) -> Iterator[list[str]]:
    """Names of the operations that the block's requests ask of table, bucket and queue.

    Jobs of earlier requests are done before the block begins, those of its own before its names are complete.
    """
    stack.wait_until_idle(IDLE_S)
    names = []

    def record(operation: str, call: Callable[[], Any]) -> Any:
        names.append(operation)
        return call()

    with intercepted(stack.storage, record), lasting_tokens(report=False):
        Service.of_process().api_token(TOKEN)
        names.clear()
        yield names
        stack.wait_until_idle(IDLE_S)
