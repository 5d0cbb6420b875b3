"""The command `rig`: folders of pictures, one for each camera, become a calibrated rig."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from ..board import opencv
from ..conversion import RIG_NATIVE
from . import options
from .board import add_board, chosen_board
from .capture_options import add_model, free_path
from .output import Output, progress


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "rig",
        help="calibrate cameras that do not move against each other, from a folder of pictures of each",
        description="Calibrate two to eight cameras that do not move against each other, on this machine: "
        "nothing is sent. Pictures with the same file name, or at the same place in the order of names, show "
        "the same moment.",
    )
    parser.add_argument("folders", nargs="+", metavar="FOLDER", help="pictures of one camera")
    parser.add_argument("--offline", action="store_true", help="has no effect: a rig is calibrated here")
    add_model(parser)
    add_board(parser, recognised=True)
    options.add_file(parser, "rig.json, or the format's own name,")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Find the corners, calibrate, and write the files."""
    form = options.chosen_format(chosen, rig=True)
    opencv()
    from ..rig_pictures import calibrate_rig

    with progress("pictures") as advance:
        result = calibrate_rig(
            chosen.folders,
            board=chosen_board(chosen),
            model=chosen.model,
            square_size=chosen.square_mm / 1000 if chosen.square_mm else None,
            progress=advance,
        )
    rig = result.rig
    output.note(f"board: {result.board}")
    for name, why in result.left_out:
        output.note(f"left out {name}: {why}")
    if sentence := result.board_sentence(chosen.square_mm):
        output.note(sentence)
    if output.json:
        output.document(dict(rig.record))
    else:
        output.facts(_facts(result))
    native = Path(chosen.output) if chosen.output and form == RIG_NATIVE else None
    if native is None:
        native = Path(chosen.output).with_suffix(".calibdb.json") if chosen.output else free_path("rig")
    rig.save(native, RIG_NATIVE)
    output.note(f"wrote {native}")
    if form != RIG_NATIVE:
        file = rig.export(form)
        output.file(file, chosen.output or file.filename)
    return 0


def _facts(result: Any) -> list[tuple[str, str]]:
    rig = result.rig
    unit = "m" if rig.unit == "metres" else rig.unit
    rows = [("moments", f"{result.moments} in two cameras or more")]
    for i, camera in enumerate(rig.calibrations):
        m = camera.camera_matrix
        rows.append(
            (
                f"camera {i}",
                f"{camera.camera}: {camera.img_size[0]} x {camera.img_size[1]}, {camera.distortion_model}, "
                f"focal lengths {m[0, 0]:.2f}, {m[1, 1]:.2f} px",
            )
        )
    for i in range(1, len(rig.calibrations)):
        pose, std = rig.pose(i), rig.std(i)
        length = float(np.linalg.norm(pose[:3, 3]))
        along = pose[:3, 3] / max(length, 1e-12)
        angle = np.degrees(np.arccos(np.clip((np.trace(pose[:3, :3]) - 1) / 2, -1, 1)))
        rows.append(
            (
                f"0 to {i}",
                f"baseline {length:.4f} ± {float(np.linalg.norm(along * std[3:])):.4f} {unit}, turned by "
                f"{angle:.3f} degrees",
            )
        )
    uncertainty = rig.uncertainty
    rows.append(("rms", f"{rig.rms:.3f} px"))
    if (held_out := rig.record.get("held_out_rms")) is not None:
        rows.append(("held out", f"{held_out:.3f} px"))
    rows.append(
        (
            "uncertainty",
            f"{uncertainty['rotation_deg']:.3f} degrees, {uncertainty['translation_percent']:.2f} % of the "
            f"distance, {uncertainty['rms']:.2f} px between cameras",
        )
    )
    return rows
