"""Parser of the operator's command line; `func` holds the function of a command."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from infra.ops import commands

Subparsers: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def parser() -> argparse.ArgumentParser:
    """Build the parser."""
    top = argparse.ArgumentParser(prog="python -m infra.ops", description="The operator's command line.")
    groups = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_token(_group(groups, "token", "issue, list, rotate and revoke API tokens"))
    _add_camera(_group(groups, "camera", "list cameras, and show one"))
    _add_calibration(_group(groups, "calibration", "withdraw and restore single calibrations"))
    _add_contributor(_group(groups, "contributor", "remove the data of contributors"))
    _add_maintenance(groups)
    _add_files(groups)
    return top


def _add_token(token: Subparsers) -> None:
    create = _command(token, "create", commands.create_token, "issue a token; it is shown once")
    create.add_argument("--origin", action="append", default=[], help="origin that may use it; repeatable")
    create.add_argument(
        "--plan", default="free", help="plan, which limits its use in an hour (default: free)"
    )
    _command(token, "list", commands.list_tokens, "list all tokens, without their secrets")
    revoke = _command(token, "revoke", commands.revoke_token, "revoke a token for good, within a minute")
    revoke.add_argument("id")
    rotate = _command(token, "rotate", commands.rotate_token, "give a token a new secret; it is shown once")
    rotate.add_argument("id")
    rotate.add_argument(
        "--grace",
        type=_hours,
        default=24,
        metavar="HOURS",
        help="time for which the old secret still works (24)",
    )


def _add_camera(camera: Subparsers) -> None:
    listing = _command(camera, "list", commands.list_cameras, "list the cameras that were calibrated")
    listing.add_argument("text", nargs="?", default="", help="only those whose key contains this text")
    show = _command(camera, "show", commands.show_camera, "show consensuses and calibrations of one camera")
    show.add_argument("key")


def _add_calibration(calibration: Subparsers) -> None:
    withdraw = _command(
        calibration, "withdraw", commands.withdraw, "exclude a calibration from all consensuses"
    )
    withdraw.add_argument("id")
    withdraw.add_argument(
        "--reason",
        default="",
        help="stored with it; the API tells its first word if that is `wrong`, `abuse` or `privacy`",
    )
    restore = _command(calibration, "restore", commands.restore, "include a withdrawn calibration again")
    restore.add_argument("id")


def _add_contributor(contributor: Subparsers) -> None:
    forget = _command(
        contributor, "forget", commands.forget, "remove everything that a contributor sent, for good"
    )
    forget.add_argument("id", nargs="?", help="as `camera show` prints it; its first 12 digits are enough")
    forget.add_argument("--address", help="instead: the IP address of the contributor …")
    forget.add_argument("--token", help="… and the id of the token; without it, all tokens are tried")


def _add_maintenance(groups: Subparsers) -> None:
    _command(groups, "reindex", commands.reindex, "rebuild the index from the bucket, the source of truth")
    fill = _command(
        groups,
        "backfill",
        commands.backfill,
        "recompute outdated consensuses: after a new model, another solver or other thresholds",
    )
    fill.add_argument("--after", default="", metavar="KEY", help="continue after this camera")


def _add_files(groups: Subparsers) -> None:
    dump = _command(
        groups, "dump", commands.dump, "write all calibrations and keypoints to a new folder (CC0)"
    )
    dump.add_argument("folder", type=Path)
    load = _command(groups, "load", commands.load, "store the content of a dump")
    load.add_argument("folder", type=Path)

    bundle = _command(
        groups,
        "bundle",
        commands.bundle,
        "write the reliable calibrations of the most common cameras to one file",
    )
    bundle.add_argument("file", type=Path)
    bundle.add_argument("--most", type=_count, default=500, metavar="CAMERAS", help="number of cameras (500)")

    imported = _command(
        groups,
        "import",
        commands.import_file,
        "store a calibration file: with keypoints as a calibration, else as a first guess",
    )
    imported.add_argument(
        "file", type=Path, help="OpenCV, ROS, Kalibr, camodocal, PhotonVision, mrcal, Gyroflow, COLMAP, …"
    )
    imported.add_argument("--camera", required=True, help="label, as a browser reports it")
    imported.add_argument("--platform", required=True, help="platform, as a browser reports it")
    imported.add_argument("--zoom", type=float, default=0.0, help="zoom of the track (0)")
    imported.add_argument(
        "--img-size", type=_size, metavar="WxH", help="size of the pictures, for files that lack it"
    )
    imported.add_argument(
        "--camera-number",
        type=_number,
        default=0,
        metavar="N",
        help="of a file with several cameras, from 0 (0)",
    )
    imported.add_argument("--squares", type=_size, metavar="WxH", help="of the board, for tables of corners")
    imported.add_argument(
        "--model",
        default="",
        help="model to fit to keypoints (default: the one that suits them), or of unnamed coefficients",
    )

    seed = _command(groups, "seed", commands.seed, "store published calibrations (CSV) as first guesses")
    seed.add_argument("file", type=Path)
    seed.add_argument(
        "--camera", default="{camera}", help="label, made of columns, such as '{brand} {model} {lens}'"
    )
    seed.add_argument("--platform", default="{platform}", help="platform, in the same way")
    seed.add_argument("--model", default="rectilinear", help="of rows that name none (rectilinear)")
    seed.add_argument("--source", default="", help="source of the file; stored with each guess")


def _group(groups: Subparsers, name: str, about: str) -> Subparsers:
    return groups.add_parser(name, help=about).add_subparsers(dest="action", required=True, metavar="VERB")


def _command(
    commands_: Subparsers, name: str, func: Callable[..., None], about: str
) -> argparse.ArgumentParser:
    added = commands_.add_parser(name, help=about)
    added.set_defaults(func=func)
    return added


def _hours(text: str) -> float:
    hours = float(text)
    if not 0 <= hours <= 24 * 366:
        raise argparse.ArgumentTypeError("hours must be from 0 to a year")
    return hours


def _count(text: str) -> int:
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError("a whole number from 1")
    return int(text)


def _number(text: str) -> int:
    if not (text.isdecimal() and len(text) < 4):
        raise argparse.ArgumentTypeError("a whole number from 0")
    return int(text)


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdigit() and height.isdigit()):
        raise argparse.ArgumentTypeError(f"{text} is no size such as 1280x720")
    return int(width), int(height)
