"""`make bench DOCS=frc`: held-out errors on PhotonVision's own sets, with and without bad snapshots.

Five folds; the intrinsics of the others, the poses of the views left out fitted anew. A bad snapshot is
simulated in every tenth training view: half of its corners lie 3 px off, as of a board that moved while the
picture was taken. OpenCV's calibrateCamera takes every corner as it is.
"""

from collections.abc import Callable, Sequence

import numpy as np

from calibsolver import Camera, View, fit
from tests.bench import corners, opencv

Size = tuple[int, int]
Calibrate = Callable[[Sequence[View], Size], Camera]
SHIFT_PX, EVERY = 3.0, 10


def spoiled(views: Sequence[View]) -> list[View]:
    """Return the views with a bad snapshot in every tenth."""
    made = []
    for i, view in enumerate(views):
        moved = np.array(view.image_points)
        if i % EVERY == 0:
            moved[: len(view) // 2] += SHIFT_PX / np.sqrt(2)
        made.append(View(view.object_points, moved))
    return made


def held_out(data: corners.Corners, calibrate: Calibrate, *, bad: bool) -> float:
    """Rms, px, of the views left out."""
    squares, points = data.held_out(lambda views: calibrate(spoiled(views) if bad else views, data.img_size))
    return float(np.sqrt(np.average(squares, weights=points)))


def ours(views: Sequence[View], img_size: Size) -> Camera:
    """Fit as the client does."""
    return fit(views, img_size, board_shape=False).camera


def theirs(views: Sequence[View], img_size: Size) -> Camera:
    """Calibrate by OpenCV."""
    return opencv.calibrate(views, img_size, "rectilinear")[1]


def main() -> None:
    """Print a row of each set."""
    print("| set | views | calibDB, px | OpenCV, px | with bad snapshots: calibDB, px | OpenCV, px |")
    print("|---|---|---|---|---|---|")
    for name in corners.NAMES:
        if not name.startswith("pv_"):
            continue
        data = corners.load(name)
        figures = [
            held_out(data, calibrate, bad=bad) for bad in (False, True) for calibrate in (ours, theirs)
        ]
        print(f"| `{name}` | {len(data.views)} | " + " | ".join(f"{x:.3f}" for x in figures) + " |")


if __name__ == "__main__":
    main()
