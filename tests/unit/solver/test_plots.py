"""Plots of a calibration of real photographs."""

import io

import numpy as np
import pytest

from calibsolver import plots
from tests.helpers.data import corner_views
from tests.helpers.marks import thorough
from tests.helpers.solver.computed_once import fit_once


@pytest.mark.parametrize(("name", "is_drawn"), [("opencv_left", False), *thorough(("jy_left", True))])
def test_report_draws_six_plots(name: str, is_drawn: bool) -> None:
    views, size = corner_views(name)
    calibration = fit_once(views, size)
    figure = plots.report(calibration, views, "A camera", np.zeros((size[1], size[0]), dtype=np.uint8))
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert len(titles) == 6
    assert titles[1] == f"Corners: {sum(map(len, views))} in {len(views)} views"
    if is_drawn:
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        content = io.BytesIO()
        FigureCanvasAgg(figure).print_png(content)
        assert len(content.getvalue()) > 30_000
