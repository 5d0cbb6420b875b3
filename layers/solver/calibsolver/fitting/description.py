"""Texts of a calibration for people: a line, a summary, a table for notebooks."""

from collections import Counter
from collections.abc import Mapping
from html import escape
from typing import Protocol

import numpy as np

from .. import models
from ..arrays import Array, Mask
from ..camera import Camera
from .uncertainty import Uncertainty


class Described(Protocol):
    """Members of a `Calibration` that the texts name."""

    @property
    def camera(self) -> Camera:
        """Camera."""

    @property
    def covariance(self) -> Array:
        """(p, p)."""

    @property
    def used(self) -> tuple[Mask, ...]:
        """For each view (n,)."""

    @property
    def cut_views(self) -> Mapping[int, str]:
        """Reasons by view."""

    @property
    def avg_reprojection_error(self) -> float:
        """Px."""

    @property
    def rms_inliers(self) -> float:
        """Px."""

    def uncertainty(self) -> Uncertainty:
        """Error over the image."""


def line(calibration: Described) -> str:
    """Return one line: camera, views, errors."""
    camera, (fx, fy, cx, cy) = calibration.camera, calibration.camera.intrinsics[:4]
    w, h = camera.img_size
    return (
        f"Calibration({camera.model}, {w}x{h}, fx={fx:.2f}, fy={fy:.2f}, cx={cx:.2f}, cy={cy:.2f}, "
        f"{_views(calibration)} views, rms {calibration.rms_inliers:.3f} px)"
    )


def summary(calibration: Described) -> str:
    """Return a few lines: intrinsics with standard deviations, errors, views left out."""
    rows = [*_intrinsics(calibration), *_facts(calibration)]
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {text}" for name, text in rows)


def html(calibration: Described) -> str:
    """Return the summary as a table."""
    rows = [*_intrinsics(calibration), *_facts(calibration)]
    cells = "".join(f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in rows)
    return f"<table>{cells}</table>"


def _intrinsics(calibration: Described) -> list[tuple[str, str]]:
    camera = calibration.camera
    names = ("fx", "fy", "cx", "cy", *models.get(camera.model).coefficients)
    deviations: Array = np.sqrt(np.maximum(np.diagonal(calibration.covariance), 0))
    digits = (2,) * 4 + (5,) * len(camera.distortion)
    numbers = zip(names, camera.intrinsics, deviations, digits, strict=True)
    return [
        (name, f"{value:.{d}f} ± {sigma:.{d}f}" if sigma > 0 else f"{value:.{d}f} (fixed)")
        for name, value, sigma, d in numbers
    ]


def _facts(calibration: Described) -> list[tuple[str, str]]:
    camera, stated = calibration.camera, calibration.uncertainty()
    w, h = camera.img_size
    used, count = sum(int(u.sum()) for u in calibration.used), sum(len(u) for u in calibration.used)
    left_out = Counter(calibration.cut_views.values())
    reasons = "; left out: " + ", ".join(f"{n} {why}" for why, n in left_out.items()) if left_out else ""
    return [
        ("camera", f"{camera.model}, {w} x {h} px"),
        ("views", f"{_views(calibration)} of {len(calibration.used)}{reasons}"),
        ("corners", f"{used} of {count}"),
        (
            "rms",
            f"{calibration.rms_inliers:.3f} px, {calibration.avg_reprojection_error:.3f} px of all corners",
        ),
        ("uncertainty", f"{stated.rms:.2f} px rms over the image, {stated.max:.2f} px at most"),
    ]


def _views(calibration: Described) -> int:
    return len(calibration.used) - len(calibration.cut_views)
