"""The command `check`."""

from argparse import Namespace
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..key import UNNAMED, live_model
from ..recording import Recording
from . import options
from .output import Output, calibration_facts


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands,
        "check",
        run,
        "check the database's calibration on three frames",
        "Check the database's calibration of a camera, or that of --against, on three still "
        "frames of a board, tilted differently: live, or of pictures, a video or a file of `calibrate`.",
    )
    options.add_source(parser)
    parser.add_argument(
        "--against",
        metavar="FILE|ID",
        help="check this calibration instead, without a vote: a file on this machine, nothing is sent; an "
        "id by the service",
    )
    options.add_licence(parser)
    options.add_service(parser)


def run(chosen: Namespace, output: Output) -> int:
    """Take or read the frames, and have them scored."""
    source: Any = chosen.source[0]
    arguments: dict[str, Any] = {}
    if len(chosen.source) == 1 and source.endswith(".json"):
        source = Recording.load(source)
    elif options.kind_of(chosen.source) == "camera":
        source = int(source) if source.isdigit() else source
        arguments = options.capture_arguments(chosen)
    else:
        source = _pictures(chosen)
    score = _compare if chosen.against else _check
    fits, record, facts = score(source, arguments, chosen, output)
    if output.json:
        output.document(record)
    else:
        output.facts([("fits", "yes" if fits else "no"), *facts])
    if not fits:
        what = "these views: calibrate again" if chosen.against else "this camera: calibrate it"
        output.note(f"the calibration does not fit {what} (`calibdb calibrate`)")
    return 0 if fits else 1


def _check(
    source: Any, arguments: dict[str, Any], chosen: Namespace, output: Output
) -> tuple[bool, dict[str, Any], list[tuple[str, str]]]:
    licence = options.licence_of(chosen, output)
    with options.client(chosen) as client:
        result = client.check(source, model=live_model(chosen.model), licence=licence, **arguments)
    agree, disagree = result.votes
    facts = [
        ("error", f"{result.error:.3f} px, {result.expected:.3f} px expected"),
        ("counted", "yes" if result.counted else "no"),
        ("votes", f"{agree} agree, {disagree} disagree"),
        *calibration_facts(result.calibration.record),
    ]
    return result.fits, dict(result.record), facts


def _compare(
    source: Any, arguments: dict[str, Any], chosen: Namespace, _: Output
) -> tuple[bool, dict[str, Any], list[tuple[str, str]]]:
    from ..capture.glances import recording_to_check
    from ..checks import compare

    calibration = options.calibration(chosen.against, chosen)
    if Path(chosen.against).is_file():
        result = compare(recording_to_check(source, **arguments), calibration)
    else:
        with options.client(chosen) as client:
            result = client.check_against(source, calibration, **arguments)
    facts = [
        ("views", str(result.views)),
        ("rms", f"{result.error:.3f} px, {result.expected:.3f} px under a fit of these views"),
        (
            "drift",
            f"{result.drift:.2f} px rms between the two over the image. The fit of these views is "
            f"uncertain by {result.drift_uncertainty:.2f} px",
        ),
    ]
    return result.fits, asdict(result), facts


def _pictures(chosen: Namespace) -> Recording:
    from ..images import recording_of

    if not (chosen.label or chosen.against):
        raise UsageError("which camera took them? Say --label, and --platform if a browser used it")
    board = options.chosen_board(chosen)
    return recording_of(chosen.source, chosen.label or UNNAMED, board, chosen.platform, chosen.zoom, least=1)
