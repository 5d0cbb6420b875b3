"""One whole capture on a deployment, and its removal."""

from __future__ import annotations

import functools
import http.client
import random
import time
from collections.abc import Iterator, Mapping
from typing import Any

from calibdb.schema import RefitRequest
from calibdb.store import Calibrations, aws
from calibdb.store.keys import calibration_object, tombstone_object
from calibdb.store.storage import storage_named
from infra.deploy import load_test, smoke
from infra.ops.replica import ReplicatedObjects

CAMERA = "calibDB smoke test"
_SEED = 1


class _Line(load_test.Line):
    """A line without faults to a site whose name may not resolve yet."""

    via: str | None = None

    def _connection(self) -> http.client.HTTPConnection:
        return smoke.connection(self.url, self.via)


def problems(site: smoke.Site, token: str, remove: Any) -> Iterator[str]:
    """Find why a capture with the pages' token fails; `remove` receives the id of its calibration."""
    line = _Line(site.url, random.Random(_SEED), faults=0.0)  # noqa: S311
    line.via = site.distribution
    try:
        done = load_test.capture(line, token, _SEED, CAMERA, finish=True)
    except (load_test.LoadError, OSError, http.client.HTTPException) as error:
        yield f"a capture: {error}"
        return
    identity = str(done.calibration_id)
    try:
        response = line.call("GET", f"/v1/calibrations/{identity}", token)
        if response.get("id") != identity:
            yield f"GET /v1/calibrations/{identity}: {response.get('id')}"
    except (load_test.LoadError, OSError, http.client.HTTPException) as error:
        yield str(error)
    finally:
        remove(identity)


def remove(made: Mapping[str, str], region: str, refit: str, identity: str) -> None:
    """Remove a calibration, and have what it was pooled into computed without it.

    Its versions expire with the bucket's rule: a deployment has no right to remove versions.

    Parameters
    ----------
    made
        Outputs of the stack.
    refit
        Name of the function that computes consensuses.
    identity
        Id of the calibration.
    """
    table = storage_named(region, made["TableName"]).table
    # A replica must not keep it either.
    keypoints = made["KeypointBucketName"]
    objects = ReplicatedObjects(functools.partial(aws.s3, region), keypoints, aws.s3)
    calibrations = Calibrations(table, objects)
    document = calibrations.get(identity)
    if document is None:
        return
    calibrations.withdraw(document, "other: smoke test", int(time.time()))
    names = (calibration_object(identity), tombstone_object(identity))
    calibrations.unindex(document)
    for place in filter(None, (objects.replica, objects)):
        place.delete([name for name in names if name])
    request = RefitRequest(camera=document.camera_key, img_size=document.img_size, zoom=document.zoom)
    aws.lambda_(region).invoke(
        FunctionName=refit, InvocationType="Event", Payload=request.model_dump_json().encode()
    )
