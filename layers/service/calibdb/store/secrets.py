"""Secrets of the deployment, kept in SSM's parameter store under one path, and cached for five minutes."""

from __future__ import annotations

import functools
import logging
import time
from collections.abc import Callable, Mapping

from botocore.exceptions import BotoCoreError, ClientError

from calibdb.store.clients import ParameterReader, available, ssm

SECRETS_TTL_S = 300.0  # after which a rotation is known everywhere

_log = logging.getLogger(__name__)


class Secrets:
    """The parameters under one path by their names, read again every five minutes.

    Where SSM does not answer, what was read before goes on being used; raises UnavailableError where nothing
    was.
    """

    def __init__(self, client: Callable[[], ParameterReader], path: str, clock: Callable[[], float]) -> None:
        self._client = client
        self._path = path
        self._clock = clock
        self._known: Mapping[str, str] = {}
        self._until = float("-inf")

    def __call__(self) -> Mapping[str, str]:
        """Return name, without the path, to value."""
        now = self._clock()
        if now >= self._until:
            try:
                self._known = self._read()
            except (ClientError, BotoCoreError):
                if not self._known:
                    with available():
                        raise
                _log.warning("secrets could not be read anew", exc_info=True)
            self._until = now + SECRETS_TTL_S
        return self._known

    def _read(self) -> Mapping[str, str]:
        answer = self._client().get_parameters_by_path(Path=self._path, WithDecryption=True)
        return {p["Name"].rpartition("/")[2]: p["Value"] for p in answer["Parameters"]}


def with_secrets(environment: Mapping[str, str]) -> Mapping[str, str]:
    """Return the environment with the secrets under its SECRETS_PATH; without one, as it is."""
    path = environment.get("SECRETS_PATH")
    if not path:
        return environment
    return {**environment, **_cached_secrets(path, environment["AWS_REGION"])()}


@functools.cache
def _cached_secrets(path: str, region: str) -> Secrets:
    return Secrets(lambda: ssm(region), path, time.monotonic)
