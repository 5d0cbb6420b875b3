"""The command `check`: whether the database's calibration fits this camera."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..key import UNNAMED, live_model
from ..recording import Recording
from . import options
from .board import chosen_board
from .capture_options import add_licence, add_source, capture_arguments, kind_of, licence_of
from .output import Output, calibration_facts


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "check",
        help="check the database's calibration on three frames",
        description="Check the database's calibration of a camera, or that of --against, on three still "
        "frames of a board, tilted differently: live, or of pictures, a video or a file of `calibrate`.",
    )
    add_source(parser)
    parser.add_argument(
        "--against",
        metavar="FILE|ID",
        help="check this calibration instead, without a vote: a file on this machine, nothing is sent; an "
        "id by the service",
    )
    add_licence(parser)
    options.add_service(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Take or read the frames, and have them scored."""
    source: Any = chosen.source[0]
    if len(chosen.source) == 1 and source.endswith(".json"):
        camera: Any = Recording.load(source)
        arguments: dict[str, Any] = {}
    elif kind_of(chosen.source) == "camera":
        camera, arguments = int(source) if source.isdigit() else source, capture_arguments(chosen)
    else:
        camera, arguments = _pictures(chosen), {}
    if chosen.against:
        return _compare(camera, arguments, chosen, output)
    licence = licence_of(chosen, output)
    with options.client(chosen) as client:
        result = client.check(camera, model=live_model(chosen.model), licence=licence, **arguments)
    if output.json:
        output.document(dict(result.record))
    else:
        agree, disagree = result.votes
        output.facts(
            [
                ("fits", "yes" if result.fits else "no"),
                ("error", f"{result.error:.3f} px, {result.expected:.3f} px expected"),
                ("counted", "yes" if result.counted else "no"),
                ("votes", f"{agree} agree, {disagree} disagree"),
                *calibration_facts(result.calibration.record),
            ]
        )
    if not result.fits:
        output.note("the calibration does not fit this camera: calibrate it (`calibdb calibrate`)")
    return 0 if result.fits else 1


def _compare(camera: Any, arguments: dict[str, Any], chosen: argparse.Namespace, output: Output) -> int:
    """Check a calibration at hand on the views, and print how far it is from their own fit."""
    from dataclasses import asdict

    from ..capture.glances import recording_to_check
    from ..checks import compare

    calibration = options.calibration(chosen.against, chosen)
    if Path(chosen.against).is_file():
        result = compare(recording_to_check(camera, **arguments), calibration)
    else:
        with options.client(chosen) as client:
            result = client.check_against(camera, calibration, **arguments)
    if output.json:
        output.document(asdict(result))
    else:
        output.facts(
            [
                ("fits", "yes" if result.fits else "no"),
                ("views", str(result.views)),
                ("rms", f"{result.error:.3f} px, {result.expected:.3f} px under a fit of these views"),
                (
                    "drift",
                    f"{result.drift:.2f} px rms between the two over the image. The fit of these views is "
                    f"uncertain by {result.drift_uncertainty:.2f} px",
                ),
            ]
        )
    if not result.fits:
        output.note("the calibration does not fit these views: calibrate again (`calibdb calibrate`)")
    return 0 if result.fits else 1


def _pictures(chosen: argparse.Namespace) -> Recording:
    from ..images import recording_of

    if not (chosen.label or chosen.against):
        raise UsageError("which camera took them? Say --label, and --platform if a browser used it")
    paths = [Path(each) for each in chosen.source]
    board = chosen_board(chosen)
    return recording_of(paths, chosen.label or UNNAMED, board, chosen.platform, chosen.zoom, least=1)
