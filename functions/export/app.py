"""Export: one stored calibration, or one consensus, or a file of another tool, as another tool's file."""

from __future__ import annotations

import base64
import re
from dataclasses import replace
from typing import TYPE_CHECKING

from starlette.responses import Response

from calibdb.camera_key import VERSION, current_key
from calibdb.camera_key.visible import visible
from calibdb.errors import GoneError, InvalidError, NotFoundError
from calibdb.http import application
from calibdb.schema import CalibrationDocument, ConvertRequest, ExportQuery, FitRecord, ReportedCalibration
from calibdb.schema.fields import label_text

if TYPE_CHECKING:
    from calibsolver import View
    from calibsolver.formats import ExportedFile, ExportSource

COMMAND_LINE = re.compile(r"\s*\(--[^()]*\)|: give it \(--[^()]*\)")
"""Advice in messages of the solver to those who use the operator's command line."""
MAX_MESSAGE = 1000
"""Characters of what the solver says about a file, which may quote the file."""
AS_IT_IS = {"X-Conversion-Error": "0", "X-Conversion-Coverage": "1"}


def show(call: application.Call) -> Response:
    """Answer with the calibration in the format asked for; what is computed for it counts as a view does."""
    token = call.api_token()
    asked = call.query(ExportQuery)
    if asked.without or not asked.plain:
        call.service.charge(token, "views", call.address)
    store = call.service.store.calibrations
    document = store.get(call.path("id"))
    if document is not None and (reason := store.withdrawal(document)) is not None:
        raise GoneError("This calibration was withdrawn.", kind="withdrawn", extensions={"reason": reason})
    if asked.plain and not asked.without:
        return application.json_response(read_calibration(call, document), headers=AS_IT_IS)
    # Here and not above: who only wants to see a calibration need not wait for the solver.
    from calibsolver import DeadlineError, deadline

    try:
        with deadline.limit(call.seconds_left):
            return compute_answer(call, document, asked)
    except DeadlineError as error:
        name = "without" if asked.without else "format"
        slow = "takes longer to compute than a request may; ask for a larger picture, or another format"
        raise call.out_of_time(InvalidError.field(name, slow)) from error


def read_calibration(call: application.Call, document: CalibrationDocument | None) -> ReportedCalibration:
    """Return the calibration of a document, or else the consensus asked for; raises NotFoundError."""
    known = to_reported(document) if document is not None else consensus(call, call.path("id"))
    if known is None:
        raise NotFoundError("The database has no calibration with this id.")
    return known


def compute_answer(
    call: application.Call, document: CalibrationDocument | None, asked: ExportQuery
) -> Response:
    """Answer with what is computed for the call: without some views, or as a file."""
    if document is not None and asked.without:
        document = refit_without(document, asked.without)
    known = read_calibration(call, document)
    if asked.without:
        if document is None:
            raise InvalidError.field("without", "a consensus has no views of its own")
        known = known.model_copy(update={"id": None})  # it is stored nowhere
    return application.json_response(known, headers=AS_IT_IS) if asked.plain else file(known, document, asked)


def to_reported(document: CalibrationDocument) -> ReportedCalibration:
    """Return a single calibration, with what its session found out about it."""
    key = current_key(document.camera_key, document.camera, document.platform)
    report = dict(document.report or {})
    covariance = report.pop("covariance", None)
    return ReportedCalibration(
        **dict(document.answer()),
        report=report or None,
        covariance=covariance,
        board=document.board,
        board_shape=document.fits[document.distortion_model].board_shape,
        camera_key=key,
        **document.consent,
    )


def refit_without(document: CalibrationDocument, without: tuple[int, ...]) -> CalibrationDocument:
    """Refit the calibration without these views."""
    from calibsolver import Board, CalibrationError, fit
    from calibsolver.fitting.coverage import Coverage, record_covered
    from calibsolver.quality import report
    from calibsolver.quality.rivals import with_rivals

    unknown = sorted(set(without) - {view.index for view in document.views})
    if unknown:
        raise InvalidError.field("without", f"the calibration has no view {unknown[0]}")
    left = tuple(view for view in document.views if view.index not in without)
    views = Board.from_record(document.board.model_dump()).views([view.model_dump() for view in left])
    try:
        made = fit(views, document.img_size, document.distortion_model, board_shape=True)
    except CalibrationError as error:
        raise InvalidError.field("without", error.message) from error
    made = with_rivals(made, views)
    described = report.describe(made, views, [view.index for view in left])
    fits = {document.distortion_model: FitRecord(**record_covered(made, Coverage.of(made, views)))}
    return document.model_copy(update={"views": left, "fits": fits, "report": described})


def consensus(call: application.Call, calibration_id: str) -> ReportedCalibration | None:
    """Return the consensus with this id, None when there is none."""
    store = call.service.store
    found = store.consensuses.get(calibration_id)
    key, mark, place = calibration_id.partition("~")
    if found is None and mark and not key.startswith(f"{VERSION}-"):
        others = store.cameras.known(key).same_as  # of a key that was made by earlier rules
        found = store.consensuses.get(f"{others[0]}~{place}") if len(others) == 1 else None
    calibration = found.calibration if found else None
    if found is None or calibration is None:
        return None
    behind = store.consensuses.groups(found)
    covariance = behind.covariance if behind else None
    return ReportedCalibration(**dict(calibration), covariance=covariance, camera_key=found.camera_key)


def file(found: ReportedCalibration, document: CalibrationDocument | None, asked: ExportQuery) -> Response:
    """Return the calibration as a file, and in its headers how far that is from the calibration."""
    from calibsolver import Board, CalibrationError, Camera, formats, image_transform

    board: Board | None = None
    views: tuple[View, ...] = ()
    if document is not None:
        board = Board.from_record(document.board.model_dump())
        views = tuple(board.views([view.model_dump() for view in document.views]))
    subject = formats.ExportSource(
        camera=Camera.from_record(found.model_dump()),
        views=views,
        board=board,
        name=found.camera,
        identifier=found.id or "",
        rms=found.avg_reprojection_error,
        time=found.calibration_time,
        record=found.model_dump(exclude={"report", "covariance", "board", "camera_key"}),
    )
    try:
        change = image_transform.identity(found.img_size)
        if asked.crop is not None:
            change = change.then(image_transform.crop(change.img_size, asked.crop[:2], asked.crop[2:]))
        if asked.resize is not None:
            change = change.then(image_transform.resize(change.img_size, asked.resize))
        change = change.then(image_transform.rotate(change.img_size, asked.rotate))
        if asked.mirror:
            change = change.then(image_transform.mirror(change.img_size))
    except CalibrationError as error:
        raise InvalidError.field("crop" if asked.crop else "resize", error.message) from error
    try:
        written = formats.write(subject, asked.format, change)
    except CalibrationError as error:
        raise InvalidError.field("format", error.message) from error
    return to_response(written)


def to_response(written: ExportedFile) -> Response:
    """Answer with a file, and in the headers how far it is from what was to be written."""
    headers = {
        "Content-Disposition": f'attachment; filename="{written.filename}"',
        "X-Conversion-Error": f"{written.error:.6g}",
        "X-Conversion-Coverage": f"{written.coverage:.4g}",
    }
    if written.warning:
        headers["X-Conversion-Warning"] = written.warning
    return Response(written.content, 200, headers, written.media_type)


def convert(call: application.Call) -> Response:
    """Answer with another program's file in the format asked for; it counts as a view does."""
    token = call.api_token()
    asked = call.json(ConvertRequest)
    call.service.charge(token, "views", call.address)
    # Here and not above: who only wants to see a calibration need not wait for the solver.
    from calibsolver import DeadlineError, deadline

    try:
        with deadline.limit(call.seconds_left):
            return to_response(convert_file(asked))
    except DeadlineError as error:
        slow = "takes longer to convert than a request may; ask for another format"
        raise call.out_of_time(InvalidError.field("format", slow)) from error


def convert_file(asked: ConvertRequest) -> ExportedFile:
    """Return the camera of a file, written in another format.

    Raises InvalidError: of the field `file` where no camera can be read, of `format` where it cannot be held.
    """
    from calibsolver import CalibrationError, formats
    from calibsolver.formats.reader_options import ReaderOptions
    from calibsolver.formats.reading import read_bytes

    options = ReaderOptions(img_size=asked.img_size, number=asked.number, model=asked.distortion_model or "")
    try:
        found = read_bytes(content_of(asked), "", options)
    except CalibrationError as error:
        said = COMMAND_LINE.sub("", visible(str(error)[:MAX_MESSAGE]))
        raise InvalidError.field("img_size" if "size of the pictures" in said else "file", said) from error
    if found.camera is None:
        raise InvalidError.field("file", "it has corners, and no camera: calibrate with them")
    name = asked.camera or label_text(found.name) or "camera"
    source = formats.ExportSource(found.camera, name=name, record={"camera": name, "platform": "", "zoom": 0})
    if asked.format == "photonvision" and found.views:
        source = with_corners(source, found.views)
    try:
        return formats.write(source, asked.format)
    except CalibrationError as error:
        raise InvalidError.field("format", error.message) from error


def with_corners(source: ExportSource, views: tuple[View, ...]) -> ExportSource:
    """Return the source with the corners that its file has: pages read them of PhotonVision's files alone."""
    from calibsolver import Board, CalibrationError
    from calibsolver.formats.grid import grid

    try:
        numbered = grid(views)
        board = Board(numbered.squares, kind="chessboard")  # which has no markers to run out of
        seen = tuple(board.view(ids, v.image_points) for ids, v in zip(numbered.ids, views, strict=True))
    except (CalibrationError, ValueError) as error:
        raise InvalidError.field("file", f"its corners are those of no board: {error}") from error
    return replace(source, board=board, views=seen)


def content_of(asked: ConvertRequest) -> bytes:
    """Return the bytes of the file."""
    if asked.encoding == "text":
        return asked.file.encode()
    try:
        return base64.b64decode(asked.file, validate=True)
    except ValueError as error:  # binascii's is one, and so is what is said of characters beyond ASCII
        raise InvalidError.field("file", f"it is no base64: {error}") from error


handler = application.handler(
    application.route("/v1/calibrations/{id}", GET=show), application.route("/v1/convert", POST=convert)
)
