"""Objects whose bucket is replicated: what is removed for good must not survive in the replica."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from botocore.exceptions import ClientError

from calibdb.store.aws import S3Objects, available, code, s3

if TYPE_CHECKING:
    from mypy_boto3_s3 import S3Client

_DEFAULT_REGION = "us-east-1"  # which S3 names by nothing


class ReplicatedObjects(S3Objects):
    """Objects of a bucket and, where S3 replicates it, of its replica. `clients`: by region.

    S3 copies new objects to the replica; it never copies the removal of a version.
    """

    def __init__(self, bucket: str, region: str, clients: Callable[[str], S3Client] = s3) -> None:
        super().__init__(functools.partial(clients, region), bucket)
        self._source = bucket
        self._clients = clients

    def purge_all_versions(self, names: Iterable[str]) -> int:
        """Remove the objects with every version, from the replica first; return how many of the bucket's.

        Cut short, it is repeated: what is left in the bucket leads to what is left in the replica.
        """
        names = list(names)
        if self.replica is not None:
            self.replica.purge_all_versions(names)
        return super().purge_all_versions(names)

    @functools.cached_property
    def replica(self) -> S3Objects | None:
        """Bucket that S3 replicates to, None if it replicates to none."""
        with available():
            try:
                response = self._client().get_bucket_replication(Bucket=self._source)
            except ClientError as error:
                if code(error) == "ReplicationConfigurationNotFoundError":
                    return None
                raise
            rules = response["ReplicationConfiguration"]["Rules"]
            bucket = rules[0]["Destination"]["Bucket"].rpartition(":")[2]
            location = self._client().get_bucket_location(Bucket=bucket)["LocationConstraint"]
        return S3Objects(functools.partial(self._clients, location or _DEFAULT_REGION), bucket)
