"""End of a session, and its calibration."""

from __future__ import annotations

import hashlib

from pydantic import JsonValue

from calibdb.schema import CalibrationDocument, Finish, SessionDocument
from calibdb.schema.documents import CaptureDocument

_DAY_S = 86_400


def with_finish(
    document: SessionDocument,
    now: int,
    contributor: str,
    solver: str,
    report: dict[str, JsonValue] | None = None,
    source: str | None = None,
) -> SessionDocument:
    """End the session: fix everything that publishing it needs."""
    finish = Finish(
        calibration_id=calibration_id(document),
        time=now,
        contributor=contributor,
        source=source,
        solver=solver,
        report=report,
    )
    ended = {"finish": finish, "target": None, "skipped": (), "unreached": (), "doubted": ()}
    return document.model_copy(update=ended)


def calibration_id(document: SessionDocument) -> str:
    """Id of the calibration to which a session leads."""
    return f"{document.camera_key}-{calibration_name(document.session, document.first_version)}"


def calibration_name(sid: str, first_version: int) -> str:
    """Second part of a calibration id, from which no session follows.

    Ids are public, so they contain only the day of the session's start.
    """
    day = int(sid[:8], 16) // _DAY_S * _DAY_S
    return f"{day:08x}{hashlib.sha256(f'{sid}/{first_version}'.encode()).hexdigest()[:12]}"


def to_calibration(document: SessionDocument) -> CalibrationDocument:
    """Calibration of a converged session."""
    finish, fit = document.finish, document.estimate.fit
    if finish is None or fit is None:
        raise ValueError("the session has not converged")
    capture = {name: getattr(document, name) for name in CaptureDocument.model_fields}
    by_whom = {"contributor": finish.contributor, "source": finish.source}
    return CalibrationDocument(
        **{**capture, **by_whom, "camera_key": document.current_key},
        id=finish.calibration_id,
        views=tuple(view for view in document.views if view.set_aside is None),
        set_aside=tuple(view for view in document.views if view.set_aside is not None),
        fits={document.distortion_model: fit},
        report=finish.report,
        solver=finish.solver,
        time=finish.time,
    )
