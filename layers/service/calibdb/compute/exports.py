"""Calibrations, rigs and files as other tools' files, and refits without some views."""

import base64
import re
from dataclasses import replace

import numpy as np
from starlette.responses import Response

from calibdb.camera_key.characters import visible
from calibdb.compute.values import board_of, camera_of, in_time, naming, views_of
from calibdb.errors import InvalidError
from calibdb.http.call import Call
from calibdb.schema import CalibrationDocument, ConvertRequest, ExportQuery, FitRecord, ReportedCalibration
from calibdb.schema.fields import label_text
from calibdb.schema.rig import RIG_FORMATS, RigResult
from calibsolver import Board, CalibrationError, View, fit, formats, image_transform
from calibsolver.formats import ExportedFile, ExportSource

# In messages of the solver: advice to users of the command line; and they may quote a file.
_COMMAND_LINE = re.compile(r"\s*\(--[^()]*\)|: give it \(--[^()]*\)")
_MAX_MESSAGE_LENGTH = 1000
RIG_WRITERS = {name: name for name in RIG_FORMATS} | {"opencv_stereo": "opencv-yaml"}


def refit_without(document: CalibrationDocument, without: tuple[int, ...]) -> CalibrationDocument:
    """Refit the calibration without these views."""
    from calibsolver.fitting.coverage import Coverage, record_covered
    from calibsolver.quality import report
    from calibsolver.quality.rivals import with_rivals

    unknown = sorted(set(without) - {view.index for view in document.views})
    if unknown:
        raise InvalidError.field("without", f"the calibration has no view {unknown[0]}")
    left = tuple(view for view in document.views if view.index not in without)
    views = views_of(board_of(document.board), left)
    with naming("without"):
        made = fit(views, document.img_size, document.distortion_model)
    made = with_rivals(made, views)
    described = report.describe(made, views, [view.index for view in left])
    fits = {document.distortion_model: FitRecord(**record_covered(made, Coverage.of(made, views)))}
    return document.model_copy(update={"views": left, "fits": fits, "report": described})


def to_file(
    found: ReportedCalibration, document: CalibrationDocument | None, query: ExportQuery
) -> ExportedFile:
    """Write the calibration as a file; raises InvalidError."""
    source = ExportSource(
        camera=camera_of(found),
        name=found.camera,
        identifier=found.id or "",
        rms=found.avg_reprojection_error,
        time=found.calibration_time,
        record=found.model_dump(exclude={"report", "covariance", "board", "camera_key"}),
    )
    if document is not None:
        board = board_of(document.board)
        source = replace(source, board=board, views=tuple(views_of(board, document.views)))
    with naming("crop" if query.crop else "resize"):
        change = image_transform.identity(found.img_size)
        if query.crop is not None:
            change = change.then(image_transform.crop(change.img_size, query.crop[:2], query.crop[2:]))
        if query.resize is not None:
            change = change.then(image_transform.resize(change.img_size, query.resize))
        change = change.then(image_transform.rotate(change.img_size, query.rotate))
        if query.mirror:
            change = change.then(image_transform.mirror(change.img_size))
    with naming("format"):
        return formats.write(source, query.format, change)


def convert_file(request: ConvertRequest) -> ExportedFile:
    """Write the camera of a file in another format; raises InvalidError."""
    from calibsolver.formats.base import ReaderOptions
    from calibsolver.formats.reading import read_bytes

    options = ReaderOptions(
        img_size=request.img_size, number=request.number, model=request.distortion_model or ""
    )
    content = request.file.encode()
    if request.encoding != "text":
        try:
            content = base64.b64decode(request.file, validate=True)
        except ValueError as error:
            raise InvalidError.field("file", f"it is not base64: {error}") from error
    try:
        camera_file = read_bytes(content, "", options)
    except CalibrationError as error:
        said = _COMMAND_LINE.sub("", visible(str(error)[:_MAX_MESSAGE_LENGTH]))
        raise InvalidError.field("img_size" if "size of the pictures" in said else "file", said) from error
    if camera_file.camera is None:
        raise InvalidError.field("file", "it has corners, and no camera: calibrate with them")
    name = request.camera or label_text(camera_file.name) or "camera"
    source = ExportSource(camera_file.camera, name=name, record={"camera": name, "platform": "", "zoom": 0})
    if request.format == "photonvision" and camera_file.views:
        source = _with_corners(source, camera_file.views)
    with naming("format"):
        return formats.write(source, request.format)


def file_response(file: ExportedFile, *, with_coverage: bool = True) -> Response:
    """Response of a file, with its deviation from the camera."""
    headers = {
        "Content-Disposition": f'attachment; filename="{file.filename}"',
        "X-Conversion-Error": f"{file.error:.6g}",
    }
    if with_coverage:
        headers["X-Conversion-Coverage"] = f"{file.coverage:.4g}"
    if file.warning:
        headers["X-Conversion-Warning"] = file.warning
    return Response(file.content, 200, headers, file.media_type)


def _with_corners(source: ExportSource, views: tuple[View, ...]) -> ExportSource:
    """Add the corners of the file: pages read only PhotonVision's."""
    from calibsolver.formats.grid import grid

    try:
        numbered = grid(views)
        board = Board(numbered.squares, kind="chessboard")  # which has no markers to run out of
        views_on_board = tuple(
            board.view(ids, v.image_points) for ids, v in zip(numbered.ids, views, strict=True)
        )
    except (CalibrationError, ValueError) as error:
        raise InvalidError.field("file", f"its corners are those of no board: {error}") from error
    return replace(source, board=board, views=views_on_board)


def rig_file(call: Call, result: RigResult, name: str) -> ExportedFile:
    """Write the result of a rig as a file; raises InvalidError."""
    from calibsolver.rig import formats as rig_formats

    source = rig_formats.RigSource(
        cameras=[camera_of(one) for one in result.calibrations],
        poses=np.array([[*one.rvec, *one.tvec] for one in result.extrinsics]),
        unit=result.unit,
        names=[f"cam{i} {one.camera}" for i, one in enumerate(result.calibrations)],
        identifier=result.rig_id,
        record=result.model_dump(),
    )
    slow = "takes longer to compute than a request may; ask for another format"
    with naming("format"), in_time(call, InvalidError.field("format", slow)):
        return rig_formats.write(source, RIG_WRITERS[name])
