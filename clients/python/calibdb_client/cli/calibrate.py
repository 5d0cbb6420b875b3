"""The commands `calibrate` and `submit`: a live camera, a video, pictures or kept corners are calibrated."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from .. import pictures
from ..board import opencv
from ..calibration import Calibration
from ..errors import CalibDBError, CaptureError, MirroredError, MissingPackageError, UsageError
from ..files import write_whole
from ..key import UNNAMED, CameraKey
from ..offline import calibrate_recording
from ..pictures import MAX_PICTURES, PLATFORM, FoundViews, picture_paths, read, turned_by_camera
from ..recording import Recording
from . import live, options
from .board import add_square, chosen_board
from .capture_options import (
    add_contribution,
    add_fix,
    add_model,
    add_source,
    fix_of,
    kind_of,
    licence_of,
    new_name,
)
from .conclusion import NO_TARGET, Target, conclude, target_of
from .output import Output, progress


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "calibrate",
        help="calibrate a camera live, from a video or from pictures of a board",
        description="Calibrate a camera: live, guided in a window or by text, hands-free; from a video; or "
        "from pictures of a board. Only the corners are sent, or nothing with --offline. They are written "
        "to a file first, so that nothing is lost.",
    )
    add_source(parser)
    parser.add_argument("--mirrored", action="store_true", help="the pictures are mirrored: turn them back")
    options.add_file(parser, "a new one")
    add_fix(parser)
    parser.add_argument("-v", "--verbose", action="store_true", help="print a row for each picture")
    add_contribution(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Find the corners, keep them, and calibrate."""
    kind = kind_of(chosen.source)
    target = target_of(chosen)
    fix_of(chosen)  # refused before anything is read
    if kind == "camera":
        if chosen.fix or chosen.start:
            raise UsageError(
                "--fix and --start are for pictures: capture first, then `calibdb submit FILE --fix`"
            )
        return live.run(chosen, output)
    if not (chosen.label or chosen.offline):
        raise UsageError("which camera took them? Say --label, or --offline to calibrate for yourself alone")
    chosen.licence = None if chosen.offline else licence_of(chosen, output)
    opencv()  # says what is missing before anything is read
    board_views = FoundViews()
    board, interrupted = None, False
    paths = picture_paths(chosen.source) if kind == "pictures" else []
    most = None if chosen.offline else MAX_PICTURES
    if most and len(paths) > most:
        output.note(f"{len(paths)} pictures: {MAX_PICTURES} of them are read, spread evenly over their names")
    board = chosen_board(chosen) or recognise_board(kind, chosen.source[0], paths, output, chosen.mirrored)
    try:
        with progress("frames" if kind == "video" else "pictures") as advance:
            if kind == "video":
                from ..capture.video import read_video

                read_video(chosen.source[0], board, board_views, advance, chosen.mirrored)
            else:
                read(paths, board, board_views, advance, most, chosen.mirrored)
    except KeyboardInterrupt:
        if not board_views.views:
            raise
        interrupted = True
    if not (board_views.views or board_views.frames or chosen.mirrored):
        _require_upright(kind, chosen.source[0], paths)
    size, views = board_views.of_one_size(limited=not chosen.offline)
    _describe(board_views, size, len(views), chosen.verbose, output)
    if turned_by_camera(paths):
        output.note(
            "the pictures have an EXIF orientation, which is not applied: the calibration is of the file's "
            "pixels, and programs that turn them (cv2.imread without IMREAD_IGNORE_ORIENTATION) need another"
        )
    key = CameraKey(chosen.label or UNNAMED, chosen.platform or PLATFORM, size, chosen.zoom or 0.0)
    recording = Recording(key, board, views)
    path = target.kept or new_name(chosen.label or _folder(chosen.source[0]), size)
    write_whole(path, recording.content())
    if interrupted:
        output.note(
            f"interrupted: {len(views)} views are in {path}; `calibdb submit {path}` goes on with them"
        )
        raise KeyboardInterrupt
    return finish(recording, path, chosen, output, target)


def recognise_board(kind: str, source: str, paths: list[Path], output: Output | None, mirrored: bool) -> Any:
    """Return the board that pictures or a video show, and write which it is."""
    if kind == "video":
        from ..capture.video import board_in_video

        board = board_in_video(source, mirrored)
    else:
        board = pictures.recognise_board(paths, mirrored)
    if output:
        guessed = " (a guess: say --tag-spacing if you know it)" if board.kind == "aprilgrid" else ""
        output.note(f"board: {board}{guessed}")
    return board


def _require_upright(kind: str, source: str, paths: list[Path]) -> None:
    """Raise MirroredError if pictures in which the board was not found are mirrored."""
    try:
        recognise_board(kind, source, paths, None, mirrored=False)
    except MirroredError:
        raise
    except CaptureError:
        return


def finish(
    recording: Recording,
    path: Path,
    chosen: argparse.Namespace,
    output: Output,
    target: Target = NO_TARGET,
) -> int:
    """Calibrate from a recording that is in a file, write the result there, and print it."""
    try:
        if chosen.offline:
            start = Calibration.load(chosen.start) if chosen.start else None
            result = calibrate_recording(recording, chosen.model, fix=fix_of(chosen), start=start)
        else:
            with options.client(chosen) as client, progress("views") as advance:
                result = client.submit(
                    recording,
                    chosen.model,
                    advance,
                    licence=chosen.licence,
                    mode_name=chosen.mode_name,
                )
    except CaptureError:
        raise
    except CalibDBError as error:
        offline = " --offline" if isinstance(error, MissingPackageError) else ""
        output.note(f"the corners are kept in {path}: `calibdb submit {path}{offline}` goes on with them")
        raise
    return conclude(recording, result, path, chosen, output, target)


def add_submit(commands: Any) -> None:
    """Add the command `submit` to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "submit",
        help="send the corners that `calibrate` kept",
        description="Send the corners in a file that `calibdb calibrate` wrote, or calibrate them again.",
    )
    parser.add_argument("file", help="file that `calibdb calibrate` wrote")
    parser.add_argument("--label", help="label of the camera, if another one than the file's")
    parser.add_argument("--platform", help=f"its platform, if not the file's ({PLATFORM})")
    add_model(parser)
    add_square(parser)
    add_fix(parser)
    add_contribution(parser)
    parser.set_defaults(run=submit)


def submit(chosen: argparse.Namespace, output: Output) -> int:
    """Read the file and calibrate."""
    fix_of(chosen)  # refused before anything is read
    path = Path(chosen.file)
    recording = Recording.load(path)
    if not (chosen.offline or chosen.label) and recording.key.camera == UNNAMED:
        raise UsageError("which camera took the pictures? Say --label, and --platform if a browser used it")
    chosen.licence = None if chosen.offline else licence_of(chosen, output)
    key = replace(
        recording.key,
        camera=chosen.label or recording.key.camera,
        platform=chosen.platform or recording.key.platform,
    )
    return finish(replace(recording, key=key), path, chosen, output)


def _describe(found: FoundViews, size: tuple[int, int], used: int, verbose: bool, output: Output) -> None:
    count = len(found.views) - found.other_sizes(size)
    if used < count:
        output.note(f"{used} of {count} views are sent, spread evenly over their names; --offline uses all")
    if others := found.other_sizes(size):
        output.note(
            f"left out {others} pictures of another size than {size[0]}x{size[1]}: calibrate them apart"
        )
    if found.empty:
        output.note(f"no board was detected in {len(found.empty)} pictures: {_few(found.empty, verbose)}")
    if found.unreadable:
        output.note(f"{len(found.unreadable)} files are not images: {_few(found.unreadable, verbose)}")
    if found.broken:
        output.note(found.broken)


def _few(names: list[str], verbose: bool) -> str:
    return ", ".join(names) if verbose or len(names) <= 5 else ", ".join(names[:5]) + ", … (all with -v)"


def _folder(path: str) -> str:
    folder = Path(path).resolve()
    return (folder if folder.is_dir() else folder.parent).name or "camera"
