"""Head of a result's page: the title and description that messengers, which run no scripts, show."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from html import escape

from calibdb.errors import NotFoundError
from calibdb.lookup.badge import rough, without_usb_id
from calibdb.lookup.reported_calibration import read_reported
from calibdb.schema import Calibration
from calibdb.store import Store

_TITLES = re.compile(r'(<title\b[^>]*>|<meta property="og:title" content=")([^"<]*)')
_DESCRIPTIONS = re.compile(
    r'(<meta (?=[^>]*\b(?:name="description"|property="og:description"))'
    r'(?:[a-z-]+="[^"]*" )*?content=")([^"]*)'
)


def title(calibration: Calibration) -> str:
    """Write the camera, the size in px and the typical error in px, the same in every language."""
    width, height = calibration.img_size
    name = without_usb_id(calibration.camera)
    return f"{name} · {width} × {height} · ± {rough(calibration.uncertainty.rms)} px"


def facts(calibration: Calibration) -> str:
    """Write the focal lengths in px, the lens model and the day, the same in every language."""
    (fx, _, _), (_, fy, _), _ = calibration.camera_matrix
    day = datetime.fromtimestamp(calibration.calibration_time, UTC).date()
    return f"fx {fx:.1f} px · fy {fy:.1f} px · {calibration.distortion_model} · {day}."


def with_head(page: str, calibration: Calibration) -> str:
    """Page with the title and description of a calibration, escaped."""
    named, described = escape(title(calibration)), escape(facts(calibration))
    page = _TITLES.sub(lambda match: f"{match[1]}{named} · calibDB", page)
    return _DESCRIPTIONS.sub(lambda match: f"{match[1]}{described} {match[2]}", page)


def shared_page(page: str, store: Store, calibration_id: str) -> str:
    """Page with the head of a calibration; unchanged if there is no such calibration."""
    document = store.calibrations.get(calibration_id)
    if document is not None and store.calibrations.withdrawal(document) is not None:
        return page
    try:
        return with_head(page, read_reported(store, calibration_id, document))
    except NotFoundError:
        return page
