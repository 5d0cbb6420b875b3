"""A rig from folders of pictures, one for each camera: paired by name or order, fitted by calibsolver."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import pictures
from .board import Board
from .errors import CaptureError, UsageError
from .key import AUTO, UNNAMED, CameraKey, checked_model
from .model_choice import chosen_model
from .pictures import PLATFORM, FoundViews, picture_paths
from .recording import Progress, RecordedView, Recording
from .rig import Rig
from .session import refusal

MIN_CAMERAS, MAX_CAMERAS = 2, 8
MIN_MOMENTS = 3
_RIG_REASONS = {"contradicts": "it contradicts the others: the pictures are not of one moment"}


@dataclass(frozen=True)
class RigResult:
    """Result of a rig's calibration.

    `moments` were seen by two cameras or more; pictures left out are folder/name.
    """

    rig: Rig
    board: Board
    moments: int
    left_out: tuple[tuple[str, str], ...] = ()

    def board_sentence(self, square_mm: float | None = None) -> str | None:
        """Return the sentence `Board.shape_sentence`."""
        return self.board.shape_sentence(self.rig.record.get("board_shape"), square_mm)


def calibrate_rig(
    folders: Sequence[str | Path],
    *,
    board: Board | None = None,
    model: str = AUTO,
    square_size: float | None = None,
    progress: Progress | None = None,
) -> RigResult:
    """Calibrate cameras that do not move against each other, on this machine; nothing is sent.

    Parameters
    ----------
    folders
        A folder of pictures of each camera. Pictures with the same file name show the same moment; if no
        names are the same, those at the same place in the order of names do.
    board, model
        The board, recognised by default; the distortion model, chosen for each camera if ``auto``.
    square_size
        Side of a square, or of a tag, metres: lengths are then metres, else squares.
    progress
        Receives how many of how many pictures are read.

    Raises UsageError if the folders cannot be paired, CaptureError if the pictures do not suffice.
    """
    if not MIN_CAMERAS <= len(folders) <= MAX_CAMERAS:
        raise UsageError(f"a rig has {MIN_CAMERAS} to {MAX_CAMERAS} cameras, a folder each")
    paths = [picture_paths([folder]) for folder in folders]
    moments = _moments(paths)
    names = _names(folders)
    chosen = board or pictures.recognise_board(max(paths, key=len))
    recordings, left_out, done = [], [], 0
    for position, files in enumerate(paths):
        result = FoundViews()
        pictures.read(files, chosen, result, _shifted(progress, done, sum(map(len, paths))))
        done += len(files)
        size, views = result.of_one_size(MIN_MOMENTS)
        recordings.append(Recording(CameraKey(names[position], PLATFORM, size), chosen, views))
        missed = {file.name for file in files} - {view.source for view in views}
        left_out += [(f"{names[position]}/{name}", "no board was detected") for name in sorted(missed)]
    return fit_rig(recordings, moments, chosen, model, square_size, left_out)


def _moments(paths: Sequence[Sequence[Path]]) -> list[dict[int, str]]:
    """Return the names of the pictures of each moment, by the positions of their cameras."""
    stems = [{path.stem: path.name for path in files} for files in paths]
    common = set(stems[0]).intersection(*stems[1:])
    shared = {stem for n, one in enumerate(stems) for stem in one if any(stem in s for s in stems[:n])}
    if common or len(shared) >= MIN_MOMENTS:
        names = sorted(set().union(*stems))
        return [{i: s[name] for i, s in enumerate(stems) if name in s} for name in names]
    counts = [len(files) for files in paths]
    if len(set(counts)) > 1:
        raise UsageError(
            f"the folders contain {', '.join(map(str, counts))} images, and no names are the same: give "
            "pictures of one moment the same name, or as many in each folder"
        )
    return [{i: path.name for i, path in enumerate(each)} for each in zip(*paths, strict=True)]


def fit_rig(
    recordings: Sequence[Recording],
    moments: Sequence[dict[int, str]],
    board: Board,
    model: str,
    square_size: float | None,
    left_out: list[tuple[str, str]],
) -> RigResult:
    """Calibrate a rig from the recordings of its cameras; `moments` are names of views by position.

    Parameters and errors as of `calibrate_rig`; `left_out` begins with the pictures without a board.
    """
    from calibsolver import CalibrationError
    from calibsolver.rig import estimate

    names = [recording.key.camera for recording in recordings]
    views: list[dict[str, RecordedView]] = [{v.source: v for v in each.views} for each in recordings]
    used = [{i: views[i][name] for i, name in moment.items() if name in views[i]} for moment in moments]
    shared = [moment for moment in used if len(moment) > 1]
    if len(shared) < MIN_MOMENTS:
        raise CaptureError(
            f"{len(shared)} moments show the board in two cameras, and {MIN_MOMENTS} are needed, better 15"
        )
    cameras = [
        {
            "img_size": list(recording.key.img_size),
            "distortion_model": chosen_model(recording, AUTO)[0] if model == AUTO else checked_model(model),
            "start": None,
        }
        for recording in recordings
    ]
    record = {
        "board": board.record(),
        "cameras": cameras,
        "moments": [
            {"id": str(m), "views": {i: view.record() for i, view in moment.items()}}
            for m, moment in enumerate(used)
            if moment
        ],
    }
    try:
        state = estimate(record, final=True)
    except (CalibrationError, ValueError) as error:
        raise CaptureError(f"the pictures determine no rig: {error}") from None
    fit = state["fit"]
    if fit is None:
        apart = ", ".join(names[i] for i in state["unlinked"])
        why = state["problem"] or f"{apart} shares no moment with {names[0]}"
        raise CaptureError(f"the pictures determine no rig: {why}")
    left_out += [
        (
            f"{names[each['position']]}/{used[int(each['moment'])][each['position']].source}",
            _RIG_REASONS.get(each["reason"], refusal(each["reason"])),
        )
        for each in fit["set_aside"]
    ]
    rig = Rig(_record(fit, recordings))
    rig = rig if square_size is None else rig.to_metres(square_size)
    return RigResult(rig, board, len(shared), tuple(left_out))


def _record(fit: dict[str, Any], recordings: Sequence[Recording]) -> dict[str, Any]:
    return {
        "rig_id": None,
        "calibrations": [
            {**camera, **recording.key.record(), "id": None}
            for camera, recording in zip(fit["cameras"], recordings, strict=True)
        ],
        "extrinsics": [
            {"position": i, "rvec": pose[:3], "tvec": pose[3:], "std": std}
            for i, (pose, std) in enumerate(zip(fit["poses"], fit["std"], strict=True))
        ],
        "unit": "squares",
        "rms": fit["rms"],
        "held_out_rms": fit["held_out_rms"],
        "uncertainty": fit["uncertainty"],
        "board_poses": [
            {"moment": each["moment"], "rvec": each["pose"][:3], "tvec": each["pose"][3:]}
            for each in fit["board_poses"]
        ],
        **({"board_shape": fit["board_shape"]} if "board_shape" in fit else {}),
    }


def _names(folders: Sequence[str | Path]) -> list[str]:
    """Return a name of each camera: its folder's, with the position if folders have the same name."""
    names = [Path(folder).resolve().name or UNNAMED for folder in folders]
    return [name if names.count(name) == 1 else f"{name} {i}" for i, name in enumerate(names)]


def _shifted(progress: Progress | None, before: int, total: int) -> Progress | None:
    return None if progress is None else lambda n, _: progress(before + n, total)
