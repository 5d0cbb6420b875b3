"""The public dump of the site, written now instead of by its schedule."""

import math

from calibdb.dump.figures import Figures
from calibdb.dump.weekly_dump import WeeklyDump
from calibdb.schema.dump import Dump
from calibdb.store.dumps import LATEST, STATISTICS, Dumps
from infra.ops import OpsError
from infra.ops.context import OpsContext


def publish_dump(context: OpsContext) -> Dump:
    """Write a dump to the site, as its function does every week, and return it.

    Raises OpsError if there is no bucket of a site, or another writer was faster.
    """
    dumps = dumps_of(context)
    if dumps is None:
        raise OpsError("set WEB_BUCKET_NAME: the site to which the dump is written")
    store, least = context.store, context.settings.thresholds.min_contributors
    dump = WeeklyDump(
        dumps=dumps,
        figures=Figures(dumps, store.cameras, store.miss_counts, store.calibrations, least),
        now=lambda: context.now,
        seconds_left=lambda: math.inf,
    ).run(force=True)
    if dump is None:
        raise OpsError("the function of the site is writing a dump at this moment; try again later")
    return dump


def replace_dumps(context: OpsContext) -> int:
    """Remove every public dump, and write a new one where there was one; return how many objects are gone.

    For contributions to be forgotten, which earlier dumps contain.
    """
    dumps = dumps_of(context)
    if dumps is None:
        context.echo("WEB_BUCKET_NAME is not set: the dumps of the site, if it has any, stay as they are")
        return 0
    dumps.end()
    names = [name for name in dumps.names() if name != STATISTICS]
    if not names:
        return 0
    # First the file that names the others, so that it never leads to missing ones.
    dumps.purge([LATEST])
    removed = dumps.purge(names)
    publish_dump(context)
    return removed


def dumps_of(context: OpsContext) -> Dumps | None:
    """Return the store of the site's dumps, None if no site is named."""
    site = context.storage.site
    return None if site is None else Dumps(context.objects, site)
