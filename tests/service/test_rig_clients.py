"""A rig end to end."""

import cv2
import numpy as np
import pytest

from calibdb_client import Client, NotFoundError
from tests.helpers.node import run_module
from tests.helpers.service.client import TOKEN
from tests.helpers.service.rigs import RigTruth

JOBS = False
READ = """
import { LookupError, rig } from "./web/sdk/calibdb.js";
import { rectify } from "./web/sdk/stereo.js";

const [url, id, token] = process.argv.slice(1);
const options = { token, api: `${url}/v1`, retries: 0 };
const found = await rig(id, options);
const [left, right] = found.calibrations;
const refusals = [];
const note = (error) => refusals.push([error instanceof LookupError, error.status, error.message]);
await rig("0".repeat(32), options).catch(note);
await rig(id, { ...options, token: "cdb_wrong_token" }).catch(note);
const { R1, R2, P1, P2, Q } = rectify(left, right, found.pose(1));
console.log(JSON.stringify({
  record: found, pose: found.pose(1), pixel: left.project([0.1, 0, 1]), refusals, R1, R2, P1, P2, Q,
  eyes: found.views().map(({ eye }) => eye),
}));
"""


def test_sdk_reads_the_rig_that_was_captured_and_rectifies_it_as_its_file(
    finished_rig: RigTruth, url: str
) -> None:
    found = run_module(READ, url, finished_rig.rig_id, TOKEN)
    assert found["record"] == finished_rig.result().json
    assert found["eyes"] == ["left", "right"]
    assert [refusal[:2] for refusal in found["refusals"]] == [[True, 404], [True, 403]]
    assert "no rig" in found["refusals"][0][2]
    std = np.array(found["pose"]["std"])
    away = np.array([*found["pose"]["rvec"], *found["pose"]["tvec"]]) - finished_rig.motions[1].vector()
    assert (std > 0).all()
    assert np.abs(away / std).max() < 4, "as far from the truth as the error bars say"
    storage = cv2.FileStorage(
        finished_rig.result("opencv_stereo").body.decode(), cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY
    )
    for name in ("R1", "R2", "P1", "P2", "Q"):
        assert np.array(found[name]) == pytest.approx(storage.getNode(name).mat(), abs=1e-6), name


def test_python_client_reads_the_rig_and_a_file_of_it(finished_rig: RigTruth, url: str) -> None:
    with Client(url, TOKEN, cache=False) as client:
        found = client.rig(finished_rig.rig_id)
        assert found.record == finished_rig.result().json
        away = found.pose(1)[:3, 3] - finished_rig.motions[1].t
        assert np.abs(away / found.std(1)[3:]).max() < 4
        assert client.rig_file(finished_rig.rig_id, "kalibr").content == finished_rig.result("kalibr").body
        with pytest.raises(NotFoundError, match="no rig"):
            client.rig("0" * 32)
