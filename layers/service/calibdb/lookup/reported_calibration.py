"""Calibration or consensus by its id, as the API returns it."""

from __future__ import annotations

from calibdb.camera_key import VERSION
from calibdb.errors import NotFoundError
from calibdb.schema import CalibrationDocument, ReportedCalibration
from calibdb.store import Store


def read_reported(
    store: Store, calibration_id: str, document: CalibrationDocument | None
) -> ReportedCalibration:
    """Calibration of a document, else the consensus of this id; raises NotFoundError."""
    calibration = _consensus(store, calibration_id) if document is None else _reported(document)
    if calibration is None:
        raise NotFoundError("The database has no calibration with this id.")
    return calibration


def _reported(document: CalibrationDocument) -> ReportedCalibration:
    report = dict(document.report or {})
    covariance = report.pop("covariance", None)
    return ReportedCalibration(
        **dict(document.answer()),
        report=report or None,
        covariance=covariance,
        board=document.board,
        board_shape=document.fits[document.distortion_model].board_shape,
        camera_key=document.current_key,
        **document.consent,
    )


def _consensus(store: Store, calibration_id: str) -> ReportedCalibration | None:
    document = store.consensuses.get(calibration_id)
    key, mark, place = calibration_id.partition("~")
    if document is None and mark and not key.startswith(f"{VERSION}-"):
        others = store.cameras.known(key).same_as  # of a key that was made by earlier rules
        document = store.consensuses.get(f"{others[0]}~{place}") if len(others) == 1 else None
    calibration = document.calibration if document else None
    if document is None or calibration is None:
        return None
    behind = store.consensuses.groups(document)
    covariance = behind.covariance if behind else None
    return ReportedCalibration(**dict(calibration), covariance=covariance, camera_key=document.camera_key)
