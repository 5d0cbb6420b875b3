"""What is known of cameras, for an operator's eyes."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator

from calibdb.camera_key.visible import visible
from calibdb.schema import CalibrationDocument
from calibdb.store import Mode
from calibdb.store.keys import WITHDRAWN
from infra.ops.context import OpsContext, OpsError

_CALIBRATIONS = "calibrations/"


def listed(context: OpsContext, text: str) -> list[str]:
    """Return a line for each camera whose key holds `text`: key and number of calibrations."""
    counts: Counter[str] = Counter()
    withdrawn: Counter[str] = Counter()
    for name in context.objects.names(_CALIBRATIONS):
        key = name.split("/")[1]
        if text.lower() in key:
            (withdrawn if name.endswith(WITHDRAWN) else counts)[key] += 1
    return [
        f"{key}  {count} calibration{'' if count == 1 else 's'}"
        + (f", {withdrawn[key]} withdrawn" if withdrawn[key] else "")
        for key, count in sorted(counts.items())
    ]


def shown(context: OpsContext, camera_key: str) -> Iterator[str]:
    """Yield lines that say what agrees, and list every calibration. Raises OpsError for an unknown key."""
    found = list(calibrations(context, camera_key))
    if not found:
        raise OpsError(f"nothing is known of a camera {camera_key}")
    # Stored before labels were cleaned, it may hold what a terminal would obey.
    yield visible(f"{found[-1][0].camera}, {found[-1][0].platform}")
    modes: dict[Mode, list[tuple[CalibrationDocument, bool]]] = {}
    for document, withdrawn in found:
        key = Mode(camera_key, document.img_size, document.zoom)
        modes.setdefault(key, []).append((document, withdrawn))
    for mode, members in modes.items():
        yield f"{mode.img_size[0]} x {mode.img_size[1]}, zoom {mode.zoom:g}"
        yield from (f"  {line}" for line in _consensuses(context, mode))
        yield from (f"  {_calibration(document, withdrawn)}" for document, withdrawn in members)


def calibrations(context: OpsContext, camera_key: str) -> Iterator[tuple[CalibrationDocument, bool]]:
    """Yield the calibrations of one camera in the bucket, oldest first, and whether they were withdrawn."""
    names = sorted(context.objects.names(f"{_CALIBRATIONS}{camera_key}/"))
    tombstones = {name.removesuffix(WITHDRAWN) for name in names if name.endswith(WITHDRAWN)}
    for name in names:
        if name.endswith(WITHDRAWN):
            continue
        document = context.store.calibrations.get(name.rpartition("/")[2].removesuffix(".json"))
        if document is not None:
            yield document, name.removesuffix(".json") in tombstones


def _consensuses(context: OpsContext, mode: Mode) -> Iterator[str]:
    for consensus in context.store.consensuses.at(mode):
        known = consensus.calibration
        what = "reliable" if consensus.reliable else f"not reliable ({consensus.reason})"
        line = f"{consensus.distortion_model}: {what}"
        if known is not None:
            line += (
                f"; {known.calibrations} of {consensus.total} agree, "
                f"{known.contributors} contributor{'' if known.contributors == 1 else 's'}, "
                f"fx {known.camera_matrix[0][0]:.1f}, rms {known.avg_reprojection_error:.2f} px"
            )
        yield line


def _calibration(document: CalibrationDocument, withdrawn: bool) -> str:
    fit = document.fits[document.distortion_model]
    day = time.strftime("%Y-%m-%d %H:%M", time.gmtime(document.time))
    return (
        f"{document.id}  {day}  contributor {document.contributor[:12]}  {document.distortion_model}  "
        f"fx {fit.camera_matrix[0][0]:.1f}  rms {fit.avg_reprojection_error:.2f} px"
        f"{'  withdrawn' if withdrawn else ''}"
    )
