"""The real corner sets, and how they are divided for cross-validation."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from calibsolver import Calibration, CalibrationError, Camera, View, fit
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
FISHEYE = ("jy_left", "derlunz", "mint_isaw", "arizonat_fe", "ocam_fisheye2", "babel_ov_plane")
FOLDS = 5


@dataclass(frozen=True)
class Corners:
    """Views of one camera; `split` is the fold in which each is left out, -1: never."""

    name: str
    img_size: tuple[int, int]
    views: tuple[View, ...]
    split: tuple[int, ...]

    @classmethod
    def of(cls, name: str, img_size: tuple[int, int], views: Sequence[View]) -> "Corners":
        """Put view i into fold i mod 5."""
        return cls(name, img_size, tuple(views), tuple(i % FOLDS for i in range(len(views))))

    @property
    def training(self) -> list[View]:
        """Views of the training error: all, or those that the set's authors trained on."""
        return [v for v, part in zip(self.views, self.split, strict=True) if part < 0] or list(self.views)

    def folds(self) -> Iterator[tuple[list[View], list[View]]]:
        """Training and test views of each fold."""
        pairs = list(zip(self.views, self.split, strict=True))
        for fold in sorted({part for part in self.split if part >= 0}):
            yield [v for v, part in pairs if part != fold], [v for v, part in pairs if part == fold]

    def held_out(self, calibrate: Callable[[Sequence[View]], Camera]) -> tuple[list[float], list[int]]:
        """Mean square errors of the views left out, px^2, and their points, of each fold."""
        squares, points = [], []
        for training, test in self.folds():
            squares.append(reprojection_score(calibrate(training), test).rms ** 2)
            points.append(sum(map(len, test)))
        return squares, points


def rms(squares: Sequence[float], points: Sequence[int]) -> float:
    """Rms over the points of all folds, of the mean squares of each."""
    return float(np.sqrt(np.average(squares, weights=points)))


def load(name: str) -> Corners:
    """Read a corner set, in folds or with the split of its authors."""
    data = corner_set(name)
    size = tuple(data["image_size"])
    views = tuple(View(v["obj"], v["img"]) for v in data["views"])
    if "split" not in data["views"][0]:
        return Corners.of(name, size, views)
    return Corners(name, size, views, tuple(0 if v["split"] == "test" else -1 for v in data["views"]))


def try_fit(
    views: Sequence[View], img_size: tuple[int, int], model: str, **options: Any
) -> Calibration | None:
    """Fit, with the board as drawn; None if that is impossible."""
    try:
        return fit(views, img_size, model, **({"board_shape": False} | options))
    except CalibrationError:
        return None
