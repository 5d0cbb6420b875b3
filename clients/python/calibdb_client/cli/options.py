"""Options that several commands share, and their values."""

from __future__ import annotations

import os
import re
import sys
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from ..board import DICTIONARIES, KINDS, Board
from ..errors import CalibDBError, MissingPackageError, UsageError
from ..key import AUTO, DEFAULT_MODEL, MODELS, CameraKey
from ..session import LICENCE, LICENCE_VERSION
from .output import Output

if TYPE_CHECKING:
    from ..calibration import Calibration
    from ..client import Client

_QUESTION = f"""The database gives calibrations away under {LICENCE}: to anyone, for any purpose, permanently
(terms of {LICENCE_VERSION}, /terms/ of the site).
Corners and calibration may go into its public dumps if you agree; pictures never leave this machine.
Agree? [y/N] """


def add_command(
    commands: Any, name: str, run: Callable[[Namespace, Output], int], help_text: str, description: str
) -> ArgumentParser:
    """Add a command to the parser, and return its own."""
    parser: ArgumentParser = commands.add_parser(name, help=help_text, description=description)
    parser.set_defaults(run=run)
    return parser


def size(text: str) -> tuple[int, int]:
    """Read `1280x720`, for argparse."""
    match = re.fullmatch(r"\s*(\d{1,5})\s*[xX×]\s*(\d{1,5})\s*", text)
    if not match:
        raise ArgumentTypeError(f"a size is written as 1280x720, not {text!r}")
    return int(match[1]), int(match[2])


def add_service(parser: ArgumentParser) -> None:
    """Add the options of the service, and `--json`."""
    parser.add_argument("--url", help="address of the service (CALIBDB_URL)")
    parser.add_argument("--token", help="API token (CALIBDB_TOKEN is not seen by other users, this is)")
    parser.add_argument("--timeout", type=float, metavar="S", help="seconds to wait for a response")
    parser.add_argument("--no-cache", action="store_true", help="neither read nor write the cache")
    add_json(parser)


def add_json(parser: ArgumentParser) -> None:
    """Add `--json`."""
    parser.add_argument("--json", action="store_true", help="print one JSON document")


def client(chosen: Namespace) -> Client:
    """Return the client that the options describe."""
    from ..client import Client
    from ..connection import RESPONSE_TIMEOUT_S

    timeout = RESPONSE_TIMEOUT_S if chosen.timeout is None else chosen.timeout
    return Client(chosen.url, chosen.token, timeout=timeout, cache=not chosen.no_cache)


def add_file(parser: ArgumentParser, absent: str = "standard output") -> None:
    """Add the format of a file, and its path; `absent` is its place if no path is given."""
    parser.add_argument(
        "--format",
        metavar="FORMAT",
        help="ros, kalibr, opencv, mrcal, colmap, … (docs/formats.md); by the suffix of -o unless given",
    )
    parser.add_argument("-o", "--output", metavar="FILE", help=f"file to write; {absent} unless given")


def chosen_format(chosen: Namespace, rig: bool = False) -> str:
    """Return the format that the options say. Raises UsageError as `conversion.format_of` does."""
    from .. import conversion

    return conversion.format_of(chosen.format, chosen.output, rig)


def calibration(name: str, chosen: Namespace) -> Calibration:
    """Return the calibration in a file, or the one that the service has under an id."""
    from ..calibration import Calibration

    if Path(name).is_file():
        return Calibration.load(name)
    require_id(name)
    with client(chosen) as service:
        return service.calibration(name)


def require_id(name: str) -> None:
    """Raise UsageError for the path of a file."""
    if "/" in name or re.search(r"\.[A-Za-z]{2,12}$", name):
        raise UsageError(f"{name} is not there")


def add_camera(parser: ArgumentParser) -> None:
    """Add the camera, and what identifies it."""
    parser.add_argument(
        "camera", nargs="?", help="index, path or name of a camera here (see `calibdb cameras`)"
    )
    parser.add_argument("--label", help="label of another machine's camera, as a browser gives it")
    parser.add_argument("--platform", help="its platform, such as 'X11; Linux x86_64'")
    parser.add_argument(
        "--size", type=size, metavar="WxH", help="size of the picture; the camera's own unless given"
    )
    parser.add_argument("--zoom", type=float, default=0.0, help="zoom of the picture")
    parser.add_argument("--device", help="model identifier of a phone, such as iPhone17,3")
    add_lookup_model(parser)


def camera_key(chosen: Namespace) -> CameraKey:
    """Return the key of the camera that the options name.

    Raises UsageError if something is missing, CameraError if the camera is not there.
    """
    from ..devices import find, platform_of

    if (chosen.camera is None) == (chosen.label is None):
        raise UsageError("name a camera: an index such as 0 (see `calibdb cameras`), or --label and --size")
    if chosen.label is not None:
        if chosen.size is None:
            raise UsageError("with --label say --size, such as 1280x720")
        key = CameraKey(chosen.label, chosen.platform or platform_of(), chosen.size, chosen.zoom)
        return key.with_device(chosen.device)
    device = find(chosen.camera)
    shape = chosen.size or _delivered_size(chosen.camera)
    return CameraKey(device.label, chosen.platform or device.platform, shape, chosen.zoom)


def _delivered_size(camera: str) -> tuple[int, int]:
    from ..camera import open_camera

    try:
        with open_camera(camera) as opened:
            return opened.img_size
    except MissingPackageError:
        raise UsageError("say --size, such as 1280x720: without OpenCV the camera cannot be asked") from None
    except CalibDBError as error:
        raise type(error)(f"{error}. With --size the camera need not be opened") from None


def add_lookup_model(parser: ArgumentParser) -> None:
    """Add the distortion model of a lookup."""
    parser.add_argument("--model", choices=MODELS, default=DEFAULT_MODEL, help="distortion model")


def add_model(parser: ArgumentParser) -> None:
    """Add the distortion model of a calibration."""
    parser.add_argument(
        "--model",
        choices=(AUTO, *MODELS),
        default=AUTO,
        help="distortion model; auto: the one that predicts held-out views best",
    )


def add_board(parser: ArgumentParser, recognised: bool = False) -> None:
    """Add the options that describe a board; without them it may be `recognised`."""
    words = "; without any of these options the board is recognised" if recognised else ""
    group = parser.add_argument_group("board", f"ChArUco, 9x6 squares, DICT_4X4_50{words}")
    group.add_argument("--kind", choices=KINDS, help="kind of board")
    group.add_argument(
        "--squares", type=size, metavar="CxR", help="columns and rows; of an AprilGrid its tags"
    )
    group.add_argument(
        "--marker-ratio",
        type=float,
        metavar="R",
        help="side of a marker / side of a square; of circles their diameter / distance",
    )
    group.add_argument(
        "--dictionary", choices=DICTIONARIES, metavar="DICT_…", help="OpenCV's name of the markers"
    )
    group.add_argument("--legacy", action="store_true", default=None, help="layout of OpenCV before 4.6")
    group.add_argument("--inverted", action="store_true", default=None, help="white on black")
    group.add_argument("--tag-spacing", type=float, metavar="R", help="gap between tags / side of a tag")
    group.add_argument(
        "--on-screen",
        dest="surface",
        action="store_const",
        const="screen",
        help="a screen shows the board: no bend is estimated",
    )
    if recognised:
        add_square(parser)


def add_square(parser: ArgumentParser) -> None:
    """Add the side of a square."""
    parser.add_argument("--square-mm", type=float, metavar="MM", help="side of a square, or of a tag")


def chosen_board(chosen: Namespace) -> Board | None:
    """Return the board that the options describe; None if there are none. Raises UsageError."""
    names = ("kind", "squares", "marker_ratio", "dictionary", "legacy", "inverted", "tag_spacing", "surface")
    values = {name: value for name in names if (value := getattr(chosen, name)) is not None}
    if values.get("kind") == "aprilgrid":
        values.setdefault("squares", (6, 6))
    return Board(**values) if values else None


def add_fix(parser: ArgumentParser) -> None:
    """Add what a calibration on this machine does not estimate."""
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


def fix_of(chosen: Namespace) -> dict[str, float | None]:
    """Return the values by name that `--fix` says, None for the default.

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


def add_licence(parser: ArgumentParser) -> None:
    """Add the agreement to the licence."""
    parser.add_argument(
        "--licence",
        metavar=LICENCE,
        help="agree that corners and calibration are given away under CC0 1.0; asked for in a terminal",
    )


def licence_of(chosen: Namespace, output: Output) -> str | None:
    """Return the licence that the contributor agreed to, by the option or by an answer, or None.

    Consent is never assumed: without a terminal and the option there is no licence.
    """
    if getattr(chosen, "offline", False):
        return None
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


def add_contribution(parser: ArgumentParser) -> None:
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
    add_service(parser)


def add_source(parser: ArgumentParser) -> None:
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
    parser.add_argument("--size", type=size, metavar="WxH", help="size of the pictures of a camera")
    add_show(parser)
    add_model(parser)
    add_board(parser, recognised=True)


def add_show(parser: ArgumentParser) -> None:
    """Add the feedback of a live capture."""
    parser.add_argument(
        "--show",
        choices=("auto", "window", "text"),
        default="auto",
        help="guide in a window or by text; auto: a window where there is one",
    )


def kind_of(given: Sequence[str]) -> Literal["camera", "video", "pictures"]:
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


def capture_arguments(chosen: Namespace) -> dict[str, Any]:
    """Return the arguments of a live capture."""
    names = ("label", "platform", "zoom", "size", "show")
    return {**{name: getattr(chosen, name) for name in names}, "board": chosen_board(chosen)}


def new_name(label: str, img_size: tuple[int, int]) -> Path:
    """Return the name of a camera's file that is not there yet."""
    from calibsolver.formats import slug

    return free_path(f"{slug(label)}-{img_size[0]}x{img_size[1]}")


def free_path(stem: str) -> Path:
    """Return a JSON file that is not there yet."""
    for n in range(1, 10_000):
        path = Path(f"{stem}.json" if n == 1 else f"{stem}-{n}.json")
        if not path.exists():
            return path
    raise UsageError(f"there are too many files called {stem}: say --output")
