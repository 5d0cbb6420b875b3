"""Live captures, and the command `resume`."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from ..capture.operation import CaptureInterruptedError
from ..errors import CalibDBError, UsageError
from ..files import write_whole
from ..key import UNNAMED
from ..recording import Recording
from . import options
from .conclusion import conclude, kept_path
from .output import Output


class KeptFile:
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
    kept = KeptFile(path, arguments.get("resume"))
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
