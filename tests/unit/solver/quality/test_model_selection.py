"""Model choice on real lenses."""

import numpy as np
import pytest

from calibsolver import CalibrationError, View, models
from calibsolver.quality.cross_validation import HeldOut
from calibsolver.quality.model_selection import not_significantly_worse, suggest_model
from tests.helpers.data import available, corner_views
from tests.helpers.marks import thorough
from tests.helpers.solver import populations, synthetic

WIDE = {"fisheye", "rational", "omnidirectional"}
EXPECTED = {
    "opencv_left": {"rectilinear"},
    "pv_charuco_480": {"rectilinear"},
    "pv_charuco_1280": {"rectilinear"},
    "pv_picam_320": {"rectilinear"},
    "jy_left": WIDE,
    "derlunz": WIDE,
    "ocam_fisheye2": {"fisheye", "omnidirectional"},
    "babel_ov_plane": {"fisheye", "omnidirectional"},
}


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("opencv_left", slice(0, None, 2)),
        ("jy_left", slice(2, None, 4)),
        *thorough(*((name, slice(0, None, 2)) for name in available(EXPECTED))),
    ],
)
def test_suggested_model_of_real_lenses(name: str, part: slice) -> None:
    views, size = corner_views(name)
    choice = suggest_model(views[part], size)
    assert choice.model in EXPECTED[name]
    assert set(choice.held_out) == set(models.NAMES)
    least = min(error for error in choice.held_out.values() if error is not None)
    found = choice.held_out[choice.model]
    assert found is not None
    assert found < 1.1 * least
    assert choice.model in choice.reasons[0]
    assert len(choice.reasons) == len(models.NAMES)


def test_wild_corners_do_not_decide() -> None:
    camera = synthetic.fisheye_cameras()[2]
    rng = np.random.default_rng(1)
    views = []
    for view in populations.views(camera, rng, count=3):
        q = view.image_points.copy()
        q[rng.integers(len(q))] += 30
        views.append(View(view.object_points, q))
    choice = suggest_model(views, camera.img_size)
    assert choice.model in WIDE
    found = choice.held_out[choice.model]
    assert found is not None
    assert found < 0.4


def test_unfittable_views_raise_calibration_error() -> None:
    rng = np.random.default_rng(0)
    camera = synthetic.rectilinear_cameras()[4]
    views = [
        View(v.object_points[::4], rng.uniform(0, 700, v.image_points[::4].shape))
        for v in populations.views(camera, rng, count=1)
    ]
    with pytest.raises(CalibrationError):
        suggest_model(views, camera.img_size)


@pytest.mark.parametrize(("count", "critical"), [(5, 2.132), (10, 1.833), (21, 1.725)])
def test_models_are_compared_by_a_paired_t_test(count: int, critical: float) -> None:
    """Student's one-sided 5 % quantiles; one standard error more is still as good."""
    best = np.random.default_rng(count).uniform(0.2, 0.6, count)
    noise = np.random.default_rng(1).normal(size=count)
    noise = 0.3 * (noise - noise.mean()) / noise.std(ddof=1)
    for t, as_good in ((1.2, True), (critical - 0.06, True), (critical + 0.06, False)):
        errors = best * np.exp(noise + t * 0.3 / np.sqrt(count))
        one, other = (HeldOut(float(np.sqrt(np.mean(e**2))), e) for e in (errors, best))
        assert one.rms > 1.03 * other.rms
        assert not_significantly_worse(one, other) == as_good
