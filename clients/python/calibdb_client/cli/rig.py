"""The command `rig`."""

from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np

from ..board import opencv
from ..conversion import RIG_NATIVE
from . import options
from .output import Output, progress


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands,
        "rig",
        run,
        "calibrate cameras that do not move against each other, from a folder of pictures of each",
        "Calibrate two to eight cameras that do not move against each other, on this machine: "
        "nothing is sent. Pictures with the same file name, or at the same place in the order of names, show "
        "the same moment.",
    )
    parser.add_argument("folders", nargs="+", metavar="FOLDER", help="pictures of one camera")
    parser.add_argument("--offline", action="store_true", help="has no effect: a rig is calibrated here")
    options.add_model(parser)
    options.add_board(parser, recognised=True)
    options.add_file(parser, "rig.json, or the format's own name,")
    options.add_json(parser)


def run(chosen: Namespace, output: Output) -> int:
    """Find the corners, calibrate, and write the files."""
    form = options.chosen_format(chosen, rig=True)
    opencv()
    from ..rig_pictures import calibrate_rig

    with progress("pictures") as advance:
        result = calibrate_rig(
            chosen.folders,
            board=options.chosen_board(chosen),
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
    if chosen.output is None:
        native = options.free_path("rig")
    else:
        native = Path(chosen.output)
        native = native if form == RIG_NATIVE else native.with_suffix(".calibdb.json")
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
        m, (w, h) = camera.camera_matrix, camera.img_size
        words = f"{camera.camera}: {w} x {h}, {camera.distortion_model}"
        rows.append((f"camera {i}", f"{words}, focal lengths {m[0, 0]:.2f}, {m[1, 1]:.2f} px"))
    for i in range(1, len(rig.calibrations)):
        pose = rig.pose(i)
        length = float(np.linalg.norm(pose[:3, 3]))
        error = np.linalg.norm(pose[:3, 3] / max(length, 1e-12) * rig.std(i)[3:])
        angle = np.degrees(np.arccos(np.clip((np.trace(pose[:3, :3]) - 1) / 2, -1, 1)))
        words = f"baseline {length:.4f} ± {error:.4f} {unit}, turned by {angle:.3f} degrees"
        rows.append((f"0 to {i}", words))
    rows.append(("rms", f"{rig.rms:.3f} px"))
    if (held_out := rig.record.get("held_out_rms")) is not None:
        rows.append(("held out", f"{held_out:.3f} px"))
    uncertainty = rig.uncertainty
    words = (
        f"{uncertainty['rotation_deg']:.3f} degrees, {uncertainty['translation_percent']:.2f} % of the "
        f"distance, {uncertainty['rms']:.2f} px between cameras"
    )
    return [*rows, ("uncertainty", words)]
