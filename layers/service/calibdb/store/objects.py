"""Objects in one S3 bucket, the source of truth: JSON documents, each written once under its name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from botocore.exceptions import BotoCoreError, ClientError

from calibdb.errors import DeniedReadError, UnavailableError
from calibdb.store.clients import available, code

if TYPE_CHECKING:
    from collections.abc import Callable

    from mypy_boto3_s3 import S3Client

# 409: another write of the same name is under way. It may yet fail: nobody knows whether the name is taken.
_UNDECIDED = "ConditionalRequestConflict"
_MAX_WRITES = 5
READERS = 8  # threads that read objects at a time
_MAX_OBJECTS_PER_DELETE = 1000  # objects that S3 removes in one request


class Objects:
    """Immutable objects under names."""

    def __init__(self, client: Callable[[], S3Client], bucket: str) -> None:
        self._client = client
        self._bucket = bucket

    def get(self, name: str) -> bytes | None:
        """Return the object's content, None when there is none; raises DeniedReadError."""
        found = self.get_version(name)
        return None if found is None else found[0]

    def get_version(self, name: str) -> tuple[bytes, str] | None:
        """Return the object's content and the tag of this version, None where there is none.

        Raises DeniedReadError.
        """
        with available():
            try:
                found = self._client().get_object(Bucket=self._bucket, Key=name)
                return found["Body"].read(), found["ETag"]
            except ClientError as error:
                # To whom may not list, S3 says of a missing object that it is forbidden, too.
                if code(error) == "AccessDenied":
                    self._confirm_missing(name)
                elif code(error) != "NoSuchKey":
                    raise
                return None

    def replace(self, name: str, content: bytes, tag: str) -> bool:
        """Write the object over the version with this tag; False, and nothing written, over another."""
        with available():
            try:
                self._client().put_object(
                    Bucket=self._bucket,
                    Key=name,
                    Body=content,
                    ContentType="application/json",
                    IfMatch=tag,
                )
            except ClientError as error:
                if code(error) not in ("PreconditionFailed", "NoSuchKey", _UNDECIDED):
                    raise
                return False
        return True

    def _confirm_missing(self, name: str) -> None:
        """Raise DeniedReadError unless the list of the bucket, which has another right, lacks the object."""
        try:
            listed = self._client().list_objects_v2(Bucket=self._bucket, Prefix=name, MaxKeys=1)
        except (ClientError, BotoCoreError) as error:
            raise DeniedReadError("Storage denied a read; try again.") from error
        if any(found["Key"] == name for found in listed.get("Contents", [])):
            raise DeniedReadError("Storage denied a read; try again.")

    def create(self, name: str, content: bytes) -> bool:
        """Write a new object; False, and nothing written, when the name is taken."""
        for _ in range(_MAX_WRITES):
            with available():
                try:
                    self._client().put_object(
                        Bucket=self._bucket,
                        Key=name,
                        Body=content,
                        ContentType="application/json",
                        IfNoneMatch="*",
                    )
                except ClientError as error:
                    if code(error) == "PreconditionFailed":
                        return False
                    if code(error) != _UNDECIDED:
                        raise
                else:
                    return True
        raise UnavailableError("Other requests keep writing the same object; send this one again.")

    def put(self, name: str, content: bytes) -> None:
        """Write the object, over the one with its name if there is one. For operators."""
        with available():
            self._client().put_object(
                Bucket=self._bucket, Key=name, Body=content, ContentType="application/json"
            )

    def purge_all_versions(self, names: Iterable[str]) -> int:
        """Remove the objects with every version that the bucket keeps of them; return how many those were.

        For operators: what a person wants forgotten must not survive as a version.
        """
        removed = 0
        for name in names:
            versions = list(self._versions(name))
            for start in range(0, len(versions), _MAX_OBJECTS_PER_DELETE):
                with available():
                    self._client().delete_objects(
                        Bucket=self._bucket,
                        Delete={
                            "Objects": [
                                {"Key": name, "VersionId": version}
                                for version in versions[start : start + _MAX_OBJECTS_PER_DELETE]
                            ],
                            "Quiet": True,
                        },
                    )
            removed += len(versions)
        return removed

    def _versions(self, name: str) -> Iterator[str]:
        with available():
            pages = self._client().get_paginator("list_object_versions")
            for page in pages.paginate(Bucket=self._bucket, Prefix=name):
                for found in (*page.get("Versions", []), *page.get("DeleteMarkers", [])):
                    if found["Key"] == name:  # others may begin with it
                        yield found["VersionId"]

    def delete(self, names: Sequence[str]) -> None:
        """Remove the objects, those that there are."""
        for start in range(0, len(names), _MAX_OBJECTS_PER_DELETE):
            batch = names[start : start + _MAX_OBJECTS_PER_DELETE]
            with available():
                self._client().delete_objects(
                    Bucket=self._bucket, Delete={"Objects": [{"Key": name} for name in batch], "Quiet": True}
                )

    def names(self, prefix: str, after: str = "") -> Iterator[str]:
        """Yield the names that begin with `prefix` and come after `after`, in order."""
        start: dict[str, Any] = {"StartAfter": after} if after else {}
        pages = self._client().get_paginator("list_objects_v2")
        with available():
            for page in pages.paginate(Bucket=self._bucket, Prefix=prefix, **start):
                for found in page.get("Contents", []):
                    yield found["Key"]
