"""Failures of linear algebra are answers about the views."""

import contextlib
from collections.abc import Callable

import numpy as np
import pytest

from calibsolver import Board, CalibrationError, consensus, fit, guidance, quality, rig
from calibsolver.capture import Capture
from calibsolver.fitting.resection import reprojection_score
from calibsolver.formats import ExportSource, write
from calibsolver.quality import report
from calibsolver.quality.systematic import probable_cause
from tests.helpers.solver import rigs, synthetic
from tests.helpers.solver.export_sources import captured

BOARD = Board((9, 6))
CAMERA = synthetic.rectilinear_cameras(1)[0]
SIZE = CAMERA.img_size
VIEWS = captured(CAMERA, BOARD, 6)
FITTED = fit(VIEWS, SIZE)
PAIR = rigs.side_by_side(synthetic.rectilinear_cameras(2), 1.0)
MOMENTS = rigs.moments(PAIR, BOARD, 5, 0.2, np.random.default_rng(0))
SPECIFICATIONS = [(camera.img_size, camera.model) for camera in PAIR.cameras]
RIG = rig.fit(MOMENTS, SPECIFICATIONS)
CAPTURE = Capture(BOARD, SIZE)
ESTIMATE = CAPTURE.estimate(VIEWS[:4])
TARGET = CAPTURE.next_target(VIEWS[:4], ESTIMATE)

ENTRIES: dict[str, Callable[[], object]] = {
    "fit": lambda: fit(VIEWS, SIZE),
    "least squares": lambda: fit(VIEWS, SIZE, robust=False),
    "resection": lambda: reprojection_score(CAMERA, VIEWS),
    "assess": lambda: quality.assess(FITTED, VIEWS),
    "held_out": lambda: quality.held_out(VIEWS, SIZE),
    "cause": lambda: probable_cause(FITTED, VIEWS),
    "report": lambda: report.describe(FITTED, VIEWS),
    "consensus": lambda: consensus.pool(
        [consensus.Member(str(i), VIEWS[:3], str(i), 0) for i in range(2)], SIZE, "rectilinear"
    ),
    "guidance": lambda: guidance.ProjectionUncertainty(BOARD, SIZE).next_pose(VIEWS, FITTED),
    "published guidance": lambda: guidance.PoseSelection(BOARD, SIZE).next_pose(VIEWS[:3], None),
    "judge": lambda: CAPTURE.judge(VIEWS[:4], TARGET, VIEWS[4]),
    "reconcile": lambda: CAPTURE.reconcile(VIEWS[:4], {}),
    "export": lambda: write(ExportSource(CAMERA, VIEWS, BOARD), "kalibr"),
    "rig": lambda: rig.fit(MOMENTS, SPECIFICATIONS),
    "rig guidance": lambda: rig.next_moment(BOARD, SPECIFICATIONS, MOMENTS, RIG),
}


@pytest.mark.parametrize("name", ["eigh", "svd", "qr", "inv", "lstsq"])
def test_no_failure_of_linear_algebra_leaves_the_solver(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object, **__: object) -> None:
        raise np.linalg.LinAlgError("did not converge")

    monkeypatch.setattr(np.linalg, name, fails)
    for call in ENTRIES.values():
        with contextlib.suppress(CalibrationError):
            call()
