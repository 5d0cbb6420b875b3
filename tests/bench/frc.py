"""`make bench DOCS=frc`: held-out errors on PhotonVision's own sets, with and without bad snapshots.

A bad snapshot is simulated in every tenth training view: half of its corners lie 3 px off, as of a board that
moved meanwhile. OpenCV's calibrateCamera takes every corner as it is.
"""

from collections.abc import Callable, Sequence

import numpy as np

from calibsolver import Camera, View, fit
from tests.bench import corners, document, opencv

SHIFT_PX, EVERY = 3.0, 10


def spoiled(views: Sequence[View]) -> list[View]:
    made = []
    for i, view in enumerate(views):
        moved = np.array(view.image_points)
        if i % EVERY == 0:
            moved[: len(view) // 2] += SHIFT_PX / np.sqrt(2)
        made.append(View(view.object_points, moved))
    return made


def figures(data: corners.Corners) -> list[float]:
    """Rms, px, of the views left out: calibDB, OpenCV, and both with bad snapshots."""

    def ours(views: Sequence[View]) -> Camera:
        return fit(views, data.img_size, board_shape=False).camera

    def theirs(views: Sequence[View]) -> Camera:
        return opencv.calibrate(views, data.img_size, "rectilinear")[1]

    calibrations: tuple[Callable[[Sequence[View]], Camera], ...] = (
        ours,
        theirs,
        lambda views: ours(spoiled(views)),
        lambda views: theirs(spoiled(views)),
    )
    return [corners.rms(*data.held_out(calibrate)) for calibrate in calibrations]


def main() -> None:
    rows = []
    for name in corners.NAMES:
        if name.startswith("pv_"):
            data = corners.load(name)
            rows.append([f"`{name}`", str(len(data.views)), *(f"{x:.3f}" for x in figures(data))])
    header = ["set", "views", "calibDB, px", "OpenCV, px", "with bad snapshots: calibDB, px", "OpenCV, px"]
    print(document.table(header, rows))


if __name__ == "__main__":
    main()
