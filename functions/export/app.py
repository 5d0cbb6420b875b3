"""Hands out one stored calibration, or one consensus, by its id."""

from __future__ import annotations

from starlette.responses import Response

from calibdb import http
from calibdb.camera_key import VERSION
from calibdb.errors import InvalidError, NotFoundError
from calibdb.schema import ReportedCalibration


def show(call: http.Call) -> Response:
    """Answer with the calibration in the format asked for."""
    call.api_token()
    if call.request.query_params.get("format", "calibdb") != "calibdb":
        raise InvalidError.field("format", "must be calibdb")
    found = _find(call, call.path("id"))
    if found is None:
        raise NotFoundError("There is no calibration with this id.")
    return http.answer(found)


def _find(call: http.Call, calibration_id: str) -> ReportedCalibration | None:
    store = call.service.store
    if (document := store.calibrations.get(calibration_id)) is not None:
        return ReportedCalibration(**dict(document.answer()), report=document.report)
    consensus = store.consensuses.get(calibration_id)
    key, mark, place = calibration_id.partition("~")
    if consensus is None and mark and not key.startswith(f"{VERSION}-"):
        others = store.cameras.known(key).same_as  # of a key that was made by earlier rules
        consensus = store.consensuses.get(f"{others[0]}~{place}") if len(others) == 1 else None
    found = consensus.calibration if consensus else None
    return ReportedCalibration(**dict(found)) if found else None


handler = http.handler(http.resource("/v1/calibrations/{id}", GET=show))
