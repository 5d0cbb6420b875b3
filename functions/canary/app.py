"""Canary: looks a camera up and calibrates a computed one through the site, and stores the outcome."""

import os
import time
from collections.abc import Mapping
from typing import Any
from urllib.parse import urljoin

from calibdb.http.canary_capture import CanaryError, steps
from calibdb.schema.health import CanaryRun, CanaryStep
from calibdb.store.canary import store_canary_run
from calibdb.store.secrets import read_parameter
from calibdb.store.storage import storage_named


def watch(site: str, token: str) -> tuple[CanaryRun, Exception | None]:
    """Take the steps; return their outcome, and the error if any."""
    start, at = time.monotonic(), int(time.time())
    step: CanaryStep = "lookup"
    failed: Exception | None = None
    try:
        for step in steps(site, token):  # noqa: B007 - the last one is where it failed
            pass
    except (CanaryError, KeyError, TypeError, ValueError) as error:
        failed = error
    took_ms = round(1000 * (time.monotonic() - start))
    return CanaryRun(ok=failed is None, at=at, took_ms=took_ms, failed_at=step if failed else None), failed


def handler(_event: Mapping[str, Any], _context: Any) -> dict[str, Any]:
    """Run once; store the outcome for `/healthz?deep=1`; raises CanaryError."""
    region = os.environ["AWS_REGION"]
    site = urljoin(os.environ["GUIDANCE_URL"], "/").rstrip("/")
    secret = os.environ.get("CANARY_TOKEN") or read_parameter(
        f"{os.environ['SECRETS_PATH']}/CANARY_TOKEN", region
    )
    run, failed = watch(site, secret)
    table = storage_named(region, os.environ["TABLE_NAME"]).table
    store_canary_run(table, run)
    if failed is not None:
        raise CanaryError(f"{run.failed_at}: {failed}") from failed
    return run.model_dump(mode="json")
