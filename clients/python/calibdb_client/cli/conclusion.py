"""End of a calibration by the command: its files, and what it prints."""

from argparse import Namespace
from pathlib import Path

from ..conversion import NATIVE
from ..errors import CaptureError
from ..files import write_whole
from ..recording import Recording
from ..session import CaptureResult
from . import options
from .output import Output, calibration_facts


def kept_path(chosen: Namespace) -> Path | None:
    """Return the file of the corners and the result that the options name; None: a new one.

    Raises UsageError if suffix and format contradict.
    """
    form = options.chosen_format(chosen)
    if chosen.output is None:
        return None
    path = Path(chosen.output)
    return path if form == NATIVE else path.with_suffix(".calibdb.json")


def conclude(
    recording: Recording, result: CaptureResult, path: Path, chosen: Namespace, output: Output
) -> int:
    """Write the result to the recording's file, and to another tool's if asked for, and print it."""
    calibration = result.calibration
    write_whole(path, recording.content(calibration.record))
    for source, why in result.left_out:
        output.note(f"left out {source}: {why}")
    if result.suggested_model:
        output.note(f"--model {result.suggested_model} explains these pictures better")
    for text in result.verdict[1:]:
        output.note(text)
    if sentence := result.board_sentence(chosen.square_mm):
        output.note(sentence)
    if output.json:
        output.document(dict(calibration.record))
    else:
        rows = [("views", str(result.used)), *calibration_facts(calibration.record)]
        output.facts([*rows, *(("verdict", level) for level in result.verdict[:1])])
        if getattr(chosen, "verbose", False):
            output.table(("picture", "corners", "used", "rms, px", ""), _picture_rows(recording, result))
    output.note(f"wrote {path}")
    if calibration.id:
        output.note(
            f"`calibdb export {path} --format …` writes it for other tools; its id is {calibration.id}"
        )
    form = options.chosen_format(chosen) if "format" in chosen else NATIVE
    if form != NATIVE:
        file = calibration.export(form)
        sibling = path.with_name(f"{path.stem}-{form}{Path(file.filename).suffix}")
        output.file(file, chosen.output or str(sibling))
    return 0


def _picture_rows(recording: Recording, result: CaptureResult) -> list[tuple[str, ...]]:
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
