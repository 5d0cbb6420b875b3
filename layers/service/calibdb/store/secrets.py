"""Secrets of the deployment, kept in SSM's parameter store by their names, and cached for five minutes."""

import functools
import logging
import math
import random
import time
from collections.abc import Callable, Mapping
from typing import Any

from calibdb.errors import UnavailableError

SECRETS_TTL_S = 300.0  # after which a rotation is known everywhere
NAMES = ("SESSION_SECRETS", "CONTRIBUTOR_SECRET", "EDGE_SECRETS")
# SSM gives an account 40 calls a second by default, and a crowd of users starts hundreds of
# functions within one. Each waits a random time, up to a bound that doubles ("full jitter"), so that the
# crowd spreads, and all are served before the gateway gives up on the first.
# Source: Brooker, Exponential Backoff And Jitter, AWS Architecture Blog 2015.
MAX_ATTEMPTS = 14
_FIRST_PAUSE_S, _MAX_PAUSE_S = 0.25, 3.0

_log = logging.getLogger(__name__)


class Secrets:
    """The parameters of a deployment by their names.

    If SSM does not answer, the previous values are used; raises UnavailableError if there are none.
    """

    def __init__(
        self,
        client: Callable[[], Any],
        path: str,
        clock: Callable[[], float],
    ) -> None:
        self._client = client
        self._path = path
        self._clock = clock
        self._known: Mapping[str, str] = {}
        self.until = -math.inf
        """Time of the clock at which they are read again."""

    def __call__(self) -> Mapping[str, str]:
        """Return name, without the path, to value."""
        now = self._clock()
        if now >= self.until:
            try:
                self._known = self._read()
            except UnavailableError:
                if not self._known:
                    raise
                _log.warning("secrets could not be reloaded", exc_info=True)
            self.until = now + SECRETS_TTL_S
        return self._known

    def _read(self) -> Mapping[str, str]:
        from calibdb.store.aws import available

        names = [f"{self._path}/{name}" for name in NAMES]
        # Known values are used rather than waited for.
        for attempt in range(1 if self._known else MAX_ATTEMPTS):
            if attempt:
                time.sleep(random.uniform(0, min(_MAX_PAUSE_S, _FIRST_PAUSE_S * 2**attempt)))  # noqa: S311
            try:
                with available():
                    answer = self._client().get_parameters(Names=names, WithDecryption=True)
                return {p["Name"].rpartition("/")[2]: p["Value"] for p in answer["Parameters"]}
            except UnavailableError as error:
                failed = error
        raise failed


def with_secrets(environment: Mapping[str, str]) -> tuple[Mapping[str, str], float]:
    """Environment with the secrets under its SECRETS_PATH, and until when (`time.monotonic`)."""
    path = environment.get("SECRETS_PATH")
    if not path:
        return environment, math.inf
    secrets = _cached_secrets(path, environment["AWS_REGION"])
    return {**environment, **secrets()}, secrets.until


def read_parameter(name: str, region: str) -> str:
    """Read one secure parameter; raises UnavailableError, also if it is missing."""
    from calibdb.store.aws import available, ssm

    with available():
        answer = ssm(region).get_parameters(Names=[name], WithDecryption=True)
    if not answer["Parameters"]:
        raise UnavailableError(f"The parameter {name} is missing.")
    return str(answer["Parameters"][0]["Value"])


@functools.cache
def _cached_secrets(path: str, region: str) -> Secrets:
    from calibdb.store.aws import ssm

    return Secrets(lambda: ssm(region), path, time.monotonic)
