"""The command `calibrate`: pictures of a board become a calibration."""

from __future__ import annotations

import argparse
import re
import time
from pathlib import Path
from typing import Any

from ..errors import CalibDBError, CaptureError, MissingPackageError, UsageError
from ..key import DEFAULT_MODEL, MODELS, UNNAMED, CameraKey
from ..pictures import MAX_PICTURES, PLATFORM, Found, picture_paths, read
from ..recording import Recording
from ..session import CaptureResult, calibrate_offline
from . import options
from .board import add_board, chosen_board
from .output import Output, calibration_facts, write_whole
from .progress import progress


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "calibrate",
        help="calibrate from pictures of a board",
        description="Calibrate a camera from pictures of a ChArUco board. Only the corners are sent, or "
        "nothing with --offline. The corners are written to a file first, so that nothing is lost.",
    )
    parser.add_argument("pictures", nargs="+", help="folders of pictures, or pictures")
    parser.add_argument("--label", help="label of the camera; needed unless --offline")
    parser.add_argument("--platform", default=PLATFORM, help="its platform, where a browser used it")
    parser.add_argument("--zoom", type=float, default=0.0, help="zoom, or focal length of a photograph in mm")
    parser.add_argument(
        "--offline", action="store_true", help="calibrate here, with calibsolver; send nothing"
    )
    parser.add_argument("-o", "--output", metavar="FILE", help="file of the result; a new one unless given")
    add_model(parser)
    add_board(parser)
    options.add_service(parser)
    parser.set_defaults(run=run)


def add_model(parser: argparse.ArgumentParser) -> None:
    """Add the option of the distortion model."""
    parser.add_argument("--model", choices=MODELS, default=DEFAULT_MODEL, help="distortion model")


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Find the corners, keep them, and calibrate."""
    if not (chosen.label or chosen.offline):
        raise UsageError("which camera took them? Say --label, or --offline to calibrate for yourself alone")
    board = chosen_board(chosen)
    board.opencv()  # says what is missing before anything is read
    paths = picture_paths(chosen.pictures)
    if len(paths) > MAX_PICTURES:
        output.note(f"{len(paths)} pictures: {MAX_PICTURES} of them are read, spread evenly over their names")
    found = Found()
    interrupted = False
    try:
        with progress("pictures") as advance:
            read(paths, board, found, advance)
    except KeyboardInterrupt:
        if not found.views:
            raise
        interrupted = True
    size, views = found.of_one_size()
    _describe(found, size, output)
    key = CameraKey(chosen.label or UNNAMED, chosen.platform, size, chosen.zoom)
    recording = Recording(key, board, views)
    path = (
        Path(chosen.output) if chosen.output else _new_name(chosen.label or _folder(chosen.pictures[0]), size)
    )
    write_whole(path, recording.content())
    if interrupted:
        output.note(
            f"interrupted: {len(views)} views are in {path}; `calibdb submit {path}` goes on with them"
        )
        raise KeyboardInterrupt
    return finish(recording, path, chosen, output)


def finish(recording: Recording, path: Path, chosen: argparse.Namespace, output: Output) -> int:
    """Calibrate from a recording that is in a file, write the result there, and print it."""
    try:
        if chosen.offline:
            result = calibrate_offline(recording, chosen.model, int(time.time()))
        else:
            with options.client(chosen) as client, progress("views") as advance:
                result = client.submit(recording, chosen.model, advance)
    except CaptureError:
        raise
    except CalibDBError as error:
        offline = " --offline" if isinstance(error, MissingPackageError) else ""
        output.note(f"the corners are kept in {path}: `calibdb submit {path}{offline}` goes on with them")
        raise
    write_whole(path, recording.content(result.calibration.record))
    _print(result, path, output)
    return 0


def _print(result: CaptureResult, path: Path, output: Output) -> None:
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


def _describe(found: Found, size: tuple[int, int], output: Output) -> None:
    if others := found.other_sizes(size):
        output.note(
            f"left out {others} pictures of another size than {size[0]}x{size[1]}: calibrate them apart"
        )
    if found.empty:
        output.note(f"the board is not in {len(found.empty)} pictures: {_few(found.empty)}")
    if found.unreadable:
        output.note(f"{len(found.unreadable)} files are no pictures: {_few(found.unreadable)}")


def _few(names: list[str]) -> str:
    return ", ".join(names[:5]) + (", …" if len(names) > 5 else "")


def _folder(path: str) -> str:
    given = Path(path).resolve()
    return (given if given.is_dir() else given.parent).name or "camera"


def _new_name(label: str, size: tuple[int, int]) -> Path:
    """Return the name of a file that is not there yet."""
    slug = re.sub(r"[^a-z0-9]+", "-", label.lower()).strip("-")[:60] or "camera"
    stem = f"{slug}-{size[0]}x{size[1]}"
    for n in range(1, 10_000):
        path = Path(f"{stem}.json" if n == 1 else f"{stem}-{n}.json")
        if not path.exists():
            return path
    raise UsageError(f"there are too many files called {stem}: say --output")
