"""Calibration or consensus by its id, and the head of its page for messengers."""

import re
from datetime import UTC, datetime
from html import escape

from calibdb.camera_key import VERSION
from calibdb.errors import NotFoundError
from calibdb.lookup.badge import rough, without_usb_id
from calibdb.schema import Calibration, CalibrationDocument, ReportedCalibration
from calibdb.store import Store

_TITLES = re.compile(r'(<title\b[^>]*>|<meta property="og:title" content=")([^"<]*)')
_DESCRIPTIONS = re.compile(
    r'(<meta (?=[^>]*\b(?:name="description"|property="og:description"))'
    r'(?:[a-z-]+="[^"]*" )*?content=")([^"]*)'
)


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


def title(calibration: Calibration) -> str:
    """Camera, size and typical error, the same in every language."""
    width, height = calibration.img_size
    name = without_usb_id(calibration.camera)
    return f"{name} · {width} × {height} · ± {rough(calibration.uncertainty.rms)} px"


def facts(calibration: Calibration) -> str:
    """Focal lengths, lens model and day, the same in every language."""
    (fx, _, _), (_, fy, _), _ = calibration.camera_matrix
    day = datetime.fromtimestamp(calibration.calibration_time, UTC).date()
    return f"fx {fx:.1f} px · fy {fy:.1f} px · {calibration.distortion_model} · {day}."


def with_head(page: str, calibration: Calibration) -> str:
    """Page with the title and description of a calibration, escaped."""
    named, described = escape(title(calibration)), escape(facts(calibration))
    page = _TITLES.sub(lambda match: f"{match[1]}{named} · calibDB", page)
    return _DESCRIPTIONS.sub(lambda match: f"{match[1]}{described} {match[2]}", page)


def shared_page(page: str, store: Store, calibration_id: str) -> str:
    """Page with the head of a calibration, if there is one."""
    document = store.calibrations.get(calibration_id)
    if document is not None and store.calibrations.withdrawal(document) is not None:
        return page
    try:
        return with_head(page, read_reported(store, calibration_id, document))
    except NotFoundError:
        return page
