"""Error bars with what is systematic, wherever they are used: state, report, exports, checks, relations.

Simulated: a hand moves the board while the rows are read out, so that errors are several times those of white
noise.
"""

import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from calibdb.compute.view_checks import examine
from calibdb.schema import CheckRequest
from calibsolver import Board, View, fit
from calibsolver import Calibration as Fitted
from calibsolver.arrays import symmetric_inverse
from calibsolver.quality.rivals import with_rivals
from tests.helpers.service.client import CAMERA, Client
from tests.helpers.solver import hands, populations, synthetic

JOBS = False
LENS = synthetic.rectilinear_cameras()[5]
VIEWS = populations.views(LENS, np.random.default_rng(0), hand=hands.MOVING)


def under_white_noise(calibration: Fitted) -> Fitted:
    return replace(calibration, covariance=symmetric_inverse(calibration.information), inflation=1.0)


def sent(view: View) -> dict[str, Any]:
    column, row = (view.object_points[:, :2].round().astype(int) - 1).T
    return {
        "ids": (row * (Board().squares[0] - 1) + column).tolist(),
        "points": view.image_points.tolist(),
    }


@pytest.fixture(scope="module")
def fitted() -> Fitted:
    calibration = fit(VIEWS, LENS.img_size)
    expected, white = calibration.uncertainty().rms, under_white_noise(calibration).uncertainty().rms
    assert expected > 2 * white, "or nothing below could fail"
    return calibration


def test_state_report_and_exports_have_the_error_bars(client: Client, fitted: Fitted) -> None:
    client.open(camera="Camera in a moving hand", img_size=list(LENS.img_size), capture="recorded")
    for index, view in enumerate(VIEWS):
        answer = client.call("POST", "/v1/session/views", {"index": index, **sent(view)}).json
        assert answer["accepted"]
    state = client.call("POST", "/v1/session/finish").json
    assert state["uncertainty"]["rms"] == pytest.approx(fitted.uncertainty().rms, rel=1e-3)
    expected = with_rivals(fitted, VIEWS).uncertainty()
    assert state["calibration"]["uncertainty"]["max"] == pytest.approx(expected.max, rel=1e-3)
    assert state["systematic"] == pytest.approx(fitted.inflation, rel=1e-3)
    assert state["advice"][0]["code"] == "motion"
    assert state["advice"][0]["text"].endswith("hold it still for longer.")
    path = f"/v1/calibrations/{state['calibration_id']}"
    stored = client.call("GET", path, token=client.api_token).json
    report = stored["report"]
    assert report["systematic"]["cause"] == "motion"
    assert "motion" in [reason["code"] for reason in report["verdict"]["reasons"]]
    drawn = np.array(report["error_map"]["px"], dtype=float)
    assert np.sqrt(np.mean(drawn**2)) == pytest.approx(expected.rms, rel=0.01)
    assert report["std"]["fx"] == pytest.approx(np.sqrt(fitted.covariance[0, 0]), rel=0.01)
    assert stored["uncertainty"]["rms"] == pytest.approx(expected.rms, rel=1e-3)
    for name in ("mrcal", "ros"):
        written = client.call("GET", path, token=client.api_token, query=f"format={name}").body.decode()
        number = re.search(r"# expected error over 1280 x 720 px: ([\d.]+) px rms", written)
        assert number is not None
        assert float(number[1]) == pytest.approx(expected.rms, rel=0.01)
        factor = re.search(r"# mrcal .* multiply its uncertainty by ([\d.]+)", written)
        assert (factor is not None) == (name == "mrcal")
        assert factor is None or float(factor[1]) == pytest.approx(np.sqrt(fitted.inflation), rel=0.05)


def test_check_takes_its_own_camera_for_no_more_certain_than_it_is() -> None:
    asked = {**CAMERA, "img_size": list(LENS.img_size), "views": [sent(view) for view in VIEWS[:5]]}
    own = examine(CheckRequest.model_validate_json(json.dumps(asked))).own
    few = fit(VIEWS[:5], LENS.img_size)
    assert own is not None
    assert own.uncertainty.rms == pytest.approx(few.uncertainty().rms, rel=1e-3)
    assert own.uncertainty.rms > 2 * under_white_noise(few).uncertainty().rms
