"""Hands out one stored calibration, or one consensus, by its id."""

from __future__ import annotations

from starlette.responses import Response

from calibdb import http
from calibdb.errors import InvalidError, NotFoundError
from calibdb.schema import Calibration


def show(call: http.Call) -> Response:
    """Answer with the calibration in the format asked for."""
    call.api_token()
    if call.request.query_params.get("format", "calibdb") != "calibdb":
        raise InvalidError.field("format", "must be calibdb")
    found = _find(call, call.path("id"))
    if found is None:
        raise NotFoundError("There is no calibration with this id.")
    return http.answer(found)


def _find(call: http.Call, calibration_id: str) -> Calibration | None:
    store = call.service.store
    if (document := store.calibrations.get(calibration_id)) is not None:
        return document.answer()
    consensus = store.consensuses.get(calibration_id)
    return consensus.calibration if consensus else None


handler = http.handler(http.resource("/v1/calibrations/{id}", GET=show))
