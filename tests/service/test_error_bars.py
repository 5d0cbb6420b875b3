"""Error bars with what is systematic, wherever they are used: state, report, exports, checks, relations.

Simulated: a hand moves the board while the rows are read out, so that errors are several times those of white
noise.
"""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from calibsolver import Board, View, fit
from calibsolver.arrays import symmetric_inverse
from calibsolver.quality.rivals import with_rivals
from tests.helpers.service.client import Client
from tests.helpers.solver import hands, populations, synthetic

JOBS = False
LENS = synthetic.rectilinear_cameras()[5]
VIEWS = populations.views(LENS, np.random.default_rng(0), hand=hands.MOVING)


def sent(view: View) -> dict[str, Any]:
    column, row = (view.object_points[:, :2].round().astype(int) - 1).T
    return {
        "ids": (row * (Board().squares[0] - 1) + column).tolist(),
        "points": view.image_points.tolist(),
    }


def test_state_report_and_exports_have_the_error_bars(client: Client) -> None:
    fitted = fit(VIEWS, LENS.img_size)
    white = replace(fitted, covariance=symmetric_inverse(fitted.information), inflation=1.0)
    assert fitted.uncertainty().rms > 2 * white.uncertainty().rms, "or nothing below could fail"
    client.open(camera="Camera in a moving hand", img_size=list(LENS.img_size), capture="recorded")
    views = [sent(view) for view in VIEWS]
    assert client.call("POST", "/v1/session/batch", {"index": 0, "views": views}).status == 200
    state = client.finish().json
    assert state["uncertainty"]["rms"] == pytest.approx(fitted.uncertainty().rms, rel=1e-3)
    expected = with_rivals(fitted, VIEWS).uncertainty()
    assert state["calibration"]["uncertainty"]["max"] == pytest.approx(expected.max, rel=1e-3)
    assert state["systematic"] == pytest.approx(fitted.inflation, rel=1e-3)
    assert state["advice"][0]["code"] == "motion"
    stored = client.calibration(state["calibration_id"]).json
    report = stored["report"]
    assert report["systematic"]["cause"] == "motion"
    assert report["std"]["fx"] == pytest.approx(np.sqrt(fitted.covariance[0, 0]), rel=0.01)
    assert stored["uncertainty"]["rms"] == pytest.approx(expected.rms, rel=1e-3)
    written = client.calibration(state["calibration_id"], query="format=mrcal").body.decode()
    error = re.search(r"# expected error over 1280 x 720 px: ([\d.]+) px rms", written)
    assert float(error[1]) == pytest.approx(expected.rms, rel=0.01)
    factor = re.search(r"# mrcal .* multiply its uncertainty by ([\d.]+)", written)
    assert float(factor[1]) == pytest.approx(np.sqrt(fitted.inflation), rel=0.05)
