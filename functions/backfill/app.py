"""Requests to `refit` the consensuses of a batch of calibrations. Internal: a step of a state machine."""

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
    """Requests for the modes of calibrations, by names of objects."""
    modes = sorted(
        set(_modes(calibrations, names)), key=lambda mode: (mode.camera_key, mode.img_size, mode.zoom)
    )
    return tuple(RefitRequest(camera=m.camera_key, img_size=m.img_size, zoom=m.zoom) for m in modes)


def _modes(calibrations: Calibrations, names: list[str]) -> Iterator[StreamMode]:
    places = [place for name in names if (place := parse_calibration_object(name))]
    for camera_key in {key for key, _ in places if key.startswith(f"{VERSION}-")}:
        yield from calibrations.modes(camera_key)
    # Only the documents of earlier keys contain the current one.
    earlier = [calibration_id for key, calibration_id in places if not key.startswith(f"{VERSION}-")]
    listed = [document for name in earlier if (document := calibrations.get(name)) is not None]
    for document in map(with_current_key, listed):
        yield StreamMode(document.camera_key, document.img_size, document.zoom)
