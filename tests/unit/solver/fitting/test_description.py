"""Texts of a calibration, and refusals of points outside the image."""

import numpy as np
import pytest

from calibsolver import CalibrationError, View, fit
from tests.helpers.data import corner_views


def test_summary_names_every_figure() -> None:
    views, size = corner_views("opencv_left")
    calibration = fit(views, size)
    fx = calibration.camera.intrinsics[0]
    assert f"fx={fx:.2f}" in repr(calibration)
    rows = dict(row.split("  ", 1) for row in calibration.summary().splitlines())
    assert list(rows) == [
        *["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"],
        "camera",
        "views",
        "corners",
        "rms",
        "uncertainty",
    ]
    value, sigma = map(float, rows["fx"].split(" ± "))
    assert value == pytest.approx(fx, abs=0.006)
    assert sigma == pytest.approx(np.sqrt(calibration.covariance[0, 0]), abs=0.006)
    assert calibration._repr_html_().count("<tr>") == len(rows)


def test_summary_counts_views_left_out() -> None:
    views, size = corner_views("opencv_left")
    row = View(views[0].object_points[:6], views[0].image_points[:6])
    calibration = fit([*views, row], size)
    assert f"{len(views)} of {len(views) + 1}; left out: 1 degenerate" in calibration.summary()


def test_points_outside_the_image_are_refused_by_view() -> None:
    views, (w, h) = corner_views("opencv_left")
    with pytest.raises(CalibrationError, match=r"view 0 has points outside the image of 320 x 240 px") as why:
        fit(views, (w // 2, h // 2))
    assert why.value.code == "outside_image"
    shifted = views[2].image_points + np.array([w - views[2].image_points[:, 0].max() + 3.0, 0.0])
    fit([*views[:2], View(views[2].object_points, shifted), *views[3:]], (w, h))  # by a detector's error
