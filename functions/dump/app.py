"""Dump: continues the public dump that is due. A schedule invokes it every hour of one day of the week."""

import os
import time
from collections.abc import Mapping
from typing import Any

from calibdb.dump.figures import Figures
from calibdb.dump.weekly_dump import WeeklyDump
from calibdb.http import metrics
from calibdb.settings import Thresholds
from calibdb.store import Calibrations
from calibdb.store.cameras import Cameras
from calibdb.store.dumps import Dumps
from calibdb.store.miss_counts import MissCounts
from calibdb.store.storage import storage_named


@metrics.counting_denied_reads
def handler(_: Mapping[str, Any], context: Any) -> dict[str, Any]:
    """Write parts while time is left; return the name of a complete dump."""
    region = os.environ["AWS_REGION"]
    storage = storage_named(
        region, os.environ["TABLE_NAME"], os.environ["BUCKET_NAME"], os.environ["WEB_BUCKET_NAME"]
    )
    assert storage.site is not None  # noqa: S101 - its name is given
    table = storage.table
    calibrations = Calibrations(table, storage.objects)
    dumps = Dumps(storage.objects, storage.site)
    least = Thresholds.from_environment(os.environ).min_contributors
    dump = WeeklyDump(
        dumps=dumps,
        figures=Figures(dumps, Cameras(table), MissCounts(table), calibrations, least),
        now=lambda: int(time.time()),
        seconds_left=lambda: context.get_remaining_time_in_millis() / 1000,
    ).run()
    return {"name": dump.name if dump else None}
