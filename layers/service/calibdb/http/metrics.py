"""Metrics as lines on standard output, in Lambda only.

Format: Amazon CloudWatch user guide, "Specification: Embedded metric format".
"""

import functools
import json
import os
import time
from collections.abc import Callable, Mapping
from typing import Any

from calibdb.errors import DeniedReadError

InternalHandler = Callable[[dict[str, Any], Any], dict[str, Any]]

NAMESPACE = "calibDB"
COUNTS = (
    *("Lookups", "Misses", "Redirects", "Sessions", "Views", "Refusals"),
    *("Calibrations", "ViewsPerSession", "Errors", "ComputeTimeouts", "DeniedReads", "UnknownEdges"),
)
#: each metric costs as much in a month as 150,000 lookups
UNITS = {
    **dict.fromkeys(COUNTS, "Count"),
    "FitTime": "Milliseconds",
}
#: also counted by their reason
REASONED = ("Refusals",)
#: reasons without a metric: they occur only with the published guidance
RARE = ("no_information",)


def document(stack: str, now: float, values: Mapping[str, float], reason: str | None = None) -> str:
    """Line of measurements by name; `stack`: name of the deployment, a dimension of all."""
    units = [{"Name": name, "Unit": UNITS.get(name, "Count")} for name in values]
    described = [{"Namespace": NAMESPACE, "Dimensions": [["Stack"]], "Metrics": units}]
    reasoned = [metric for metric in units if metric["Name"] in REASONED]
    if reason is not None and reason not in RARE and reasoned:
        by_reason = {"Namespace": NAMESPACE, "Dimensions": [["Stack", "Reason"]], "Metrics": reasoned}
        described.append(by_reason)
    line: dict[str, object] = {
        "_aws": {"Timestamp": int(now * 1000), "CloudWatchMetrics": described},
        "Stack": stack,
        **values,
    }
    if reason is not None:
        line["Reason"] = reason
    return json.dumps(line, separators=(",", ":"))


def count(*, reason: str | None = None, **values: float) -> None:
    """Print the values, in Lambda only."""
    if "AWS_LAMBDA_RUNTIME_API" in os.environ:
        print(document(os.environ.get("STACK_NAME", ""), time.time(), values, reason), flush=True)


def counting_denied_reads(handler: InternalHandler) -> InternalHandler:
    """Count denied reads of an internal function."""

    @functools.wraps(handler)
    def wrapped(event: dict[str, Any], context: Any) -> dict[str, Any]:
        try:
            return handler(event, context)
        except DeniedReadError:
            count(DeniedReads=1)
            raise

    return wrapped
