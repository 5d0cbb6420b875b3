"""End of a calibration by the command: its files, and what it prints."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from ..conversion import NATIVE
from ..errors import CaptureError
from ..files import write_whole
from ..recording import Recording
from ..session import CaptureResult
from . import options
from .output import Output, calibration_facts


@dataclass(frozen=True)
class Target:
    """Files of a calibration.

    Attributes
    ----------
    kept
        File of the corners and the result; None: a new one.
    format
        Format of another file.
    path
        That file; None: one next to `kept`.
    """

    kept: Path | None = None
    format: str = NATIVE
    path: Path | None = None


NO_TARGET = Target()


def target_of(chosen: argparse.Namespace) -> Target:
    """Return the files that the options name. Raises UsageError if suffix and format contradict."""
    form = options.chosen_format(chosen)
    if chosen.output is None:
        return Target(None, form)
    path = Path(chosen.output)
    return Target(path) if form == NATIVE else Target(path.with_suffix(".calibdb.json"), form, path)


def conclude(
    recording: Recording,
    result: CaptureResult,
    path: Path,
    chosen: argparse.Namespace,
    output: Output,
    target: Target = NO_TARGET,
) -> int:
    """Write the result to the recording's file, optionally also as another tool's file, and print it.

    With ``--verbose`` it prints a row per image.
    """
    write_whole(path, recording.content(result.calibration.record))
    for source, why in result.left_out:
        output.note(f"left out {source}: {why}")
    if result.suggested_model:
        output.note(f"--model {result.suggested_model} explains these pictures better")
    for text in result.verdict[1:]:
        output.note(text)
    if sentence := result.board_sentence(chosen.square_mm):
        output.note(sentence)
    if output.json:
        output.document(dict(result.calibration.record))
    else:
        rows = [("views", str(result.used)), *calibration_facts(result.calibration.record)]
        verdict = [("verdict", result.verdict[0])] if result.verdict else []
        output.facts([*rows, *verdict])
        if getattr(chosen, "verbose", False):
            output.table(("picture", "corners", "used", "rms, px", ""), _picture_rows(recording, result))
    output.note(f"wrote {path}")
    if result.calibration.id:
        output.note(
            f"`calibdb export {path} --format …` writes it for other tools; its id is {result.calibration.id}"
        )
    if target.format != NATIVE:
        file = result.calibration.export(target.format)
        sibling = path.with_name(f"{path.stem}-{target.format}{Path(file.filename).suffix}")
        output.file(file, str(target.path or sibling))
    return 0


def _picture_rows(recording: Recording, result: CaptureResult) -> list[tuple[str, ...]]:
    """Return a row for each view: corners, those used, rms, and why it is left out."""
    from ..report import fit_again, rows_of

    try:
        fit, _ = fit_again(recording, result.calibration)
    except CaptureError:
        return []
    why = dict(result.left_out)
    return [
        (row.source, str(row.corners), str(row.used), f"{row.rms:.3f}", why.get(row.source, row.remark))
        for row in rows_of(recording, fit)
    ]
