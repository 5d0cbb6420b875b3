"""Answers at the edge: objects under `known/` in the bucket of the site, each the body of a lookup's answer.

They follow from the index, as that follows from the bucket of keypoints. Who writes them holds the camera's
lock; the conditions here fence out a writer that has lost it unawares.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from calibdb.errors import UnavailableError

# Browsers keep an answer for a minute, the edge for five: a withdrawn one is gone from both in six.
CACHE_CONTROL = "public, max-age=60, s-maxage=300"
MEDIA_TYPE = "application/json"
_MAX_OBJECTS_PER_DELETE = 1000  # objects that S3 removes in one request


class EdgeAnswers:
    """Objects that CloudFront answers lookups with; none where there is no bucket for them."""

    def __init__(self, region: str, bucket: str | None) -> None:
        self._region = region
        self._bucket = bucket

    @property
    def bucket(self) -> str | None:
        """Name of the bucket, None where this function may not write there."""
        return self._bucket

    def put(self, name: str, content: bytes, before: str | None) -> str | None:
        """Write the object and return its ETag; None, and nothing written, when another is there.

        `before`: ETag of the object that this one replaces, None where there is none.
        """
        from botocore.exceptions import ClientError

        from calibdb.store.aws import available, code, s3

        condition = {"IfMatch": before} if before else {"IfNoneMatch": "*"}
        with available():
            try:
                done = s3(self._region).put_object(
                    Bucket=self._name(),
                    Key=name,
                    Body=content,
                    ContentType=MEDIA_TYPE,
                    CacheControl=CACHE_CONTROL,
                    **condition,  # type: ignore[arg-type]
                )
            except ClientError as error:
                if code(error) not in ("PreconditionFailed", "ConditionalRequestConflict", "NoSuchKey"):
                    raise
                return None
        return done["ETag"].strip('"')

    def delete(self, names: Sequence[str]) -> None:
        """Remove the objects, those that there are."""
        from calibdb.store.aws import available, s3

        for start in range(0, len(names), _MAX_OBJECTS_PER_DELETE):
            batch = names[start : start + _MAX_OBJECTS_PER_DELETE]
            with available():
                done = s3(self._region).delete_objects(
                    Bucket=self._name(), Delete={"Objects": [{"Key": name} for name in batch], "Quiet": True}
                )
            if done.get("Errors"):
                raise UnavailableError("Storage did not remove every answer at the edge.")

    def _name(self) -> str:
        if self._bucket is None:
            raise ValueError("WEB_BUCKET_NAME is not set for a function that needs it")
        return self._bucket


def etag_of(content: bytes) -> str:
    """Compute the ETag that S3 gives an object of this content: its MD5.

    Source: Amazon S3 API reference, "Object"; so it is with encryption by S3's own keys (SSE-S3).
    """
    return hashlib.md5(content, usedforsecurity=False).hexdigest()
