"""The real corner sets, and how they are divided for cross-validation."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from calibsolver import Camera, View
from calibsolver.fitting.resection import reprojection_score
from tests.helpers.data import corner_set

NAMES = (
    "opencv_left",
    "opencv_right",
    "pv_charuco_480",
    "pv_charuco_1280",
    "pv_picam_320",
    "pv_picam_640",
    "pv_picam_960",
    "pv_picam_1920",
    "jy_left",
    "derlunz",
    "mint_isaw",
    "arizonat_fe",
    "ocam_fisheye2",
    "babel_ov_plane",
)
FOLDS = 5


@dataclass(frozen=True)
class Corners:
    """Views of one camera; `split` is the part of each in which it is left out, -1: never."""

    name: str
    img_size: tuple[int, int]
    views: tuple[View, ...]
    split: tuple[int, ...]

    @property
    def training(self) -> list[View]:
        """Views of the training error: all, or those that the set's authors trained on."""
        return [v for v, part in zip(self.views, self.split, strict=True) if part < 0] or list(self.views)

    def parts(self) -> Iterator[tuple[list[View], list[View]]]:
        """Training and test views: first the training error's (no test views), then of each fold."""
        yield self.training, []
        for fold in sorted({part for part in self.split if part >= 0}):
            pairs = list(zip(self.views, self.split, strict=True))
            yield [v for v, part in pairs if part != fold], [v for v, part in pairs if part == fold]

    def held_out(self, calibrate: Callable[[Sequence[View]], Camera]) -> tuple[list[float], list[int]]:
        """Mean square errors of the views left out, px^2, and their points, of each fold."""
        squares, points = [], []
        for training, test in self.parts():
            if test:
                squares.append(reprojection_score(calibrate(training), test).rms ** 2)
                points.append(sum(map(len, test)))
        return squares, points


def load(name: str) -> Corners:
    """Read a corner set: five folds, view i in fold i mod 5, or the split of its authors."""
    data = corner_set(name)
    views = data["views"]
    if "split" in views[0]:
        split = [0 if view["split"] == "test" else -1 for view in views]
    else:
        split = [i % FOLDS for i in range(len(views))]
    return Corners(
        name, tuple(data["image_size"]), tuple(View(v["obj"], v["img"]) for v in views), tuple(split)
    )
