"""The command `calibrate`: a live camera, a video or pictures of a board become a calibration."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from ..board import opencv
from ..errors import CalibDBError, CaptureError, MissingPackageError, UsageError
from ..files import write_whole
from ..key import UNNAMED, CameraKey
from ..pictures import MAX_PICTURES, PLATFORM, FoundViews, picture_paths, read
from ..recording import Recording
from ..session import CaptureResult, calibrate_offline
from . import options
from .board import chosen_board
from .capture_options import add_licence, add_source, kind_of, licence_of, new_name
from .output import Output, calibration_facts
from .progress import progress


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
    parser.add_argument(
        "--offline", action="store_true", help="calibrate here, with calibsolver; send nothing"
    )
    parser.add_argument("-o", "--output", metavar="FILE", help="file of the result; a new one unless given")
    add_licence(parser)
    options.add_service(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Find the corners, keep them, and calibrate."""
    from . import live

    kind = kind_of(chosen.source)
    if kind == "camera":
        return live.run(chosen, output)
    if not (chosen.label or chosen.offline):
        raise UsageError("which camera took them? Say --label, or --offline to calibrate for yourself alone")
    chosen.licence = None if chosen.offline else licence_of(chosen, output)
    opencv()  # says what is missing before anything is read
    found = FoundViews()
    board, interrupted = None, False
    paths = picture_paths(chosen.source) if kind == "pictures" else []
    if len(paths) > MAX_PICTURES:
        output.note(f"{len(paths)} pictures: {MAX_PICTURES} of them are read, spread evenly over their names")
    board = chosen_board(chosen) or recognise_board(kind, chosen.source[0], paths, output)
    board.check_opencv()
    try:
        with progress("frames" if kind == "video" else "pictures") as advance:
            if kind == "video":
                from ..capture.video import read_video

                read_video(chosen.source[0], board, found, advance)
            else:
                read(paths, board, found, advance)
    except KeyboardInterrupt:
        if not found.views:
            raise
        interrupted = True
    size, views = found.of_one_size()
    _describe(found, size, output)
    key = CameraKey(chosen.label or UNNAMED, chosen.platform or PLATFORM, size, chosen.zoom or 0.0)
    recording = Recording(key, board, views)
    path = Path(chosen.output) if chosen.output else new_name(chosen.label or _folder(chosen.source[0]), size)
    write_whole(path, recording.content())
    if interrupted:
        output.note(
            f"interrupted: {len(views)} views are in {path}; `calibdb submit {path}` goes on with them"
        )
        raise KeyboardInterrupt
    return finish(recording, path, chosen, output)


def recognise_board(kind: str, source: str, paths: list[Path], output: Output) -> Any:
    """Return the board that pictures or a video show, and say which it is."""
    if kind == "video":
        from ..capture.video import board_in_video

        board = board_in_video(source)
    else:
        from ..images import board_of

        board = board_of(paths)
    output.note(f"board: {board}")
    return board


def finish(recording: Recording, path: Path, chosen: argparse.Namespace, output: Output) -> int:
    """Calibrate from a recording that is in a file, write the result there, and print it."""
    try:
        if chosen.offline:
            result = calibrate_offline(recording, chosen.model, int(time.time()))
        else:
            with options.client(chosen) as client, progress("views") as advance:
                result = client.submit(recording, chosen.model, advance, licence=chosen.licence)
    except CaptureError:
        raise
    except CalibDBError as error:
        offline = " --offline" if isinstance(error, MissingPackageError) else ""
        output.note(f"the corners are kept in {path}: `calibdb submit {path}{offline}` goes on with them")
        raise
    return conclude(recording, result, path, output)


def conclude(recording: Recording, result: CaptureResult, path: Path, output: Output) -> int:
    """Write the result beside its corners, and print it."""
    write_whole(path, recording.content(result.calibration.record))
    for source, why in result.left_out:
        output.note(f"left out {source}: {why}")
    if result.suggested_model:
        output.note(f"--model {result.suggested_model} explains these pictures better")
    for text in result.verdict[1:]:
        output.note(text)
    if output.json:
        output.document(dict(result.calibration.record))
    else:
        rows = [("views", str(result.used)), *calibration_facts(result.calibration.record)]
        verdict = [("verdict", result.verdict[0])] if result.verdict else []
        output.facts([*rows, *verdict])
    output.note(f"wrote {path}")
    return 0


def _describe(found: FoundViews, size: tuple[int, int], output: Output) -> None:
    if others := found.other_sizes(size):
        output.note(
            f"left out {others} pictures of another size than {size[0]}x{size[1]}: calibrate them apart"
        )
    if found.empty:
        output.note(f"the board is not in {len(found.empty)} pictures: {_few(found.empty)}")
    if found.unreadable:
        output.note(f"{len(found.unreadable)} files are no pictures: {_few(found.unreadable)}")
    if found.broken:
        output.note(found.broken)


def _few(names: list[str]) -> str:
    return ", ".join(names[:5]) + (", …" if len(names) > 5 else "")


def _folder(path: str) -> str:
    given = Path(path).resolve()
    return (given if given.is_dir() else given.parent).name or "camera"
