"""Listings of cameras, their calibrations and their use at the edge, for the operator."""

from __future__ import annotations

import gzip
import json
import math
import re
import shutil
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from calibdb.camera_key.characters import visible
from calibdb.schema import CalibrationDocument, ConsensusDocument
from calibdb.store import StreamMode
from calibdb.store.aliases import Aliases
from calibdb.store.keys import WITHDRAWN, camera_pk, tombstone_object
from infra.ops import OpsError, reindex
from infra.ops.context import CALIBRATIONS_PREFIX, OpsContext
from infra.ops.session import Json, open_run

app = typer.Typer(help="List cameras, and show one.", no_args_is_help=True)
_COLUMNS = ("id", "time (UTC)", "contributor", "model", "#views", "#fx (px)", "#rms (px)", "withdrawn")
_MARKERS = ("●", "x", "+", "◇", "▵")
_HEIGHT = 18  # lines of a terminal
_MAX_GROUPS = len(_MARKERS)  # with their own marker; the others have none
UNKNOWN = "unknown"  # cameras that no lookup has found
_LOOKUP_PATH = re.compile(r"/known/v1/([0-9a-f]{32})/")


@dataclass(frozen=True)
class CameraCount:
    """Numbers of the stored and of the withdrawn calibrations under one key."""

    key: str
    calibrations: int
    withdrawn: int

    @property
    def line(self) -> str:
        """Describe the camera in a line."""
        text = f"{self.key}  {self.calibrations} calibration{'' if self.calibrations == 1 else 's'}"
        return text + (f", {self.withdrawn} withdrawn" if self.withdrawn else "")


@dataclass(frozen=True)
class Mode:
    """Everything that is known of a camera at one size and zoom. `True`: a withdrawn calibration."""

    mode: StreamMode
    consensuses: tuple[ConsensusDocument, ...]
    calibrations: tuple[tuple[CalibrationDocument, bool], ...]


@dataclass(frozen=True)
class CameraDetail:
    """A camera with all its modes."""

    camera: str
    platform: str
    modes: tuple[Mode, ...]

    def record(self) -> dict[str, Any]:
        """Convert to plain values, for JSON."""
        return {
            "camera": self.camera,
            "platform": self.platform,
            "modes": [
                {
                    "img_size": mode.mode.img_size,
                    "zoom": mode.mode.zoom,
                    "consensuses": [
                        c.model_dump(mode="json", exclude={"layout", "basis", "pooled"})
                        for c in mode.consensuses
                    ],
                    "calibrations": [calibration_record(*one) for one in mode.calibrations],
                }
                for mode in self.modes
            ],
        }


def count_all(context: OpsContext, text: str) -> list[CameraCount]:
    """Count the calibrations of each camera whose key contains `text`."""
    counts: Counter[str] = Counter()
    withdrawn: Counter[str] = Counter()
    for name in context.track(context.objects.names(CALIBRATIONS_PREFIX), "calibrations"):
        key = name.split("/")[1]
        if text.lower() in key:
            (withdrawn if name.endswith(WITHDRAWN) else counts)[key] += 1
    return [CameraCount(key, count, withdrawn[key]) for key, count in sorted(counts.items())]


def detail(context: OpsContext, camera_key: str) -> CameraDetail:
    """Read one camera: its consensuses, and every calibration.

    A key of earlier rules shows the camera that is known under today's.

    Raises
    ------
    OpsError
        If no calibration of the camera is stored.
    """
    stored = list(read_calibrations(context, camera_key))
    if not stored:
        raise OpsError(f"nothing is known of a camera {camera_key}")
    modes: dict[StreamMode, list[tuple[CalibrationDocument, bool]]] = {}
    for document, withdrawn in stored:
        modes.setdefault(reindex.mode_of(document), []).append((document, withdrawn))
    newest = max((document for document, _ in stored), key=lambda document: document.time)
    return CameraDetail(
        # Stored before labels were cleaned, it may hold what a terminal would obey.
        visible(newest.camera),
        visible(newest.platform),
        tuple(
            Mode(mode, tuple(context.store.consensuses.at(mode)), tuple(members))
            for mode, members in modes.items()
        ),
    )


def read_calibrations(context: OpsContext, camera_key: str) -> Iterator[tuple[CalibrationDocument, bool]]:
    """Yield the calibrations of one camera, oldest first, and whether they were withdrawn.

    An object stays in the folder of the key that the camera had when it was stored.
    """
    under_key = dict(_stored_under(context, camera_key))
    keys = {camera_key, *(document.camera_key for document, _ in under_key.values())}
    ids = {calibration_id for key in keys for calibration_id in _indexed_ids(context, key)}
    folders = {calibration_id.rpartition("-")[0] for calibration_id in ids} - {camera_key}
    documents = under_key | {
        calibration_id: stored
        for folder in folders
        for calibration_id, stored in _stored_under(context, folder)
        if stored[0].camera_key in keys
    }
    yield from (documents[one] for one in sorted(documents, key=lambda one: one.rpartition("-")[2]))


def _stored_under(
    context: OpsContext, camera_key: str
) -> Iterator[tuple[str, tuple[CalibrationDocument, bool]]]:
    """Yield id, document and whether it was withdrawn of each calibration in the folder of a key."""
    names = set(context.objects.names(f"{CALIBRATIONS_PREFIX}{camera_key}/"))
    for name in names:
        calibration_id = name.rpartition("/")[2].removesuffix(".json")
        if not name.endswith(WITHDRAWN):
            document = context.store.calibrations.get(calibration_id)
            if document is not None:
                yield calibration_id, (document, tombstone_object(calibration_id) in names)


def _indexed_ids(context: OpsContext, camera_key: str) -> Iterator[str]:
    """Yield the ids of the calibrations that the index knows under a key."""
    for item in context.storage.table.query(camera_pk(camera_key), "CALIBRATION#", consistent=True):
        yield str(item["sk"]).rpartition("#")[2]


def title(mode: StreamMode) -> str:
    """Name size and zoom of a mode."""
    return f"{mode.img_size[0]} x {mode.img_size[1]}, zoom {mode.zoom:g}"


def describe_consensus(consensus: ConsensusDocument) -> str:
    """Describe a consensus in a line: how many agree, or why nothing is reliable."""
    calibration = consensus.calibration
    what = "reliable" if consensus.reliable else f"not reliable ({consensus.reason})"
    line = f"{consensus.distortion_model}: {what}"
    if calibration is not None:
        line += (
            f"; {calibration.calibrations} of {consensus.total} agree, "
            f"{calibration.contributors} contributor{'' if calibration.contributors == 1 else 's'}, "
            f"fx {calibration.camera_matrix[0][0]:.1f}, rms {calibration.avg_reprojection_error:.2f} px"
        )
    return line


def calibration_record(document: CalibrationDocument, withdrawn: bool) -> dict[str, Any]:
    """Select what a listing shows of a calibration, as plain values."""
    fit = document.fits[document.distortion_model]
    return {
        "id": document.id,
        "time": document.time,
        "contributor": document.contributor,
        "distortion_model": document.distortion_model,
        "fx": fit.camera_matrix[0][0],
        "rms": fit.avg_reprojection_error,
        "views": len(document.views),
        "withdrawn": withdrawn,
    }


def calibration_row(document: CalibrationDocument, withdrawn: bool) -> tuple[object, ...]:
    """Select the cells of a table: id, time, contributor, model, views, fx, rms, whether withdrawn."""
    record = calibration_record(document, withdrawn)
    return (
        record["id"],
        format_time(record["time"]),
        record["contributor"][:12],
        record["distortion_model"],
        record["views"],
        f"{record['fx']:.1f}",
        f"{record['rms']:.2f}",
        "withdrawn" if withdrawn else "",
    )


def format_time(seconds: int) -> str:
    """Format unix seconds to the minute, UTC."""
    return time.strftime("%Y-%m-%d %H:%M", time.gmtime(seconds))


def describe_calibration(document: CalibrationDocument, withdrawn: bool) -> str:
    """Describe a calibration in a line."""
    record = calibration_record(document, withdrawn)
    return (
        f"{record['id']}  {format_time(record['time'])}  contributor {record['contributor'][:12]}  "
        f"{record['distortion_model']}  fx {record['fx']:.1f}  rms {record['rms']:.2f} px"
        f"{'  withdrawn' if withdrawn else ''}"
    )


def count_use(folder: Path, aliases: Aliases) -> Counter[str]:
    """Count the requests of `GET /known/v1/…` by camera label, in all logs below a folder."""
    digests = Counter(m[1] for path in _paths(folder) if (m := _LOOKUP_PATH.match(path)))
    use: Counter[str] = Counter()
    for digest, requests in digests.items():
        alias = aliases.get(digest)
        use[UNKNOWN if alias is None else alias.label] += requests
    return use


def _paths(folder: Path) -> Iterator[str]:
    """Yield the path of each request, from lines of JSON as CloudFront writes them."""
    logs = sorted(folder.rglob("*.gz"))
    if not logs:
        raise OpsError(f"no logs (*.gz) in {folder}: copy the bucket EdgeLogBucket there first")
    for log in logs:
        try:
            with gzip.open(log, "rt", encoding="utf-8") as lines:
                for line in lines:
                    yield str(json.loads(line).get("cs-uri-stem", ""))
        except (OSError, EOFError, ValueError, AttributeError) as error:
            raise OpsError(f"not a log of CloudFront in JSON: {log}: {error}") from error


@app.command("list")
def list_cameras(
    text: Annotated[str, typer.Argument(help="Only those whose key contains this text.")] = "",
    as_json: Json = False,
) -> None:
    """List the cameras that were calibrated."""
    with open_run(as_json=as_json) as run:
        counts = count_all(run.context, text)
        run.output.table(
            ("camera", "#calibrations", "#withdrawn"),
            ((one.key, one.calibrations, one.withdrawn) for one in counts),
            (one.line for one in counts),
        )
        run.output.value(
            [{"key": one.key, "calibrations": one.calibrations, "withdrawn": one.withdrawn} for one in counts]
        )


@app.command("show")
def show_camera(
    key: Annotated[str, typer.Argument(help="As `camera list` prints it.")],
    plot: Annotated[
        bool, typer.Option("--plot", help="Draw the members of each consensus and the other groups.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Show consensuses and calibrations of one camera."""
    with open_run(as_json=as_json) as run:
        found = detail(run.context, key)
        run.output.value(found.record())
        for text, rows, lines in _sections(found):
            run.output.line(text)
            if lines:
                run.output.table(_COLUMNS, rows, lines)
        if plot:
            width = min(100, shutil.get_terminal_size().columns)
            for mode in found.modes:
                if points_by_group(run.context, mode):
                    run.output.line(draw(run.context, mode, width))


@app.command("use")
def show_use(
    logs: Annotated[Path, typer.Argument(help="Folder with a copy of the bucket EdgeLogBucket.")],
    as_json: Json = False,
) -> None:
    """Count lookups at the edge by camera."""
    with open_run(as_json=as_json) as run:
        use = count_use(logs, run.context.store.aliases).most_common()
        run.output.table(("camera", "#lookups"), use, (f"{count:>9}  {label}" for label, count in use))
        run.output.value([{"camera": label, "lookups": count} for label, count in use])


def _sections(detail: CameraDetail) -> Iterator[tuple[str, list[tuple[object, ...]], list[str]]]:
    """Yield lines, and after the consensuses of each mode the rows and the lines of its calibrations."""
    yield f"{detail.camera}, {detail.platform}", [], []
    for mode in detail.modes:
        texts = [
            title(mode.mode),
            *(f"  {describe_consensus(c)}" for c in mode.consensuses),
        ]
        rows = [calibration_row(*one) for one in mode.calibrations]
        lines = [f"  {describe_calibration(*one)}" for one in mode.calibrations]
        yield "\n".join(texts), rows, lines


@dataclass(frozen=True)
class Point:
    """One calibration: focal length, px; difference from the reference projection, px rms over the image."""

    id: str
    fx: float
    difference: float


def points_by_group(context: OpsContext, mode: Mode) -> dict[str, list[Point]]:
    """Divide the calibrations of a mode into the members of the consensus and the other groups.

    The model is that of most calibrations; the others, and withdrawn ones, are left out. The reference is the
    consensus, or, where there is none, the newest calibration.
    """
    from calibsolver import Camera
    from calibsolver.consensus.agreement import difference

    counted = [document for document, withdrawn in mode.calibrations if not withdrawn]
    if not counted:
        return {}
    model = Counter(document.distortion_model for document in counted).most_common(1)[0][0]
    consensus = next((c for c in mode.consensuses if c.distortion_model == model), None)
    pooled = consensus.calibration if consensus is not None else None
    drawn = [document for document in counted if model in document.fits]
    record = pooled.model_dump() if pooled is not None else drawn[-1].fits[model].model_dump()
    reference = Camera.from_record(record)
    names = _names_of_groups(context, consensus)
    by_group: dict[str, list[Point]] = {name: [] for name in dict.fromkeys(names.values())}
    for document in drawn:
        fit = document.fits[model].model_dump()
        apart = difference(reference, Camera.from_record(fit))
        point = Point(document.id, fit["camera_matrix"][0][0], apart)
        by_group.setdefault(names.get(document.id, "alone"), []).append(point)
    return {name: points for name, points in by_group.items() if points}


def draw(context: OpsContext, mode: Mode, width: int) -> str:
    """Draw focal lengths against differences from the consensus, as lines of text."""
    import plotext

    plotext.clear_figure()
    plotext.theme("clear")
    plotext.plotsize(width, _HEIGHT)
    plotext.title(title(mode.mode))
    plotext.xlabel("fx (px)")
    plotext.ylabel("difference from the consensus (px rms)")
    groups = points_by_group(context, mode)
    for number, (name, points) in enumerate(groups.items()):
        finite = [point for point in points if math.isfinite(point.difference)]
        plotext.scatter(
            [point.fx for point in finite],
            [point.difference for point in finite],
            label=f"{name} ({len(points)})",
            marker=_MARKERS[min(number, _MAX_GROUPS - 1)],
        )
    return str(plotext.uncolorize(plotext.build()))


def _names_of_groups(context: OpsContext, consensus: ConsensusDocument | None) -> dict[str, str]:
    """Map the id of each grouped calibration to the name of its group, members first."""
    stored = context.store.consensuses.groups(consensus) if consensus is not None else None
    names: dict[str, str] = {}
    for number, group in enumerate(stored.groups if stored else ()):
        if number == 0:
            name = "members"
        elif number < _MAX_GROUPS - 1 and len(group) > 1:
            name = f"group {number + 1}"
        else:
            name = "alone"
        names |= dict.fromkeys(group, name)
    return names
