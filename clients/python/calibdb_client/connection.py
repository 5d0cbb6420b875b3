"""Settings of a connection, the same for both clients, and httpx's requests and responses."""

from __future__ import annotations

import os
import random
from collections.abc import Generator
from dataclasses import dataclass, field
from typing import Any, Generic
from urllib.parse import urlsplit

import httpx

from . import __version__
from .errors import CalibDBError, UsageError
from .flows import Flow, T
from .wire import MAX_BODY_BYTES, Failure, Reply, Request, pause, require_success

CONNECT_TIMEOUT_S = 5.0
RESPONSE_TIMEOUT_S = 30.0
"""Timeout of a response: the service may compute a model while the client waits."""
MAX_ATTEMPTS = 4


Step = dict[str, Any] | float
"""Arguments of httpx's `stream`, or seconds to wait."""


@dataclass(frozen=True)
class Result(Generic[T]):
    """Result of a conversation that has ended."""

    value: T


@dataclass(frozen=True)
class Connection:
    """A service, and how it is spoken to; parameters as of `Client`.

    `site` has neither `/v1` nor a slash at the end. Without a token, "", only the edge answers.
    """

    site: str
    token: str = field(repr=False)
    timeout: float
    attempts: int

    @classmethod
    def of(cls, url: str | None, token: str | None, timeout: float, attempts: int) -> Connection:
        """Make the connection of arguments, or of `CALIBDB_URL` and `CALIBDB_TOKEN`. Raises UsageError."""
        address = (url or os.environ.get("CALIBDB_URL") or "").strip().rstrip("/").removesuffix("/v1")
        if not address:
            raise UsageError("the address of the service is missing: give url, or set CALIBDB_URL")
        parts = urlsplit(address)
        if parts.scheme not in ("http", "https") or not parts.hostname or parts.query or parts.username:
            raise UsageError(f"{address!r} is not an address of a service, such as https://calibdb.example")
        credential = (os.environ.get("CALIBDB_TOKEN", "") if token is None else token).strip()
        if not credential.isascii() or not credential.isprintable() or " " in credential:
            raise UsageError("the token (CALIBDB_TOKEN) contains invalid characters")
        if not timeout > 0 or attempts < 1:
            raise UsageError("timeout and attempts must be positive")
        return cls(address, credential, timeout, attempts)

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of httpx's clients. Proxies and CAs are the environment's."""
        return {
            "timeout": httpx.Timeout(self.timeout, connect=min(CONNECT_TIMEOUT_S, self.timeout)),
            "headers": {"user-agent": f"calibdb-client/{__version__}"},
            "follow_redirects": False,
        }

    def steps(self, flow: Flow[T]) -> Generator[Step | Result[T], Reply | Failure | None, None]:
        """Turn a conversation into steps, to whose messages the outcomes are sent, and its result."""
        try:
            request = next(flow)
            while True:
                try:
                    reply = yield from self._exchange(request)
                except CalibDBError as error:
                    request = flow.throw(error)
                else:
                    request = flow.send(reply)
        except StopIteration as end:
            yield Result(end.value)

    def _exchange(self, request: Request) -> Generator[Step, Reply | Failure | None, Reply]:
        message = self.message(request)
        attempts = self.attempts if request.repeats else 1
        for attempt in range(attempts):
            outcome = (yield message) or Failure("nothing was sent")
            wait = pause(outcome, attempt, random.random())  # noqa: S311 - no secret
            if wait is None or attempt + 1 == attempts:
                break
            yield wait
        return require_success(outcome, self.site)

    def message(self, request: Request) -> dict[str, Any]:
        """Return the arguments of httpx's `stream` for a request. Raises UsageError if a token is missing."""
        headers = {"accept": request.accept}
        if request.credential != "none":
            credential = self.token if request.credential == "token" else request.credential
            if not credential:
                raise UsageError("the service asks for a token: give token, or set CALIBDB_TOKEN")
            headers["authorization"] = f"Bearer {credential}"
        arguments: dict[str, Any] = {
            "method": request.method,
            "url": f"{self.site}/{request.path}",
            "headers": headers,
        }
        if request.query:
            arguments["params"] = dict(request.query)
        if request.body is not None:
            arguments["json"] = dict(request.body)
        return arguments


class BodyTooLargeError(Exception):
    """The response is longer than anything that the service sends."""


class Body(bytearray):
    """Body of a response while it arrives."""

    def add(self, part: bytes) -> None:
        """Append a part. Raises BodyTooLargeError."""
        self.extend(part)
        if len(self) > MAX_BODY_BYTES:
            raise BodyTooLargeError

    def reply(self, response: httpx.Response) -> Reply:
        """Return the whole answer."""
        headers = {name.lower(): value for name, value in response.headers.items()}
        return Reply(response.status_code, headers, bytes(self))


def failure(error: Exception) -> Failure:
    """Return the failure that an exception of httpx stands for, without addresses."""
    if isinstance(error, httpx.TimeoutException):
        return Failure("no response in time")
    if isinstance(error, httpx.ConnectError):
        is_refused = "certificate" in str(error).lower()
        return Failure("its certificate is not valid" if is_refused else "no connection")
    if isinstance(error, BodyTooLargeError):
        return Failure("its response is too long")
    return Failure("the connection broke")
