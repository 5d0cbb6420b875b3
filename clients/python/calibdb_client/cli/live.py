"""Live captures, and the command `resume`: the file kept meanwhile, and what is said if they end early."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..capture.operation import CaptureInterruptedError
from ..errors import CalibDBError, UsageError
from ..files import write_whole
from ..key import UNNAMED
from ..recording import Recording
from . import options
from .capture_options import add_contribution, add_model, add_show, capture_arguments, licence_of, new_name
from .conclusion import NO_TARGET, Target, conclude, target_of
from .output import Output


class KeptFile:
    """File of the views so far. `path` may be None: then it is named after the camera."""

    def __init__(self, path: str | Path | None) -> None:
        self.path = Path(path) if path else None
        self._resumed = self.path is not None and self.path.exists()

    def keep(self, recording: Recording) -> None:
        """Write the recording; one without views needs no file."""
        if self.path is None:
            self.path = new_name(recording.key.camera, recording.key.img_size)
        if recording.views:
            write_whole(self.path, recording.content())
        elif not self._resumed:
            self.path.unlink(missing_ok=True)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """Calibrate a camera live."""
    target = target_of(chosen)
    licence = None if chosen.offline else licence_of(chosen, output)
    arguments = capture_arguments(chosen)
    return capture(chosen.source[0], arguments, licence, KeptFile(target.kept), chosen, output, target)


def capture(
    camera: str,
    arguments: dict[str, Any],
    licence: str | None,
    kept: KeptFile,
    chosen: argparse.Namespace,
    output: Output,
    target: Target = NO_TARGET,
) -> int:
    """Capture, keep every view in a file, write the result there, and print it."""
    source: int | str = int(camera) if camera.isdigit() else camera
    recording: list[Recording] = []

    def keep(each: Recording) -> None:
        recording[:] = [each]
        kept.keep(each)

    if resumed := arguments.get("resume"):
        recording.append(resumed)
    try:
        if chosen.offline:
            from .. import offline

            result = offline.calibrate(source, model=chosen.model, keep=keep, **arguments)
        else:
            with options.client(chosen) as client:
                result = client.calibrate(
                    source,
                    model=chosen.model,
                    keep=keep,
                    licence=licence,
                    mode_name=chosen.mode_name,
                    **arguments,
                )
    except (CalibDBError, CaptureInterruptedError) as error:
        if error.recording is not None and error.recording.views:
            _say_how_to_go_on(error.recording, kept, output)
        raise
    if kept.path is None:
        raise UsageError("no view was taken")
    return conclude(recording[0], result, kept.path, chosen, output, target)


def _say_how_to_go_on(recording: Recording, kept: KeptFile, output: Output) -> None:
    kept.keep(recording)
    label = "" if recording.key.camera != UNNAMED else " with --offline"
    output.note(
        f"{len(recording.views)} views are in {kept.path}: `calibdb resume {kept.path}` continues with them, "
        f"`calibdb submit {kept.path}` calibrates from them{label}"
    )


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "resume",
        help="continue a live capture that ended early",
        description="Continue a live capture, from the file that `calibdb calibrate` kept.",
    )
    parser.add_argument("file", help="file that `calibdb calibrate` kept")
    parser.add_argument("camera", nargs="?", help="the camera; found by its label unless given")
    add_show(parser)
    add_model(parser)
    add_contribution(parser)
    parser.set_defaults(run=resume, square_mm=None)


def resume(chosen: argparse.Namespace, output: Output) -> int:
    """Read the file, open the camera, and continue the capture."""
    recording = Recording.load(chosen.file)
    if not recording.live:
        raise UsageError(f"{chosen.file} contains images, not a live capture: `calibdb submit {chosen.file}`")
    if not chosen.offline and recording.key.camera == UNNAMED:
        raise UsageError("this capture has no camera's label: go on with --offline")
    camera = chosen.camera or recording.key.camera
    if camera == UNNAMED:
        raise UsageError("which camera is it? Give its index, path or address after the file")
    licence = None if chosen.offline else licence_of(chosen, output)
    arguments = {"resume": recording, "show": chosen.show}
    return capture(camera, arguments, licence, KeptFile(chosen.file), chosen, output)
