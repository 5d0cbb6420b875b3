"""Options that several commands share."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import CalibDBError, MissingPackageError, UsageError
from ..key import DEFAULT_MODEL, MODELS, CameraKey

if TYPE_CHECKING:
    from ..calibration import Calibration
    from ..client import Client


def size(text: str) -> tuple[int, int]:
    """Read `1280x720`, for argparse."""
    match = re.fullmatch(r"\s*(\d{1,5})\s*[xX×]\s*(\d{1,5})\s*", text)
    if not match:
        raise argparse.ArgumentTypeError(f"a size is written as 1280x720, not {text!r}")
    return int(match[1]), int(match[2])


def add_service(parser: argparse.ArgumentParser) -> None:
    """Add the options of the service, and `--json`."""
    parser.add_argument("--url", help="address of the service (CALIBDB_URL)")
    parser.add_argument("--token", help="API token (CALIBDB_TOKEN is not seen by other users, this is)")
    parser.add_argument(
        "--timeout", type=float, default=None, metavar="S", help="seconds to wait for a response"
    )
    parser.add_argument("--no-cache", action="store_true", help="neither read nor write the cache")
    parser.add_argument("--json", action="store_true", help="print one JSON document")


def add_file(parser: argparse.ArgumentParser, absent: str = "standard output") -> None:
    """Add the format of a file, and its path; `absent` is its place if no path is given."""
    parser.add_argument(
        "--format",
        metavar="FORMAT",
        help="ros, kalibr, opencv, mrcal, colmap, … (docs/formats.md); by the suffix of -o unless given",
    )
    parser.add_argument("-o", "--output", metavar="FILE", help=f"file to write; {absent} unless given")


def chosen_format(chosen: argparse.Namespace, rig: bool = False) -> str:
    """Return the format that the options say. Raises UsageError as `conversion.format_of` does."""
    from .. import conversion

    return conversion.format_of(chosen.format, chosen.output, rig)


def client(chosen: argparse.Namespace) -> Client:
    """Return the client that the options describe."""
    from ..client import Client
    from ..connection import RESPONSE_TIMEOUT_S

    return Client(
        chosen.url,
        chosen.token,
        timeout=RESPONSE_TIMEOUT_S if chosen.timeout is None else chosen.timeout,
        cache=not chosen.no_cache,
    )


def calibration(name: str, chosen: argparse.Namespace) -> Calibration:
    """Return the calibration in a file, or the one that the service has under an id."""
    from ..calibration import Calibration

    if Path(name).is_file():
        return Calibration.load(name)
    require_id(name)
    with client(chosen) as service:
        return service.calibration(name)


def require_id(name: str) -> None:
    """Raise UsageError for the path of a file, which is not there."""
    if "/" in name or re.search(r"\.[A-Za-z]{2,12}$", name):
        raise UsageError(f"{name} is not there")


def add_camera(parser: argparse.ArgumentParser) -> None:
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
    parser.add_argument("--model", choices=MODELS, default=DEFAULT_MODEL, help="distortion model")


def camera_key(chosen: argparse.Namespace) -> CameraKey:
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
    """Open the camera to see its size."""
    from ..camera import open_camera

    try:
        with open_camera(camera) as opened:
            return opened.img_size
    except MissingPackageError:
        raise UsageError("say --size, such as 1280x720: without OpenCV the camera cannot be asked") from None
    except CalibDBError as error:
        raise type(error)(f"{error}. With --size the camera need not be opened") from None
