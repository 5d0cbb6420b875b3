"""The storage of this process: on AWS, unless a server has opened another one."""

import functools
from collections.abc import Iterator
from contextlib import contextmanager

from calibdb.settings import Settings
from calibdb.store.ports import Storage

_opened: Storage | None = None


@contextmanager
def opened(storage: Storage) -> Iterator[None]:
    """Use `storage` within the block, in every thread."""
    global _opened
    before, _opened = _opened, storage
    try:
        yield
    finally:
        _opened = before


def storage_of(settings: Settings) -> Storage:
    """Storage of a function with these settings."""
    return storage_named(
        settings.region,
        settings.table_name,
        settings.bucket_name,
        settings.web_bucket,
        refit_function=settings.refit_function,
        verify_function=settings.verify_function,
    )


def storage_named(
    region: str,
    table: str,
    bucket: str = "",
    web_bucket: str | None = None,
    *,
    refit_function: str | None = None,
    verify_function: str | None = None,
) -> Storage:
    """Storage of these names."""
    if _opened is not None:
        return _opened
    from calibdb.store import aws  # not needed, and not installed, elsewhere

    s3 = functools.partial(aws.s3, region)
    return Storage(
        table=aws.DynamoTable(functools.partial(aws.dynamodb, region), table),
        objects=aws.S3Objects(s3, bucket),
        jobs=aws.LambdaJobs(
            functools.partial(aws.lambda_, region), {"refit": refit_function, "verify": verify_function}
        ),
        site=aws.S3Objects(s3, web_bucket) if web_bucket else None,
    )
