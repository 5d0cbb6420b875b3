"""Options of commands that capture: the source, the board, the licence, and how a live capture is shown."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

from ..errors import UsageError
from ..key import AUTO, MODELS
from ..session import LICENCE, LICENCE_VERSION
from . import options
from .board import add_board, chosen_board
from .output import Output

Kind = Literal["camera", "video", "pictures"]

_QUESTION = f"""The database gives calibrations away under {LICENCE}: to anyone, for any purpose, permanently
(terms of {LICENCE_VERSION}, /terms/ of the site).
Corners and calibration may go into its public dumps if you agree; pictures never leave this machine.
Agree? [y/N] """


def add_model(parser: argparse.ArgumentParser) -> None:
    """Add the option of the distortion model."""
    parser.add_argument(
        "--model",
        choices=(AUTO, *MODELS),
        default=AUTO,
        help="distortion model; auto: the one that predicts held-out views best",
    )


def add_fix(parser: argparse.ArgumentParser) -> None:
    """Add the options of what a calibration on this machine does not estimate."""
    parser.add_argument(
        "--fix",
        metavar="NAME[=VALUE],…",
        help="with --offline: what is not estimated, such as aspect, center, tangential, k3, fx=812,fy=812",
    )
    parser.add_argument(
        "--start",
        metavar="FILE",
        help="with --offline: calibration to start from; --fix without values holds what it has",
    )


def fix_of(chosen: argparse.Namespace) -> dict[str, float | None]:
    """Return the values by name that `--fix` says, None if it says none.

    Raises UsageError for a value that is not a number, or if the service would calibrate.
    """
    if not chosen.offline and (chosen.fix or chosen.start):
        raise UsageError("the service estimates all parameters: --fix and --start need --offline")
    out: dict[str, float | None] = {}
    for part in filter(None, (part.strip() for part in (chosen.fix or "").split(","))):
        name, given, value = part.partition("=")
        try:
            out[name.strip()] = float(value) if given else None
        except ValueError:
            raise UsageError(f"--fix {part}: {value!r} is not a number") from None
    return out


def add_licence(parser: argparse.ArgumentParser) -> None:
    """Add the option by which a contributor agrees to the licence."""
    parser.add_argument(
        "--licence",
        metavar=LICENCE,
        help="agree that corners and calibration are given away under CC0 1.0; asked for in a terminal",
    )


def add_contribution(parser: argparse.ArgumentParser) -> None:
    """Add the options of a calibration: sent to the service or not, the licence, the camera's mode."""
    parser.add_argument(
        "--offline", action="store_true", help="calibrate here, with calibsolver; send nothing"
    )
    add_licence(parser)
    parser.add_argument(
        "--mode-name",
        metavar="NAME",
        help='name of the mode that the camera is in, such as "stabilisation on"; public',
    )
    options.add_service(parser)


def add_source(parser: argparse.ArgumentParser) -> None:
    """Add the source, the options of its camera, and those of the board."""
    parser.add_argument(
        "source",
        nargs="+",
        help="camera here (index, path or name), address of a stream (rtsp://, http://), video file, "
        "pictures, or folders of pictures",
    )
    parser.add_argument("--label", help="label of the camera, as a browser gives it")
    parser.add_argument("--platform", help="its platform, where a browser used it")
    parser.add_argument("--zoom", type=float, help="zoom, or focal length of a photograph in mm")
    parser.add_argument("--size", type=options.size, metavar="WxH", help="size of the pictures of a camera")
    add_show(parser)
    add_model(parser)
    add_board(parser, recognised=True)


def add_show(parser: argparse.ArgumentParser) -> None:
    """Add the option how a live capture is shown."""
    parser.add_argument(
        "--show",
        choices=("auto", "window", "text"),
        default="auto",
        help="guide in a window or by text; auto: a window where there is one",
    )


def kind_of(given: Sequence[str]) -> Kind:
    """Return the kind of source that arguments name. Raises UsageError for a path that is not there."""
    from ..capture.source import is_stream, is_video

    first = given[0]
    if len(given) == 1:
        if is_stream(first) or re.fullmatch(r"\d{1,4}|/dev/\w+", first):
            return "camera"
        if is_video(first):
            return "video"
        is_path = Path(first).exists() or "/" in first or os.sep in first or re.search(r"\.\w{2,5}$", first)
        if not is_path:
            return "camera"  # by its name
    for each in given:
        if not Path(each).exists():
            raise UsageError(f"{each} is not there")
    return "pictures"


def licence_of(chosen: argparse.Namespace, output: Output) -> str | None:
    """Return the licence that the contributor agreed to, by the option or by an answer; None: to none.

    Consent is never assumed: without a terminal and the option there is no licence.
    """
    if chosen.licence is not None:
        if chosen.licence != LICENCE:
            raise UsageError(f"--licence is {LICENCE}, or left out, not {chosen.licence!r}")
        return LICENCE
    if chosen.json or not (sys.stdin.isatty() and sys.stderr.isatty()):
        return None
    print(_QUESTION, end="", file=sys.stderr, flush=True)
    agreed = sys.stdin.readline().strip().lower() in ("y", "yes")
    if not agreed:
        output.note("not agreed: the calibration counts in consensuses, and stays out of the dumps")
    return LICENCE if agreed else None


def new_name(label: str, size: tuple[int, int]) -> Path:
    """Return the name of a camera's file that is not there yet."""
    from calibsolver.formats import slug

    return free_path(f"{slug(label)}-{size[0]}x{size[1]}")


def free_path(stem: str) -> Path:
    """Return a JSON file that is not there yet."""
    for n in range(1, 10_000):
        path = Path(f"{stem}.json" if n == 1 else f"{stem}-{n}.json")
        if not path.exists():
            return path
    raise UsageError(f"there are too many files called {stem}: say --output")


def capture_arguments(chosen: argparse.Namespace) -> dict[str, Any]:
    """Return the arguments of a live capture that the options say."""
    return {
        "label": chosen.label,
        "platform": chosen.platform,
        "zoom": chosen.zoom,
        "size": chosen.size,
        "board": chosen_board(chosen),
        "show": chosen.show,
    }
