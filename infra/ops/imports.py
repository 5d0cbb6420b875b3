"""Import of calibration files that other tools wrote."""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast, get_args

from pydantic import ValidationError

import calibsolver
from calibdb.camera_key import identify, public_label, public_platform
from calibdb.schema import Board, CalibrationDocument, FitRecord, Track, ViewDocument
from calibdb.schema.licence import Licence
from calibdb.schema.session import SetAside
from calibsolver import CalibrationError, View, fit, models
from calibsolver.fitting.coverage import Coverage, record_covered
from calibsolver.formats import ImportedFile
from calibsolver.formats.base import ReaderOptions
from calibsolver.formats.grid import grid
from calibsolver.formats.reading import read_bytes
from calibsolver.quality.model_selection import suggest_model
from calibsolver.quality.report import describe
from infra.ops import OpsError, reindex
from infra.ops.context import OpsContext
from infra.ops.seed import guess, uncertain_fit

_MAX_FILE_BYTES = 64 * 2**20  # keypoints make files large
_MIN_VIEWS = 4  # from which a fit can be believed without a guide having chosen them
# Corners that a dictionary of 50 markers has room for, and the dictionary for larger boards
_MAX_SMALL_CORNERS, _LARGE_DICTIONARY = 100, "DICT_4X4_1000"
_DEGENERATE = SetAside(reason="degenerate", detail="Its corners lie on a line or in one place.")


@dataclass(frozen=True)
class ReportedCamera:
    """The camera as a browser would report it."""

    camera: str
    platform: str
    zoom: float
    licence: Licence | None  # under which the views may be given away; None: not in dumps


def licence_of(name: str | None) -> Licence | None:
    """Return the licence with this SPDX identifier; raises OpsError where dumps are under another."""
    if name not in (None, *get_args(Licence)):
        raise OpsError(f"dumps are given away under {get_args(Licence)[0]}, not under {name!r}")
    return cast("Licence | None", name)


def import_file(
    context: OpsContext,
    path: Path,
    reported: ReportedCamera,
    options: ReaderOptions,
    model: str,
    *,
    dry_run: bool,
) -> str:
    """Store the content of a file and describe it; with `dry_run`, only describe it.

    Keypoints of a board become a calibration; without them it is a first guess for a capture, which lookups
    never return. The same file twice is one calibration; another file of the same keypoints is refused.

    Raises OpsError if the file or its content cannot be used; then nothing is stored.
    """
    if model and model not in models.NAMES:
        raise OpsError(f"there is no distortion model {model!r}")
    read = read_file(path, replace(options, model=model))
    identity = identify(reported.camera, reported.platform)
    if identity.ambiguous or identity.virtual:
        raise OpsError(f"{reported.camera!r} does not say which camera it is")
    if not read.views:
        return _guess(context, path, reported, read, options.number, dry_run=dry_run)
    size = read.camera.img_size if read.camera else options.img_size
    if size is None:
        raise OpsError(f"{path} does not say the size of the pictures: give --img-size")
    document = _document(context, path, reported, identity.key, read.views, size, model)
    keypoints = _keypoints(document)
    mode = reindex.mode_of(document)
    counted = context.store.calibrations.newest(mode, context.settings.thresholds.max_calibrations)
    for stored in context.store.calibrations.read([c.id for c in counted]):
        if stored.id != document.id and _keypoints(stored) == keypoints:
            raise OpsError(f"these keypoints are known already: calibration {stored.id}")
    if not dry_run:
        context.store.calibrations.publish(document)
        reindex.refit(context, mode)
    fitted = document.fits[document.distortion_model]
    aside = f" ({len(document.set_aside)} set aside: degenerate)" if document.set_aside else ""
    return (
        f"calibration {document.id}: {len(document.views)} views{aside}, {document.distortion_model}, "
        f"{fitted.avg_reprojection_error:.3f} px rms"
    )


def read_file(path: Path, options: ReaderOptions = ReaderOptions()) -> ImportedFile:  # noqa: B008 - a value that never changes
    """Read a calibration file of any kind that `calibsolver.formats.reading` knows; raises OpsError."""
    try:
        with path.open("rb") as file:
            raw = file.read(_MAX_FILE_BYTES + 1)
    except OSError as error:
        raise OpsError(f"{path} cannot be read: {error.strerror}") from error
    if len(raw) > _MAX_FILE_BYTES:
        raise OpsError(f"{path} is larger than {_MAX_FILE_BYTES >> 20} MB")
    try:
        return read_bytes(raw, path.suffix, options)
    except CalibrationError as error:
        raise OpsError(f"{path}: {error}") from error


def _keypoints(document: CalibrationDocument) -> list[list[tuple[float, float]]]:
    """Sort the keypoints, which are the same in all files of one capture."""
    return sorted(sorted((round(x, 2), round(y, 2)) for x, y in view.points) for view in document.views)


def _document(
    context: OpsContext,
    path: Path,
    reported: ReportedCamera,
    key: str,
    views: tuple[View, ...],
    size: tuple[int, int],
    model: str,
) -> CalibrationDocument:
    if len(views) < _MIN_VIEWS:
        raise OpsError(f"{path} has {len(views)} views, a calibration needs {_MIN_VIEWS}")
    try:
        layout = grid(views)
        is_small = layout.squares[0] * layout.squares[1] <= _MAX_SMALL_CORNERS
        board = calibsolver.Board(layout.squares, dictionary="DICT_4X4_50" if is_small else _LARGE_DICTIONARY)
        ours = [board.view(ids, view.image_points) for ids, view in zip(layout.ids, views, strict=True)]
        chosen = model or suggest_model(ours, size).model
        calibration = fit(ours, size, model=chosen)
        indices = [i for i in range(len(ours)) if calibration.cut_views.get(i) != "degenerate"]
        if len(indices) < _MIN_VIEWS:
            raise OpsError(f"{path} has {len(indices)} usable views, a calibration needs {_MIN_VIEWS}")
    except CalibrationError as error:
        raise OpsError(f"{path}: {error}") from error
    digest = hashlib.sha256(path.read_bytes() + f"/{key}/{chosen}".encode()).hexdigest()
    try:
        return CalibrationDocument(
            id=f"{key}-{digest[:20]}",
            camera_key=key,
            camera=public_label(reported.camera),
            platform=public_platform(reported.platform),
            img_size=size,
            zoom=reported.zoom,
            distortion_model=chosen,
            board=Board.model_validate({"squares": board.squares, "dictionary": board.dictionary}),
            guidance="projection-uncertainty",
            target_error=0.3 * size[0] / 1280,
            track=Track(),
            views=tuple(
                _view(i, layout.ids[i], ours[i], rms=float(calibration.view_errors[i])) for i in indices
            ),
            set_aside=tuple(
                _view(i, layout.ids[i], ours[i], set_aside=_DEGENERATE)
                for i in range(len(ours))
                if i not in indices
            ),
            fits={
                chosen: FitRecord.model_validate(record_covered(calibration, Coverage.of(calibration, ours)))
            },
            report=describe(calibration, ours),
            solver=calibsolver.FIT_VERSION,
            contributor=f"import-{digest[:12]}",
            time=context.now,
            licence=reported.licence,
        )
    except ValidationError as error:
        what = error.errors(include_url=False)[0]
        raise OpsError(f"{path}: {'.'.join(map(str, what['loc']))}: {what['msg']}") from error


def _view(index: int, ids: tuple[int, ...], view: View, **judgement: Any) -> ViewDocument:
    points = tuple((float(x), float(y)) for x, y in view.image_points)
    return ViewDocument(index=index, ids=ids, points=points, **judgement)


def _guess(
    context: OpsContext,
    path: Path,
    reported: ReportedCamera,
    read: ImportedFile,
    number: int,
    *,
    dry_run: bool,
) -> str:
    camera = read.camera
    if camera is None:
        raise OpsError(f"{path} contains neither a camera nor keypoints")
    try:
        record = uncertain_fit(
            camera.model, camera.img_size, camera.matrix.tolist(), camera.distortion.tolist()
        )
    except ValidationError as error:
        raise OpsError(f"{path}: {error.errors(include_url=False)[0]['msg']}") from error
    if not dry_run:
        prior = guess(reported.camera, reported.platform, reported.zoom, record, path.name)
        context.store.priors.keep(prior)
    fx, fy = (camera.matrix[i, i] for i in range(2))
    size = f"{camera.img_size[0]} x {camera.img_size[1]}"
    said = f"a first guess: {camera.model}, {size}, fx {fx:.6g}, fy {fy:.6g}"
    said += ", without keypoints; lookups never return it"
    if len(read.cameras) > 1:
        said += f"; camera {number} ({read.cameras[number]}) of {len(read.cameras)} in the file: "
        said += f"--camera-number takes another, 0 to {len(read.cameras) - 1}"
    return said
