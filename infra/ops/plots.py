"""Plot of one camera's calibrations in a terminal: members of the consensus, and the other groups."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

import plotext

from calibdb.schema import CalibrationDocument, ConsensusDocument
from calibdb.schema.fields import DistortionModel
from calibsolver import Camera
from calibsolver.consensus.agreement import difference
from infra.ops.cameras import Mode, title
from infra.ops.context import OpsContext

_MARKERS = ("●", "x", "+", "◇", "▵")
_HEIGHT = 18  # lines of a terminal
_MAX_GROUPS = len(_MARKERS)  # with their own marker; the others have none


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
        by_group.setdefault(names.get(document.id, "alone"), []).append(_point(document, model, reference))
    return {name: points for name, points in by_group.items() if points}


def draw(context: OpsContext, mode: Mode, width: int) -> str:
    """Draw focal lengths against differences from the consensus, as lines of text."""
    plotext.clear_figure()
    plotext.theme("clear")
    plotext.plotsize(width, _HEIGHT)
    plotext.title(title(mode.mode))
    plotext.xlabel("fx (px)")
    plotext.ylabel("difference from the consensus (px rms)")
    groups = points_by_group(context, mode)
    for (name, points), marker in zip(groups.items(), _cycle(len(groups)), strict=True):
        finite = [point for point in points if math.isfinite(point.difference)]
        plotext.scatter(
            [point.fx for point in finite],
            [point.difference for point in finite],
            label=f"{name} ({len(points)})",
            marker=marker,
        )
    return str(plotext.uncolorize(plotext.build()))


def _cycle(number: int) -> list[str]:
    return [_MARKERS[min(i, _MAX_GROUPS - 1)] for i in range(number)]


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


def _point(document: CalibrationDocument, model: DistortionModel, reference: Camera) -> Point:
    record = document.fits[model].model_dump()
    return Point(
        document.id, record["camera_matrix"][0][0], difference(reference, Camera.from_record(record))
    )
