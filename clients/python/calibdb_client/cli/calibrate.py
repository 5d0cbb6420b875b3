"""The commands `calibrate` and `submit`."""

from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

from .. import pictures
from ..board import Board, opencv
from ..calibration import Calibration
from ..errors import CalibDBError, CaptureError, MirroredError, MissingPackageError, UsageError
from ..files import write_whole
from ..key import UNNAMED, CameraKey
from ..offline import calibrate_recording
from ..pictures import MAX_PICTURES, PLATFORM, FoundViews, picture_paths, read, turned_by_camera
from ..recording import Recording
from . import live, options
from .output import Output, progress


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands,
        "calibrate",
        run,
        "calibrate a camera live, from a video or from pictures of a board",
        "Calibrate a camera: live, guided in a window or by text, hands-free; from a video; or "
        "from pictures of a board. Only the corners are sent, or nothing with --offline. They are written "
        "to a file first, so that nothing is lost.",
    )
    options.add_source(parser)
    parser.add_argument("--mirrored", action="store_true", help="the pictures are mirrored: turn them back")
    options.add_file(parser, "a new one")
    options.add_fix(parser)
    parser.add_argument("-v", "--verbose", action="store_true", help="print a row for each picture")
    options.add_contribution(parser)


def run(chosen: Namespace, output: Output) -> int:
    """Find the corners, keep them, and calibrate."""
    kind, source = options.kind_of(chosen.source), chosen.source[0]
    path = live.kept_path(chosen)
    options.fix_of(chosen)  # refused before anything is read
    if kind == "camera":
        if chosen.fix or chosen.start:
            raise UsageError(
                "--fix and --start are for pictures: capture first, then `calibdb submit FILE --fix`"
            )
        return live.run(chosen, output)
    if not (chosen.label or chosen.offline):
        raise UsageError("which camera took them? Say --label, or --offline to calibrate for yourself alone")
    chosen.licence = options.licence_of(chosen, output)
    opencv()  # says what is missing before anything is read
    board_views, interrupted = FoundViews(), False
    paths = picture_paths(chosen.source) if kind == "pictures" else []
    most = None if chosen.offline else MAX_PICTURES
    if most and len(paths) > most:
        output.note(f"{len(paths)} pictures: {MAX_PICTURES} of them are read, spread evenly over their names")
    board = options.chosen_board(chosen)
    if board is None:
        board = _recognise_board(kind, source, paths, chosen.mirrored)
        guessed = " (a guess: say --tag-spacing if you know it)" if board.kind == "aprilgrid" else ""
        output.note(f"board: {board}{guessed}")
    try:
        with progress("frames" if kind == "video" else "pictures") as advance:
            if kind == "video":
                from ..capture.video import read_video

                read_video(source, board, board_views, advance, chosen.mirrored)
            else:
                read(paths, board, board_views, advance, most, chosen.mirrored)
    except KeyboardInterrupt:
        if not board_views.views:
            raise
        interrupted = True
    if not (board_views.views or board_views.frames or chosen.mirrored):
        _require_upright(kind, source, paths)
    size, views = board_views.of_one_size(limited=not chosen.offline)
    _describe(board_views, size, len(views), chosen.verbose, output)
    if turned_by_camera(paths):
        output.note(
            "the pictures have an EXIF orientation, which is not applied: the calibration is of the file's "
            "pixels, and programs that turn them (cv2.imread without IMREAD_IGNORE_ORIENTATION) need another"
        )
    key = CameraKey(chosen.label or UNNAMED, chosen.platform or PLATFORM, size, chosen.zoom or 0.0)
    recording = Recording(key, board, views)
    path = path or options.new_name(chosen.label or _folder(source), size)
    write_whole(path, recording.content())
    if interrupted:
        output.note(
            f"interrupted: {len(views)} views are in {path}; `calibdb submit {path}` goes on with them"
        )
        raise KeyboardInterrupt
    return _finish(recording, path, chosen, output)


def _recognise_board(kind: str, source: str, paths: list[Path], mirrored: bool) -> Board:
    if kind == "pictures":
        return pictures.recognise_board(paths, mirrored)
    from ..capture.video import board_in_video

    return board_in_video(source, mirrored)


def _require_upright(kind: str, source: str, paths: list[Path]) -> None:
    """Raise MirroredError if pictures in which the board was not found are mirrored."""
    try:
        _recognise_board(kind, source, paths, mirrored=False)
    except MirroredError:
        raise
    except CaptureError:
        return


def _finish(recording: Recording, path: Path, chosen: Namespace, output: Output) -> int:
    """Calibrate from a recording that is in a file, write the result there, and print it."""
    try:
        if chosen.offline:
            start = Calibration.load(chosen.start) if chosen.start else None
            result = calibrate_recording(recording, chosen.model, fix=options.fix_of(chosen), start=start)
        else:
            consent = {"licence": chosen.licence, "mode_name": chosen.mode_name}
            with options.client(chosen) as client, progress("views") as advance:
                result = client.submit(recording, chosen.model, advance, **consent)
    except CaptureError:
        raise
    except CalibDBError as error:
        offline = " --offline" if isinstance(error, MissingPackageError) else ""
        output.note(f"the corners are kept in {path}: `calibdb submit {path}{offline}` goes on with them")
        raise
    return live.conclude(recording, result, path, chosen, output)


def add_submit(commands: Any) -> None:
    """Add the command `submit` to the parser."""
    parser = options.add_command(
        commands,
        "submit",
        submit,
        "send the corners that `calibrate` kept",
        "Send the corners in a file that `calibdb calibrate` wrote, or calibrate them again.",
    )
    parser.add_argument("file", help="file that `calibdb calibrate` wrote")
    parser.add_argument("--label", help="label of the camera, if another one than the file's")
    parser.add_argument("--platform", help=f"its platform, if not the file's ({PLATFORM})")
    options.add_model(parser)
    options.add_square(parser)
    options.add_fix(parser)
    options.add_contribution(parser)


def submit(chosen: Namespace, output: Output) -> int:
    """Read the file and calibrate."""
    options.fix_of(chosen)  # refused before anything is read
    path = Path(chosen.file)
    recording = Recording.load(path)
    if not (chosen.offline or chosen.label) and recording.key.camera == UNNAMED:
        raise UsageError("which camera took the pictures? Say --label, and --platform if a browser used it")
    chosen.licence = options.licence_of(chosen, output)
    camera, platform = chosen.label or recording.key.camera, chosen.platform or recording.key.platform
    key = replace(recording.key, camera=camera, platform=platform)
    return _finish(replace(recording, key=key), path, chosen, output)


def _describe(found: FoundViews, size: tuple[int, int], used: int, verbose: bool, output: Output) -> None:
    others = sum(each != size for each, _ in found.views)
    count = len(found.views) - others
    if used < count:
        output.note(f"{used} of {count} views are sent, spread evenly over their names; --offline uses all")
    if others:
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
