"""Secrets of the deployment, kept in SSM's parameter store by their names, and cached for five minutes."""

import logging
import math
import random
import time
from collections.abc import Mapping

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


_known: dict[str, Mapping[str, str]] = {}  # by path, as last read


def with_secrets(environment: Mapping[str, str]) -> tuple[Mapping[str, str], float]:
    """Environment with the secrets under its SECRETS_PATH, and until when (`time.monotonic`).

    If SSM does not answer, the previous values are used; raises UnavailableError if there are none.
    """
    path = environment.get("SECRETS_PATH")
    if not path:
        return environment, math.inf
    until = time.monotonic() + SECRETS_TTL_S
    try:
        # Known values are used rather than waited for.
        _known[path] = _read(path, environment["AWS_REGION"], 1 if path in _known else MAX_ATTEMPTS)
    except UnavailableError:
        if path not in _known:
            raise
        _log.warning("secrets could not be reloaded", exc_info=True)
    return {**environment, **_known[path]}, until


def _read(path: str, region: str, max_attempts: int) -> Mapping[str, str]:
    """Return name, without the path, to value."""
    from calibdb.store.aws import available, ssm

    names = [f"{path}/{name}" for name in NAMES]
    for attempt in range(max_attempts):
        if attempt:
            time.sleep(random.uniform(0, min(_MAX_PAUSE_S, _FIRST_PAUSE_S * 2**attempt)))  # noqa: S311
        try:
            with available():
                answer = ssm(region).get_parameters(Names=names, WithDecryption=True)
            return {p["Name"].rpartition("/")[2]: p["Value"] for p in answer["Parameters"]}
        except UnavailableError as error:
            failed = error
    raise failed


def read_parameter(name: str, region: str) -> str:
    """Read one secure parameter; raises UnavailableError, also if it is missing."""
    from calibdb.store.aws import available, ssm

    with available():
        answer = ssm(region).get_parameters(Names=[name], WithDecryption=True)
    if not answer["Parameters"]:
        raise UnavailableError(f"The parameter {name} is missing.")
    return str(answer["Parameters"][0]["Value"])
