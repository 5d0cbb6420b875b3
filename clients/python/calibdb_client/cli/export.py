"""The commands `export` and `convert`."""

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..files import UNCHANGED, PictureChange
from ..key import MODELS
from . import options
from .output import Output


def add(commands: Any) -> None:
    """Add the commands to the parser."""
    parser = options.add_command(
        commands,
        "export",
        run,
        "write a calibration, or a rig, as another tool's file",
        "Write a calibration as another tool's file: a file that calibdb wrote, without the "
        "service, or one that the service holds.",
    )
    parser.add_argument("source", metavar="FILE|ID", help="a file, or an id at the service")
    options.add_file(parser)
    _add_change(parser)
    options.add_service(parser)
    parser = options.add_command(
        commands,
        "convert",
        run_convert,
        "convert another tool's calibration file",
        "Convert the calibration file of one tool to that of another, without the service.",
    )
    parser.add_argument("source", metavar="FILE", help="calibration file of any tool in docs/formats.md")
    options.add_file(parser)
    parser.add_argument(
        "--img-size", type=options.size, metavar="WxH", help="size of the pictures, if the file does not say"
    )
    parser.add_argument(
        "--camera-number", type=int, metavar="N", help="camera of a file with several, from 0"
    )
    parser.add_argument("--model", choices=MODELS, help="model of four coefficients without a name")
    _add_change(parser)


def _add_change(parser: ArgumentParser) -> None:
    group = parser.add_argument_group("another picture of the camera, in this order")
    group.add_argument("--crop", type=_numbers, metavar="L,T,W,H", help="part that is cut out, px")
    group.add_argument("--resize", type=options.size, metavar="WxH", help="size to which it is scaled")
    group.add_argument("--rotate", type=int, choices=(0, 90, 180, 270), default=0, help="degrees clockwise")
    group.add_argument("--mirror", action="store_true", help="swap left and right")


def _numbers(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise ArgumentTypeError("four whole numbers with commas: left,top,width,height") from None


def _change(chosen: Namespace) -> PictureChange:
    return PictureChange(chosen.crop, chosen.resize, chosen.rotate, chosen.mirror)


def run(chosen: Namespace, output: Output) -> int:
    """Read the file, or fetch it, and write it."""
    from ..calibration import Calibration
    from ..rig import Rig, is_rig

    path, change = Path(chosen.source), _change(chosen)
    if not path.is_file():
        options.require_id(chosen.source)
        form = options.chosen_format(chosen)
        with options.client(chosen) as client:
            file = client.export(chosen.source, form, **vars(change))
    elif not is_rig(path):
        file = Calibration.load(path).export(options.chosen_format(chosen), change)
    elif change == UNCHANGED:
        file = Rig.load(path).export(options.chosen_format(chosen, rig=True))
    else:
        raise UsageError("the pictures of a rig cannot be changed: export its cameras one by one")
    output.file(file, chosen.output)
    return 0


def run_convert(chosen: Namespace, output: Output) -> int:
    """Read another tool's file, and write it in another format."""
    from calibsolver.formats.base import ReaderOptions

    from .. import conversion

    form = options.chosen_format(chosen)
    number = chosen.camera_number or 0
    record = conversion.read(chosen.source, ReaderOptions(chosen.img_size, number, None, chosen.model or ""))
    cameras = record.pop("cameras", ())
    if cameras and chosen.camera_number is None:
        output.note(f"camera 0 of {len(cameras)} ({', '.join(cameras)}): --camera-number takes another")
    if approximation := record.pop("approximation", ""):
        output.note(f"{chosen.source}: {approximation}")
    output.file(conversion.write(record, form, None, _change(chosen)), chosen.output)
    return 0
