"""Live captures, the command `resume`, and the end of every calibration: its files, and what is printed."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from ..capture.operation import CaptureInterruptedError
from ..conversion import NATIVE
from ..errors import CalibDBError, CaptureError, UsageError
from ..files import write_whole
from ..key import UNNAMED
from ..recording import Recording
from ..session import CaptureResult
from . import options
from .output import Output, calibration_facts


class _KeptFile:
    """File of the views so far, named after the camera by default."""

    def __init__(self, path: Path | None, recording: Recording | None) -> None:
        self.path = path
        self.recording = recording
        self._resumed = path is not None and path.exists()

    def keep(self, recording: Recording) -> None:
        """Write the recording; one without views needs no file."""
        self.recording = recording
        if self.path is None:
            self.path = options.new_name(recording.key.camera, recording.key.img_size)
        if recording.views:
            write_whole(self.path, recording.content())
        elif not self._resumed:
            self.path.unlink(missing_ok=True)


def run(chosen: Namespace, output: Output) -> int:
    """Calibrate a camera live."""
    return _capture(chosen.source[0], options.capture_arguments(chosen), kept_path(chosen), chosen, output)


def _capture(
    camera: str, arguments: dict[str, Any], path: Path | None, chosen: Namespace, output: Output
) -> int:
    """Capture, keep every view in a file, write the result there, and print it."""
    source: int | str = int(camera) if camera.isdigit() else camera
    kept = _KeptFile(path, arguments.get("resume"))
    arguments |= {"model": chosen.model, "keep": kept.keep}
    licence = options.licence_of(chosen, output)
    try:
        if chosen.offline:
            from .. import offline

            result = offline.calibrate(source, **arguments)
        else:
            with options.client(chosen) as client:
                result = client.calibrate(source, licence=licence, mode_name=chosen.mode_name, **arguments)
    except (CalibDBError, CaptureInterruptedError) as error:
        if error.recording is not None and error.recording.views:
            kept.keep(error.recording)
            label = "" if error.recording.key.camera != UNNAMED else " with --offline"
            output.note(
                f"{len(error.recording.views)} views are in {kept.path}: `calibdb resume {kept.path}` "
                f"continues with them, `calibdb submit {kept.path}` calibrates from them{label}"
            )
        raise
    if kept.recording is None or kept.path is None:
        raise UsageError("no view was taken")
    return conclude(kept.recording, result, kept.path, chosen, output)


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands,
        "resume",
        resume,
        "continue a live capture that ended early",
        "Continue a live capture, from the file that `calibdb calibrate` kept.",
    )
    parser.add_argument("file", help="file that `calibdb calibrate` kept")
    parser.add_argument("camera", nargs="?", help="the camera; found by its label unless given")
    options.add_show(parser)
    options.add_model(parser)
    options.add_contribution(parser)
    parser.set_defaults(square_mm=None)


def resume(chosen: Namespace, output: Output) -> int:
    """Read the file, open the camera, and continue the capture."""
    recording = Recording.load(chosen.file)
    if not recording.live:
        raise UsageError(f"{chosen.file} contains images, not a live capture: `calibdb submit {chosen.file}`")
    if not chosen.offline and recording.key.camera == UNNAMED:
        raise UsageError("this capture has no camera's label: go on with --offline")
    camera = chosen.camera or recording.key.camera
    if camera == UNNAMED:
        raise UsageError("which camera is it? Give its index, path or address after the file")
    arguments = {"resume": recording, "show": chosen.show}
    return _capture(camera, arguments, Path(chosen.file), chosen, output)


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
    return rows_of(recording, fit, result.left_out)
