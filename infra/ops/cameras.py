"""Listings of cameras and their calibrations, for the operator."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator

from calibdb.camera_key.visible import visible
from calibdb.schema import CalibrationDocument
from calibdb.store import StreamMode
from calibdb.store.keys import WITHDRAWN, camera_pk, tombstone_object
from infra.ops import reindex
from infra.ops.context import OpsContext
from infra.ops.errors import OpsError

_FOLDER = "calibrations/"


def describe_all(context: OpsContext, text: str) -> list[str]:
    """Describe each camera in a line whose key contains `text`: key and number of calibrations."""
    counts: Counter[str] = Counter()
    withdrawn: Counter[str] = Counter()
    for name in context.objects.names(_FOLDER):
        key = name.split("/")[1]
        if text.lower() in key:
            (withdrawn if name.endswith(WITHDRAWN) else counts)[key] += 1
    return [
        f"{key}  {count} calibration{'' if count == 1 else 's'}"
        + (f", {withdrawn[key]} withdrawn" if withdrawn[key] else "")
        for key, count in sorted(counts.items())
    ]


def describe(context: OpsContext, camera_key: str) -> Iterator[str]:
    """Yield the lines of one camera: its consensuses, and every calibration.

    A key of earlier rules shows the camera that is known under today's.

    Raises
    ------
    OpsError
        If no calibration of the camera is stored.
    """
    found = list(read_calibrations(context, camera_key))
    if not found:
        raise OpsError(f"nothing is known of a camera {camera_key}")
    # Stored before labels were cleaned, it may hold what a terminal would obey.
    yield visible(f"{found[-1][0].camera}, {found[-1][0].platform}")
    modes: dict[StreamMode, list[tuple[CalibrationDocument, bool]]] = {}
    for document, withdrawn in found:
        modes.setdefault(reindex.mode_of(document), []).append((document, withdrawn))
    for mode, members in modes.items():
        yield f"{mode.img_size[0]} x {mode.img_size[1]}, zoom {mode.zoom:g}"
        yield from (f"  {line}" for line in _describe_consensuses(context, mode))
        yield from (f"  {_describe_calibration(document, withdrawn)}" for document, withdrawn in members)


def read_calibrations(context: OpsContext, camera_key: str) -> Iterator[tuple[CalibrationDocument, bool]]:
    """Yield the calibrations of one camera, oldest first, and whether they were withdrawn.

    An object stays in the folder of the key that the camera had when it was stored.
    """
    under_key = dict(_stored_under(context, camera_key))
    keys = {camera_key, *(document.camera_key for document, _ in under_key.values())}
    ids = {calibration_id for key in keys for calibration_id in _indexed_ids(context, key)}
    folders = {calibration_id.rpartition("-")[0] for calibration_id in ids} - {camera_key}
    found = under_key | {
        calibration_id: known
        for folder in folders
        for calibration_id, known in _stored_under(context, folder)
        if known[0].camera_key in keys
    }
    yield from (found[one] for one in sorted(found, key=lambda one: one.rpartition("-")[2]))


def _stored_under(
    context: OpsContext, camera_key: str
) -> Iterator[tuple[str, tuple[CalibrationDocument, bool]]]:
    """Yield id, document and whether it was withdrawn of each calibration in the folder of a key."""
    names = set(context.objects.names(f"{_FOLDER}{camera_key}/"))
    for name in names:
        calibration_id = name.rpartition("/")[2].removesuffix(".json")
        if not name.endswith(WITHDRAWN):
            document = context.store.calibrations.get(calibration_id)
            if document is not None:
                yield calibration_id, (document, tombstone_object(calibration_id) in names)


def _indexed_ids(context: OpsContext, camera_key: str) -> Iterator[str]:
    """Yield the ids of the calibrations that the index knows under a key."""
    for sk in context.index.sort_keys(camera_pk(camera_key), "CALIBRATION#"):
        yield sk.rpartition("#")[2]


def _describe_consensuses(context: OpsContext, mode: StreamMode) -> Iterator[str]:
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


def _describe_calibration(document: CalibrationDocument, withdrawn: bool) -> str:
    fit = document.fits[document.distortion_model]
    day = time.strftime("%Y-%m-%d %H:%M", time.gmtime(document.time))
    return (
        f"{document.id}  {day}  contributor {document.contributor[:12]}  {document.distortion_model}  "
        f"fx {fit.camera_matrix[0][0]:.1f}  rms {fit.avg_reprojection_error:.2f} px"
        f"{'  withdrawn' if withdrawn else ''}"
    )
