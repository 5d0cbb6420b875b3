"""`make bench DOCS=real-views`: the guidance chooses among the views of real sets; writes docs/accuracy.md.

Of a set with at least 16 views k are chosen one after the other, each by the estimate from those before it,
and fitted. The distance of that camera from a reference, px rms over the image after the best rotation, is
compared with the distances of eight random choices of k views. Two references: the fit of all other views,
which lacks what the choice took; and the fit of all views, the same for every choice.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from calibsolver import Board, Calibration, CalibrationError, Camera, View, fit, rotation
from calibsolver.camera import pixel_grid
from calibsolver.fitting.validation import degenerate_views, pack
from calibsolver.formats.grid import grid
from calibsolver.guidance import PoseSelection, view_selection
from calibsolver.guidance.overlap import estimate_outline, jaccard_index
from tests.bench import corners, document

MODELS = ("rectilinear", "fisheye")
DRAWS = 8
MIN_VIEWS, MIN_VIEWS_OF_MANY = 16, 25
MAX_NOISE_RATIO = 2.0
"""Noise of a model / noise of the best of a set, from which the model is not believable there."""
Chooser = Callable[[Sequence[View], tuple[int, int], str, int], list[int]]


def distance(one: Camera, other: Camera) -> float:
    """Difference of two cameras' projections, px rms where both have rays; infinite for less than half."""
    q = pixel_grid(one.img_size, (20, 15)).reshape(2, -1).T
    a, b = one.unproject(q), other.unproject(q)
    seen = np.isfinite(a[:, 0]) & np.isfinite(b[:, 0])
    if seen.mean() < 0.5:
        return np.inf
    a, b, q = a[seen], b[seen], q[seen]
    r = rotation.nearest(b.T @ a)
    for _ in range(4):
        rays = a @ r.T
        e = other.project(rays) - q
        step = 1e-6
        turned = [other.project(rays @ rotation.matrix(step * axis).T) for axis in np.eye(3)]
        j = np.stack([(t - q - e) / step for t in turned], axis=-1)
        good = np.isfinite(e).all(axis=1) & np.isfinite(j).all(axis=(1, 2))
        r = rotation.matrix(-np.linalg.lstsq(j[good].reshape(-1, 3), e[good].reshape(-1), rcond=None)[0]) @ r
    e = other.project(a @ r.T) - q
    return float(np.sqrt(np.mean(np.sum(e[np.isfinite(e).all(axis=1)] ** 2, axis=1))))


def guided(views: Sequence[View], size: tuple[int, int], model: str, count: int) -> list[int]:
    return view_selection.select_views(views, size, model, count)


def published(views: Sequence[View], size: tuple[int, int], model: str, count: int) -> list[int]:
    """Choose the view that overlaps most with the target of the published method, each time."""
    found = grid(views)
    board = Board(found.squares, dictionary="DICT_4X4_1000")
    shown = [board.view(i, view.image_points) for i, view in zip(found.ids, views, strict=True)]
    outlines = [estimate_outline(board, view) for view in shown]
    guide = PoseSelection(board, size, model)
    chosen: list[int] = []
    while len(chosen) < count:
        with np.errstate(all="ignore"):
            target = guide.next_pose([shown[i] for i in chosen], None)
        left = [i for i in range(len(views)) if i not in chosen]
        chosen.append(max(left, key=lambda i: jaccard_index(target.outline, outlines[i], size)))
    return chosen


@dataclass(frozen=True)
class Row:
    """Distances of one choice from both references, and of the median random choice."""

    name: str
    model: str
    count: int
    others: tuple[float, float, float]
    """Guided, random (median), published: from the fit of all other views, px."""
    everything: tuple[float, float, float]
    """The same from the fit of all views."""


def try_fit(views: Sequence[View], size: tuple[int, int], model: str) -> Calibration | None:
    try:
        return fit(views, size, model)
    except CalibrationError:
        return None


def distances(
    views: Sequence[View], size: tuple[int, int], model: str, chosen: Sequence[int], whole: Camera
) -> tuple[float, float]:
    """Distances of the fit of the chosen views from that of all others, and from that of all."""
    ours = try_fit([views[i] for i in chosen], size, model)
    rest = try_fit([view for i, view in enumerate(views) if i not in chosen], size, model)
    if ours is None:
        return np.inf, np.inf
    return distance(rest.camera, ours.camera) if rest else np.nan, distance(whole, ours.camera)


def rows_of(name: str) -> list[Row]:
    data = corners.load(name)
    size = data.img_size
    flat = degenerate_views(pack(data.views, size))
    views = [view for view, bad in zip(data.views, flat, strict=True) if not bad]
    if len(views) < MIN_VIEWS:
        return []
    fits = {model: try_fit(views, size, model) for model in MODELS}
    least = min((f.noise for f in fits.values() if f), default=np.nan)
    out = []
    for model, whole in fits.items():
        if whole is None or whole.noise > MAX_NOISE_RATIO * least:
            continue
        counts = (6, 10, 15) if len(views) >= MIN_VIEWS_OF_MANY else (6,)
        ours = guided(views, size, model, counts[-1])
        try:
            theirs = published(views, size, model, counts[-1])
        except CalibrationError:
            theirs = []
        for count in counts:
            rng = np.random.default_rng(0)
            draws = [rng.permutation(len(views))[:count].tolist() for _ in range(DRAWS)]
            drawn = [distances(views, size, model, draw, whole.camera) for draw in draws]
            chosen = distances(views, size, model, ours[:count], whole.camera)
            peer = distances(views, size, model, theirs[:count], whole.camera) if theirs else (np.nan, np.nan)
            random = np.nanmedian(np.array(drawn), axis=0)
            row = Row(
                name,
                model,
                count,
                (chosen[0], float(random[0]), peer[0]),
                (chosen[1], float(random[1]), peer[1]),
            )
            print(row, file=sys.stderr, flush=True)
            out.append(row)
    return out


def conclusion(rows: Sequence[Row]) -> str:
    parts = []
    for what, pairs in (
        ("the fit of all other views", [row.others for row in rows]),
        ("the fit of all views", [row.everything for row in rows]),
    ):
        ours, random, theirs = np.array(pairs).T
        ratio = ours / random
        peer = theirs / random
        finite = np.isfinite(ratio) & (ratio > 0)
        mean = np.exp(np.mean(np.log(ratio[finite])))
        parts.append(
            f"Distance from {what}: the guided choice is nearer than the median random one in "
            f"{np.mean(ratio < 1):.0%} of {len(rows)} rows (ratio of distances: geometric mean {mean:.2f}, "
            f"above 1.5 in {int(np.sum(~(ratio <= 1.5)))} rows); the published method's choice in "
            f"{np.mean(peer < 1):.0%}."
        )
    return " ".join(parts)


def main() -> int:
    """Compare on every set that is at hand."""
    rows = [row for name in corners.NAMES for row in rows_of(name)]
    header = [
        "set",
        "model",
        "views",
        "others: guided, px",
        "random",
        "published",
        "all: guided, px",
        "random",
        "published",
    ]
    cells = [
        [
            row.name,
            row.model,
            str(row.count),
            *(f"{value:.2f}" if np.isfinite(value) else "none" for value in (*row.others, *row.everything)),
        ]
        for row in rows
    ]
    document.replace("real views", f"{document.table(header, cells)}\n\n{conclusion(rows)}")
    print(conclusion(rows))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
