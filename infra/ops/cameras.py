"""Listings of cameras, their calibrations and their use at the edge, for the operator."""

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
from calibdb.store.keys import camera_pk, with_tombstones
from infra.console import track
from infra.ops import OpsError, reindex
from infra.ops.context import CALIBRATIONS_PREFIX, OpsContext
from infra.ops.session import Json, open_run

app = typer.Typer(help="List cameras, and show one.", no_args_is_help=True)
_COLUMNS = ("id", "time (UTC)", "contributor", "model", "#views", "#fx (px)", "#rms (px)", "withdrawn")
_MARKERS = ("●", "x", "+", "◇", "▵")
_HEIGHT = 18  # lines of a terminal
_MAX_GROUPS = len(_MARKERS)  # with their own marker; the others have none
_LOOKUP_PATH = re.compile(r"/known/v1/([0-9a-f]{32})/")

Stored = tuple[CalibrationDocument, bool]
"""A calibration, and whether it is withdrawn."""
Groups = dict[str, list[tuple[float, float]]]
"""Focal length, px, and difference from the reference projection, px rms over the image, by group."""


@dataclass(frozen=True)
class Mode:
    """A camera at one size and zoom."""

    mode: StreamMode
    consensuses: list[ConsensusDocument]
    calibrations: list[Stored]

    @property
    def title(self) -> str:
        """Size and zoom."""
        return f"{self.mode.img_size[0]} x {self.mode.img_size[1]}, zoom {self.mode.zoom:g}"

    def record(self) -> dict[str, Any]:
        """Convert to plain values, for JSON."""
        return {
            "img_size": self.mode.img_size,
            "zoom": self.mode.zoom,
            "consensuses": [
                c.model_dump(mode="json", exclude={"layout", "basis", "pooled"}) for c in self.consensuses
            ],
            "calibrations": [_record(*one) for one in self.calibrations],
        }


@app.command("list")
def list_cameras(
    text: Annotated[str, typer.Argument(help="Only those whose key contains this text.")] = "",
    as_json: Json = False,
) -> None:
    """List the cameras that were calibrated."""
    with open_run(as_json=as_json) as (context, output):
        stored: Counter[str] = Counter()
        withdrawn: Counter[str] = Counter()
        names = with_tombstones(context.objects.names(CALIBRATIONS_PREFIX))
        for _, name, is_withdrawn in track(names, "calibrations"):
            key = name.split("/")[1]
            if text.lower() in key:
                stored[key] += 1
                withdrawn[key] += is_withdrawn
        rows = [(key, count, withdrawn[key]) for key, count in sorted(stored.items())]
        output.table(("camera", "#calibrations", "#withdrawn"), rows, (_count_line(*row) for row in rows))
        output.value([{"key": key, "calibrations": n, "withdrawn": m} for key, n, m in rows])


def _count_line(key: str, calibrations: int, withdrawn: int) -> str:
    line = f"{key}  {calibrations} calibration{'' if calibrations == 1 else 's'}"
    return line + (f", {withdrawn} withdrawn" if withdrawn else "")


@app.command("show")
def show_camera(
    key: Annotated[str, typer.Argument(help="As `camera list` prints it.")],
    plot: Annotated[
        bool, typer.Option("--plot", help="Draw the members of each consensus and the other groups.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Show consensuses and calibrations of one camera."""
    with open_run(as_json=as_json) as (context, output):
        stored = list(_read_calibrations(context, key))
        if not stored:
            raise OpsError(f"nothing is known of a camera {key}")
        by_mode: dict[StreamMode, list[Stored]] = {}
        for document, withdrawn in stored:
            by_mode.setdefault(reindex.mode_of(document), []).append((document, withdrawn))
        consensuses = context.store.consensuses
        modes = [Mode(mode, list(consensuses.at(mode)), members) for mode, members in by_mode.items()]
        newest = max((document for document, _ in stored), key=lambda document: document.time)
        # Stored before labels were cleaned, they may contain what a terminal would obey.
        camera, platform = visible(newest.camera), visible(newest.platform)
        output.value({"camera": camera, "platform": platform, "modes": [mode.record() for mode in modes]})
        output.line(f"{camera}, {platform}")
        for mode in modes:
            output.line(mode.title)
            for consensus in mode.consensuses:
                output.line(f"  {_describe_consensus(consensus)}")
            rows = [_row(_record(*one)) for one in mode.calibrations]
            output.table(_COLUMNS, rows, (_line(*row) for row in rows))
        if plot:
            width = min(100, shutil.get_terminal_size().columns)
            for mode in modes:
                if groups := _group(context, mode):
                    output.line(_draw(mode.title, groups, width))


def _read_calibrations(context: OpsContext, camera_key: str) -> Iterator[Stored]:
    """Yield the calibrations of one camera, oldest first. A key of earlier rules means the same camera.

    An object stays in the folder of the key that the camera had when it was stored.
    """
    under_key = dict(_stored_under(context, camera_key))
    keys = {camera_key, *(document.camera_key for document, _ in under_key.values())}
    indexed = [
        str(item["sk"]).rpartition("#")[2]
        for key in keys
        for item in context.storage.table.query(camera_pk(key), "CALIBRATION#", consistent=True)
    ]
    folders = {calibration_id.rpartition("-")[0] for calibration_id in indexed} - {camera_key}
    documents = under_key | {
        calibration_id: stored
        for folder in folders
        for calibration_id, stored in _stored_under(context, folder)
        if stored[0].camera_key in keys
    }
    yield from (documents[one] for one in sorted(documents, key=lambda one: one.rpartition("-")[2]))


def _stored_under(context: OpsContext, camera_key: str) -> Iterator[tuple[str, Stored]]:
    for _, name, withdrawn in with_tombstones(context.objects.names(f"{CALIBRATIONS_PREFIX}{camera_key}/")):
        document = context.store.calibrations.get(name.rpartition("/")[2].removesuffix(".json"))
        if document is not None:
            yield document.id, (document, withdrawn)


def _describe_consensus(consensus: ConsensusDocument) -> str:
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


def _record(document: CalibrationDocument, withdrawn: bool) -> dict[str, Any]:
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


def _row(record: dict[str, Any]) -> tuple[str, ...]:
    return (
        record["id"],
        time.strftime("%Y-%m-%d %H:%M", time.gmtime(record["time"])),
        record["contributor"][:12],
        record["distortion_model"],
        str(record["views"]),
        f"{record['fx']:.1f}",
        f"{record['rms']:.2f}",
        "withdrawn" if record["withdrawn"] else "",
    )


def _line(name: str, when: str, who: str, model: str, _: str, fx: str, rms: str, withdrawn: str) -> str:
    line = f"  {name}  {when}  contributor {who}  {model}  fx {fx}  rms {rms} px"
    return f"{line}  {withdrawn}" if withdrawn else line


@app.command("use")
def show_use(
    logs: Annotated[Path, typer.Argument(help="Folder with a copy of the bucket EdgeLogBucket.")],
    as_json: Json = False,
) -> None:
    """Count lookups at the edge by camera."""
    with open_run(as_json=as_json) as (context, output):
        digests = Counter(m[1] for path in _paths(logs) if (m := _LOOKUP_PATH.match(path)))
        counts: Counter[str] = Counter()
        for digest, requests in digests.items():
            alias = context.store.aliases.get(digest)
            counts["unknown" if alias is None else alias.label] += requests
        use = counts.most_common()
        output.table(("camera", "#lookups"), use, (f"{count:>9}  {label}" for label, count in use))
        output.value([{"camera": label, "lookups": count} for label, count in use])


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


def _group(context: OpsContext, mode: Mode) -> Groups:
    """Divide the calibrations of a mode into the members of the consensus and the other groups.

    The model is that of most calibrations; the others, and withdrawn ones, are left out. The reference is the
    consensus, or, if there is none, the newest calibration.
    """
    from calibsolver import Camera
    from calibsolver.consensus.agreement import difference

    counted = [document for document, withdrawn in mode.calibrations if not withdrawn]
    if not counted:
        return {}
    model = Counter(document.distortion_model for document in counted).most_common(1)[0][0]
    consensus = next((c for c in mode.consensuses if c.distortion_model == model), None)
    drawn = [document for document in counted if model in document.fits]
    pooled = consensus and consensus.calibration
    reference = Camera.from_record((pooled or drawn[-1].fits[model]).model_dump())
    names = _names_of_groups(context, consensus)
    by_group: Groups = {name: [] for name in names.values()}
    for document in drawn:
        camera = Camera.from_record(document.fits[model].model_dump())
        point = float(camera.matrix[0, 0]), difference(reference, camera)
        by_group.setdefault(names.get(document.id, "alone"), []).append(point)
    return {name: points for name, points in by_group.items() if points}


def _draw(title: str, groups: Groups, width: int) -> str:
    import plotext

    plotext.clear_figure()
    plotext.theme("clear")
    plotext.plotsize(width, _HEIGHT)
    plotext.title(title)
    plotext.xlabel("fx (px)")
    plotext.ylabel("difference from the consensus (px rms)")
    for number, (name, points) in enumerate(groups.items()):
        finite = [point for point in points if math.isfinite(point[1])]
        plotext.scatter(
            [fx for fx, _ in finite],
            [difference for _, difference in finite],
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
