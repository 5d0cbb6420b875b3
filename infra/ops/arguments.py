"""What the operator's command line understands."""

from __future__ import annotations

import argparse
from pathlib import Path


def parser() -> argparse.ArgumentParser:
    """Return the parser. Every command leaves its name in `command`, its verb, if any, in `action`."""
    top = argparse.ArgumentParser(prog="python -m infra.ops", description="The operator's command line.")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")

    token = _group(commands, "token", "API tokens")
    create = token.add_parser("create", help="issue a token; it is shown once")
    create.add_argument("--origin", action="append", default=[], help="origin that may use it; repeatable")
    create.add_argument("--plan", default="free", help="what it may use in an hour (default: free)")
    token.add_parser("list", help="show all tokens, without their secrets")
    revoke = token.add_parser("revoke", help="refuse a token for good, within a minute")
    revoke.add_argument("id")
    rotate = token.add_parser("rotate", help="give a token a new secret; it is shown once")
    rotate.add_argument("id")
    rotate.add_argument(
        "--grace", type=_hours, default=24, metavar="HOURS", help="how long the old one still works (24)"
    )

    camera = _group(commands, "camera", "what is known of cameras")
    listing = camera.add_parser("list", help="show the cameras that were calibrated")
    listing.add_argument("text", nargs="?", default="", help="only those whose key holds this")
    show = camera.add_parser("show", help="show one camera: what agrees, and every calibration")
    show.add_argument("key")

    calibration = _group(commands, "calibration", "single calibrations")
    withdraw = calibration.add_parser("withdraw", help="let a calibration count for nothing any more")
    withdraw.add_argument("id")
    withdraw.add_argument(
        "--reason",
        default="",
        help="kept with it; `wrong`, `abuse` or `privacy` as its first word is told whoever asks",
    )
    restore = calibration.add_parser("restore", help="let one that was withdrawn count again")
    restore.add_argument("id")

    contributor = _group(commands, "contributor", "who sent something")
    forget = contributor.add_parser("forget", help="remove everything that a contributor sent, for good")
    forget.add_argument("id", nargs="?", help="as `camera show` prints it; its first 12 digits are enough")
    forget.add_argument("--address", help="instead: the address that it came from …")
    forget.add_argument("--token", help="… and the id of the token; without it, all tokens are tried")

    commands.add_parser("reindex", help="make the index anew from the bucket, which is the truth")
    fill = commands.add_parser(
        "backfill", help="bring every consensus up to date: after a new model, another solver or other rules"
    )
    fill.add_argument("--after", default="", metavar="KEY", help="go on after this camera")

    dump = commands.add_parser("dump", help="write all calibrations and keypoints to a new folder (CC0)")
    dump.add_argument("folder", type=Path)
    load = commands.add_parser("load", help="take in what `dump` wrote")
    load.add_argument("folder", type=Path)

    bundling = commands.add_parser(
        "bundle", help="write what is reliable of the cameras that most people have, for web applications"
    )
    bundling.add_argument("file", type=Path)
    bundling.add_argument("--most", type=_count, default=500, metavar="CAMERAS", help="at most so many (500)")

    taking = commands.add_parser(
        "import", help="take in a calibration file: with keypoints as a calibration, else as a first guess"
    )
    taking.add_argument("file", type=Path, help="PhotonVision, mrcal, OpenCV, ROS, Kalibr, Gyroflow, calibDB")
    taking.add_argument("--camera", required=True, help="label, as a browser gives it")
    taking.add_argument("--platform", required=True, help="platform, as a browser gives it")
    taking.add_argument("--zoom", type=float, default=0.0, help="zoom of the track (0)")
    taking.add_argument("--img-size", type=_size, metavar="WxH", help="for tables of corners, which lack it")
    taking.add_argument("--squares", type=_size, metavar="WxH", help="of the board, for tables of corners")
    taking.add_argument(
        "--model", default="", help="to fit to keypoints; without it, the one that suits them"
    )

    seed = commands.add_parser(
        "seed", help="take in calibrations from elsewhere (CSV), as first guesses for a capture only"
    )
    seed.add_argument("file", type=Path)
    seed.add_argument(
        "--camera", default="{camera}", help="label, made of columns, such as '{brand} {model} {lens}'"
    )
    seed.add_argument("--platform", default="{platform}", help="platform, in the same way")
    seed.add_argument("--model", default="rectilinear", help="of rows that name none (rectilinear)")
    seed.add_argument("--source", default="", help="where they come from; kept with them")
    return top


def _group(
    commands: argparse._SubParsersAction[argparse.ArgumentParser], name: str, about: str
) -> argparse._SubParsersAction[argparse.ArgumentParser]:
    return commands.add_parser(name, help=about).add_subparsers(dest="action", required=True, metavar="VERB")


def _hours(text: str) -> float:
    hours = float(text)
    if not 0 <= hours <= 24 * 366:
        raise argparse.ArgumentTypeError("from 0 to a year of hours")
    return hours


def _count(text: str) -> int:
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError("a whole number from 1")
    return int(text)


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdigit() and height.isdigit()):
        raise argparse.ArgumentTypeError(f"{text} is no size such as 1280x720")
    return int(width), int(height)
