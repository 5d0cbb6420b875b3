"""Health: state of the service and, on request, of each of its parts.

Callers need no credential, so results are cached.
"""

import functools
import time
from urllib.parse import urljoin

from starlette.responses import Response

from calibdb.errors import UnhealthyError
from calibdb.http import application
from calibdb.http.application import Call, json_response, problem_response, route
from calibdb.http.part_checks import CHECKS_TTL_S, Part, PartChecks, read_config
from calibdb.schema import DeepHealth, Health
from calibdb.schema.health import CanaryRun, PartHealth
from calibdb.settings import Settings
from calibdb.store.canary import last_canary_run
from calibdb.store.storage import storage_of

_TABLE_LIMIT_S, _BUCKET_LIMIT_S, _EDGE_LIMIT_S, _SOLVER_LIMIT_S = 2.0, 2.0, 3.0, 8.0
_CACHED = {"Cache-Control": f"public, max-age=5, s-maxage={CHECKS_TTL_S:.0f}"}


class Checks:
    """Checks of one deployment, and the last run of its canary."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self.canary: CanaryRun | None = None
        storage = (
            Part("table", _TABLE_LIMIT_S, self._read_table),
            Part("bucket", _BUCKET_LIMIT_S, self._read_bucket),
            Part("edge", _EDGE_LIMIT_S, self._read_config),
        )
        solver = Part("solver", _SOLVER_LIMIT_S, _solve, prepare=_import_solver)
        self.parts = PartChecks((storage, (solver,)))

    def _read_table(self) -> None:
        self.canary = None
        self.canary = last_canary_run(storage_of(self._settings).table, int(time.time()))

    def _read_bucket(self) -> None:
        # A bucket that works reports that there is no such object.
        storage_of(self._settings).objects.get("health/none")

    def _read_config(self) -> None:
        address = urljoin(self._settings.guidance_url, "/config.json")
        if not address.startswith(("https://", "http://")):
            raise ValueError("the site has no address")
        read_config(address, _EDGE_LIMIT_S)


def _import_solver() -> None:
    import calibdb.compute.solver_check  # noqa: F401


def _solve() -> None:
    from calibdb.compute.solver_check import solve

    solve()


_checks_of = functools.lru_cache(maxsize=4)(Checks)


def health(call: Call) -> Response:
    """State of the service; with `deep=1`, of its parts."""
    if not call.flag("deep"):
        return json_response(Health())
    call.require_thread()
    checks = _checks_of(call.service.settings)
    parts, canary = checks.parts(), checks.canary
    if all(part.ok for part in parts) and (canary is None or canary.ok):
        answer = DeepHealth(checked_at=checks.parts.checked_at, parts=parts, canary=canary)
        return json_response(answer, headers=_CACHED)
    return problem_response(_unhealthy(checks.parts.checked_at, parts, canary))


def _unhealthy(checked_at: int, parts: tuple[PartHealth, ...], canary: CanaryRun | None) -> UnhealthyError:
    failed = [part.part for part in parts if not part.ok]
    detail = f"Not working: {', '.join(failed)}." if failed else "The canary failed; every part works."
    return UnhealthyError(
        detail,
        headers=_CACHED,
        extensions={
            "checked_at": checked_at,
            "parts": [part.model_dump(mode="json") for part in parts],
            "canary": None if canary is None else canary.model_dump(mode="json"),
        },
    )


handler = application.handler(route("/healthz", is_quick=True, GET=health))
