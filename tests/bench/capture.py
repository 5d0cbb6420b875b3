"""`make bench DOCS=capture`: the rule that accepts views and ends captures, on real corners.

Of a set, views set aside at random give the reference. The others, the pool, are offered to a capture in
random order, twice, whatever the outline. The camera that the capture ends with is compared with the fit of
the whole pool, by the distance of each from the reference: px rms at 1280 px width, over the image and inside
the hull of the reference's corners.

SEEDS=3 draws of each set; ONLY=jy_left,babel_ov_plane.
"""

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from calibdb_client.board import Board as ClientBoard
from calibdb_client.detection import Detector
from calibsolver import Board, CalibrationError, Camera, View, fit
from calibsolver.camera import pixel_grid
from calibsolver.capture import Capture
from calibsolver.capture.admission import rejection_reason
from calibsolver.fitting.coverage import COVERAGE_GRID, hull
from calibsolver.quality.assessment import level_of
from infra.console import track
from tests.bench import document
from tests.bench.corners import FISHEYE, NAMES
from tests.bench.real_views import distance, usable_views
from tests.helpers.data import EXTERNAL, available, on_board
from tests.helpers.solver.synthetic import Sitting

INVERTED = {"squares": (4, 5), "marker_ratio": 0.75, "dictionary": "DICT_4X4_50", "inverted": True}
VIDEOS: dict[str, tuple[str, dict[str, object], int]] = {
    "opt1": ("caliscope_opt1.mp4", INVERTED, 15),
    "char0": ("caliscope_char0_mpeg4.mp4", INVERTED, 15),
    "pre1": ("caliscope_pre1_mirrored.mp4", INVERTED, 8),
    "yubin": ("chessboard_yubin.mp4", {"squares": (9, 7), "kind": "chessboard"}, 15),
    "uk": ("chessboard_uk.avi", {"squares": (11, 8), "kind": "chessboard"}, 15),
}
"""File in the folder of videos, board, and px between the views taken from it."""
MIRRORED = ("pre1",)
ASIDE_SHARE = 0.35
"""Share of the views that give the reference."""
MAX_RATIO = 1.3
"""Error of a capture / error of its pool, up to which the capture lost little."""


@dataclass(frozen=True)
class Footage:
    name: str
    board: Board
    img_size: tuple[int, int]
    views: Sequence[View]

    @property
    def model(self) -> str:
        return "fisheye" if self.name in FISHEYE else "rectilinear"


@dataclass(frozen=True)
class Outcome:
    """End of one capture. Errors are px at 1280 px width: over the image, inside the hull."""

    end: str
    posts: int
    views: int
    stated: tuple[float, float]
    covered: float
    actual: tuple[float, float]
    pool: tuple[float, float]

    @property
    def ratios(self) -> tuple[float, float]:
        return self.actual[0] / self.pool[0], self.actual[1] / self.pool[1]


def footage() -> Iterator[Footage]:
    for name in available(NAMES):
        if document.is_chosen(name):
            views, size = usable_views(name)
            board, _, shown = on_board(views)
            if rejection_reason(shown[0], size) == "mirrored":  # numbered from below
                shown = tuple(upside_down(board, view) for view in shown)
            yield Footage(name, board, size, shown)
    for name in VIDEOS if EXTERNAL is not None else ():
        if document.is_chosen(name):
            yield read_video(name)


def upside_down(board: Board, view: View) -> View:
    """View of a board whose rows are numbered from the other side."""
    points = view.object_points.copy()
    points[:, 1] = board.squares[1] - points[:, 1]
    return View(points, view.image_points)


def read_video(name: str) -> Footage:
    """Detect the board in a video, in frames in which it moved."""
    file, described, apart = VIDEOS[name]
    board, views = Board(**described), list[View]()  # type: ignore[arg-type]
    detector = Detector(ClientBoard(**described))  # type: ignore[arg-type]
    video = cv2.VideoCapture(str(EXTERNAL / "videos" / file)) if EXTERNAL else cv2.VideoCapture()
    size = (0, 0)
    while (read := video.read())[0]:
        frame = cv2.flip(read[1], 1) if name in MIRRORED else read[1]
        size = (frame.shape[1], frame.shape[0])
        corners = detector.find(frame)
        if corners is None:
            continue
        view = board.view(corners.ids, corners.points)
        if not views or moved(views[-1], view) >= apart:
            views.append(view)
    return Footage(name, board, size, views)


def moved(one: View, other: View) -> float:
    """Mean distance, px, of the corners that two views share; infinite if they share none."""
    places = {tuple(p): q for p, q in zip(one.object_points.tolist(), one.image_points, strict=True)}
    pairs = zip(other.object_points.tolist(), other.image_points, strict=True)
    lengths = [np.linalg.norm(q - places[tuple(p)]) for p, q in pairs if tuple(p) in places]
    return float(np.mean(lengths)) if lengths else np.inf


def run(source: Footage, seed: int) -> Outcome | None:
    """One capture; None if a fit fails that it is compared with."""
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(source.views))
    aside = round(ASIDE_SHARE * len(order))
    held_out, pool = ([source.views[i] for i in part] for part in (order[:aside], order[aside:]))
    size, model = source.img_size, source.model
    try:
        reference, whole = (fit(part, size, model) for part in (held_out, pool))
    except CalibrationError:
        return None
    offered = [pool[i] for _ in range(2) for i in rng.permutation(len(pool))]
    capture = Capture(source.board, size, model, target_error=0.3 / 1280 * size[0])
    sitting, end, posts = Sitting(capture), "never", 0
    target = capture.next_target([], sitting.estimate)
    for view in offered:
        posts += 1
        if sitting.offer(target, view).estimate is not None:
            end = sitting.estimate.end or end
            target = capture.next_target(sitting.views, sitting.estimate)
        elif sitting.is_exhausted:
            end = "nothing_new"
        if end != "never":
            break
    estimate = sitting.estimate
    if estimate.calibration is None or estimate.uncertainty is None or estimate.coverage is None:
        return None
    seen = np.concatenate([v.image_points[u] for v, u in zip(held_out, reference.used, strict=True)])
    scale = 1280 / size[0]

    def errors(camera: Camera) -> tuple[float, float]:
        cells = pixel_grid(size, COVERAGE_GRID).reshape(2, -1).T[hull(seen, size)]
        return scale * distance(reference.camera, camera), scale * distance(reference.camera, camera, cells)

    return Outcome(
        end,
        posts,
        len(sitting.used),
        (scale * estimate.uncertainty.rms, scale * estimate.coverage.rms),
        estimate.coverage.share,
        errors(estimate.calibration.camera),
        errors(whole.camera),
    )


def row(source: Footage, outcomes: Sequence[Outcome]) -> list[str]:
    def middle(pairs: Sequence[tuple[float, float]], digits: int = 1) -> str:
        return " / ".join(f"{value:.{digits}f}" for value in np.median(np.array(pairs), axis=0))

    levels = Counter(level_of(*o.stated, o.covered) for o in outcomes)
    ends = Counter(o.end for o in outcomes)
    return [
        source.name,
        str(len(source.views)),
        f"{np.median([o.views for o in outcomes]):.0f} ({np.median([o.posts for o in outcomes]):.0f})",
        ", ".join(f"{end} {count}" for end, count in ends.most_common()),
        middle([o.stated for o in outcomes]),
        middle([o.actual for o in outcomes]),
        middle([o.ratios for o in outcomes], 2),
        ", ".join(f"{level} {count}" for level, count in levels.most_common()),
    ]


def main() -> None:
    seeds = int(os.environ.get("SEEDS", "3"))
    rows, near, ended, total, true = [], np.zeros(2), 0, 0, 0
    for source in footage():
        tried = [run(source, seed) for seed in track(range(seeds), source.name, seeds)]
        outcomes = [outcome for outcome in tried if outcome is not None]
        if not outcomes:
            continue
        rows.append(row(source, outcomes))
        near += np.median([o.ratios for o in outcomes], axis=0) <= MAX_RATIO
        ended += sum(o.end != "never" for o in outcomes)
        true += sum(o.actual[0] <= 2 * o.stated[0] for o in outcomes)
        total += len(outcomes)
    header = ["set", "views", "taken (offered)", "ends", "stated, px", "actual, px"]
    header += ["actual / pool's", "verdicts"]
    conclusion = (
        f"{ended} of {total} captures end. The error is at most {MAX_RATIO} times that of the whole pool in "
        f"{near[0]:.0f} of {len(rows)} sets over the image, and in {near[1]:.0f} inside the hull (medians of "
        f"{seeds} draws). {true} of {total} ends are within twice their stated error of the reference, which "
        "has an error of its own."
    )
    document.replace("capture", f"{document.table(header, rows)}\n\n{conclusion}")


if __name__ == "__main__":
    main()
