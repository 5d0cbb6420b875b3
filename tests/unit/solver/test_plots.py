"""Plots of a calibration of real photographs: residuals with signs, and a figure of all."""

import io

import numpy as np
import pytest

from calibsolver import fit, plots, rotation
from tests.helpers.data import corner_views
from tests.helpers.marks import thorough
from tests.helpers.solver.computed_once import fit_once


def test_residuals_have_the_lengths_and_signs_of_the_fit() -> None:
    views, size = corner_views("opencv_left")
    calibration = fit(views, size)
    vectors = np.concatenate(calibration.residuals)
    views = calibration.shaped(views)
    for view, pose, found in zip(views, calibration.poses, calibration.residuals, strict=True):
        seen = view.object_points @ rotation.matrix(pose[:3]).T + pose[3:]
        np.testing.assert_allclose(found, view.image_points - calibration.camera.project(seen), atol=1e-9)
    lengths = np.linalg.norm(vectors, axis=1)
    assert np.sqrt(np.mean(lengths**2)) == pytest.approx(calibration.avg_reprojection_error, rel=1e-6)
    used = np.concatenate(calibration.used)
    assert calibration.rms_inliers == pytest.approx(np.sqrt(np.mean(lengths[used] ** 2)), rel=1e-12)
    assert np.abs(vectors[used].mean(axis=0)).max() < 0.02, "least squares leave no shift"


@pytest.mark.parametrize("name", ["opencv_left", *thorough("jy_left")])
def test_report_draws_six_plots(name: str) -> None:
    views, size = corner_views(name)
    calibration = fit_once(views, size)
    figure = plots.report(calibration, views, "A camera", np.zeros((size[1], size[0]), dtype=np.uint8))
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert len(titles) == 6
    assert titles[1] == f"Corners: {sum(map(len, views))} in {len(views)} views"


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["opencv_left", "jy_left"])
def test_report_is_a_picture(name: str) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    views, size = corner_views(name)
    figure = plots.report(
        fit_once(views, size), views, "A camera", np.zeros((size[1], size[0]), dtype=np.uint8)
    )
    content = io.BytesIO()
    FigureCanvasAgg(figure).print_png(content)
    assert len(content.getvalue()) > 30_000


@pytest.mark.parametrize("name", ["opencv_left", "jy_left"])
def test_uncertainty_states_the_share_of_the_picture_with_rays(name: str) -> None:
    from matplotlib.figure import Figure

    calibration = fit_once(*corner_views(name))
    axes = Figure().add_subplot()
    plots.uncertainty(axes, calibration)
    covered = calibration.camera.domain().covered
    assert (covered < 0.9995) == (name == "jy_left")
    share = f", {100 * covered:.0f} % of the picture" if covered < 0.9995 else ""
    assert axes.get_title() == f"Uncertainty, px{share}"
