"""Consensuses that rest on a batch of calibrations. Internal: the first step of every batch of a backfill.

The state machine lists the bucket and passes the names, a thousand at a time; the names of one camera's
calibrations are adjacent. The response is a list of requests for `refit`, one for each camera, size and zoom,
which the state machine then makes. A camera on the border of two batches is requested twice; the second time
there is nothing to compute.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from calibdb.camera_key import VERSION
from calibdb.http import metrics
from calibdb.schema import BackfillAnswer, BackfillBatch, RefitRequest
from calibdb.service import Service
from calibdb.store import Calibrations, StreamMode
from calibdb.store.keys import parse_calibration_object
from calibdb.store.names import with_current_key


@metrics.counting_denied_reads
def handler(event: dict[str, Any], _: object) -> dict[str, Any]:
    """List the requests to `refit`."""
    names = [listed.key for listed in BackfillBatch.model_validate(event).items]
    requests = requests_of(Service.of_process().store.calibrations, names)
    return BackfillAnswer(requests=requests).model_dump(mode="json")


def requests_of(calibrations: Calibrations, names: list[str]) -> tuple[RefitRequest, ...]:
    """List the requests for the modes of the calibrations with these objects' names, in order."""
    stored_modes = sorted(
        set(modes(calibrations, names)),
        key=lambda mode: (mode.camera_key, mode.img_size, mode.zoom),
    )
    return tuple(RefitRequest(camera=m.camera_key, img_size=m.img_size, zoom=m.zoom) for m in stored_modes)


def modes(calibrations: Calibrations, names: list[str]) -> Iterator[StreamMode]:
    """Yield the modes of the calibrations with these objects' names; other names are passed over."""
    places = [place for name in names if (place := parse_calibration_object(name))]
    for camera_key in {key for key, _ in places if key.startswith(f"{VERSION}-")}:
        yield from calibrations.modes(camera_key)
    # Only the documents say under which key these are found today.
    earlier = [calibration_id for key, calibration_id in places if not key.startswith(f"{VERSION}-")]
    listed = [document for name in earlier if (document := calibrations.get(name)) is not None]
    for document in map(with_current_key, listed):
        yield StreamMode(document.camera_key, document.img_size, document.zoom)
