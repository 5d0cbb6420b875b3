"""A rig from its first camera to its files, over HTTP."""

import io
import json
import re
import zipfile
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from typing import Any

import cv2
import numpy as np
import pytest

from calibdb_client import Client as PythonClient
from calibdb_client import NotFoundError
from calibsolver import rotation
from calibsolver.rig.start import RigidMotion
from infra.server.server import Server
from tests.helpers.node import run_module
from tests.helpers.service.client import CAMERA, TOKEN, Client
from tests.helpers.service.rigs import RigTruth

JOBS = False

MAX_MOMENTS = 10


def capture(rig: RigTruth, most: int = MAX_MOMENTS) -> Any:
    state = rig.state()
    for number in range(most):
        if state["progress"] == 1:
            return state
        assert {a.status for a in rig.moment(f"m{number}", rig.held(state)).values()} == {200}
        state = rig.state()
    raise AssertionError(f"not converged after {most} moments: {state['uncertainty']}")


@pytest.fixture(scope="module")
def finished(stack: Server) -> tuple[RigTruth, Any]:
    rig = RigTruth(stack, baseline=3.0, seed=1)
    rig.open(square_size=0.03)
    capture(rig)
    with pytest.MonkeyPatch.context() as patch:  # slow machines have the time, too
        patch.setattr(import_module("calibsolver.rig.estimate"), "MAX_HELD_OUT_S", 60.0)
        patch.setattr("calibdb.http.call.MAX_RIG_COMPUTE_S", 60.0)
        answer = rig.call("POST", "/finish")
    assert answer.status == 200, answer.body
    return rig, answer.json


def test_finished_rig_is_right_within_its_uncertainty(finished: tuple[RigTruth, Any]) -> None:
    rig, state = finished
    result = state["result"]
    assert (state["status"], state["progress"], result["unit"]) == ("finished", 1, "metres")
    assert result["verdict"] == {"level": "good", "reasons": []}
    assert result["uncertainty"]["rms"] <= state["target_error"] == pytest.approx(0.3)
    assert result["rms"] == pytest.approx(rig.noise * 2**0.5, rel=0.25)
    assert result["held_out_rms"] == pytest.approx(result["rms"], rel=0.5)
    first, second = result["extrinsics"]
    assert (first["rvec"], first["tvec"], first["std"]) == ([0] * 3, [0] * 3, [0] * 6)
    truth = rig.motions[1]
    turn = rotation.vector(rotation.matrix(np.array(second["rvec"])) @ truth.r.T)
    off = [*turn, *(np.array(second["tvec"]) - 0.03 * truth.t)]
    assert max(abs(np.array(off)) / second["std"]) < 4


def test_cameras_are_published_with_their_moments(finished: tuple[RigTruth, Any]) -> None:
    rig, state = finished
    objects = rig.stack.storage.objects
    names = {m["id"] for m in state["moments"]}
    for position, calibration in enumerate(state["result"]["cameras"]):
        key = rig.clients[0].calibration(calibration).json["camera_key"]
        stored = json.loads(objects.get(f"calibrations/{key}/{calibration}.json"))
        assert stored["rig"] == {"id": rig.rig_id, "position": position}
        assert {view["moment"] for view in stored["views"]} <= names
        session = rig.clients[position].state()
        assert (session["status"], session["calibration_id"]) == ("converged", calibration)


def test_finish_again_is_answered_again(finished: tuple[RigTruth, Any]) -> None:
    rig, state = finished
    assert rig.call("POST", "/finish").json == state
    assert rig.state(1) == state
    assert rig.call("GET", token=TOKEN).json == state
    assert rig.call("POST", "/moments", {"moment": "late"}).problem == (409, "rig-finished")


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
  record: found, pose: found.pose(1), refusals, R1, R2, P1, P2, Q,
  eyes: found.views().map(({ eye }) => eye),
}));
"""


def test_sdk_reads_the_rig_and_rectifies_it_as_its_file(finished: tuple[RigTruth, Any], url: str) -> None:
    rig, state = finished
    found = run_module(READ, url, rig.rig_id, TOKEN)
    assert found["record"] == state["result"]
    assert found["eyes"] == ["left", "right"]
    assert [refusal[:2] for refusal in found["refusals"]] == [[True, 404], [True, 403]]
    assert "no rig" in found["refusals"][0][2]
    for name in ("rvec", "tvec", "std"):
        assert found["pose"][name] == pytest.approx(state["result"]["extrinsics"][1][name])
    storage = cv2.FileStorage(
        rig.result("opencv_stereo").body.decode(), cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY
    )
    for name in ("R1", "R2", "P1", "P2", "Q"):
        assert np.array(found[name]) == pytest.approx(storage.getNode(name).mat(), abs=1e-6), name


def test_python_client_reads_the_rig_and_a_file_of_it(finished: tuple[RigTruth, Any], url: str) -> None:
    rig, state = finished
    with PythonClient(url, TOKEN, cache=False) as client:
        assert client.rig(rig.rig_id).record == state["result"]
        assert client.rig_file(rig.rig_id, "kalibr").content == rig.result("kalibr").body
        with pytest.raises(NotFoundError, match="no rig"):
            client.rig("0" * 32)


def test_result_is_a_file_or_an_archive_named_after_the_rig(finished: tuple[RigTruth, Any]) -> None:
    rig, state = finished
    assert rig.result("json").json == state["result"]
    archive, chain = rig.result("ros"), rig.result("kalibr")
    assert len(zipfile.ZipFile(io.BytesIO(archive.body)).namelist()) == 2
    assert b"T_cn_cnm1" in chain.body
    for answer, suffix in ((archive, ".zip"), (chain, ".yaml")):
        assert re.search(rf"{rig.rig_id}.*{suffix}", answer.headers["content-disposition"])


def test_unchanged_state_is_not_sent_again(stack: Server) -> None:
    rig = RigTruth(stack, seed=2).open()
    tag = {"if-none-match": rig.call("GET").headers["etag"]}
    assert [rig.call("GET", position=position, headers=tag).status for position in (0, 1)] == [304, 304]
    rig.moment("m0")
    assert rig.call("GET", headers=tag).status == 200


def test_pose_of_a_camera_is_the_target_of_its_rig(stack: Server) -> None:
    rig = RigTruth(stack, seed=3).open()
    (seen,) = rig.state()["target"]["cameras"]
    pose = rig.clients[0].pose()
    assert (pose.status, pose.json["corners"]) == (200, seen["corners"])
    picture = rig.clients[0].call("GET", "/v1/session/pose", headers={"accept": "image/jpeg"})
    assert picture.body.startswith(b"\xff\xd8")
    assert rig.clients[1].pose().problem == (409, "not-in-view")
    skipped = rig.call("GET", query="skip=1")
    assert skipped.json["target"]["cameras"] != [seen]
    assert rig.state() == skipped.json, "until it is skipped, too"


def test_view_of_an_older_moment_is_welcome(stack: Server) -> None:
    """A client that lost its network delivers what it took, in any order, and a replay changes nothing."""
    rig = RigTruth(stack, seed=3).open()
    kept = []
    for number in range(3):
        pose = rig.held()
        rig.moment(f"m{number}", pose, positions=[0])
        kept.append((f"m{number}", *rig.see(1, pose)))
    assert rig.state()["unlinked"] == [1]
    for moment, ids, points in reversed(kept):
        for _ in range(2):
            assert rig.view(1, moment, ids, points).json["accepted"]
    state = rig.state()
    assert state["unlinked"] == []
    assert [m["positions"] for m in state["moments"]] == [[0, 1]] * 3
    assert [camera["views"] for camera in state["cameras"]] == [3, 3]


def test_views_of_two_cameras_at_once_are_both_taken(stack: Server) -> None:
    rig = RigTruth(stack, seed=3).open()
    seen = [[], []]
    for n in range(3):
        assert rig.call("POST", "/moments", {"moment": f"m{n}"}).status == 201
        pose = rig.held()
        for position in (0, 1):
            seen[position].append((f"m{n}", *rig.see(position, pose)))
    with ThreadPoolExecutor(2) as pool:
        both = pool.map(lambda i: [rig.view(i, *view).status for view in seen[i]], (0, 1))
        assert list(both) == [[200] * 3] * 2
    assert [m["positions"] for m in rig.state()["moments"]] == [[0, 1]] * 3


def test_board_that_moved_between_two_pictures_is_set_aside_and_said(stack: Server) -> None:
    rig = RigTruth(stack, seed=3).open()
    for number in range(4):
        rig.moment(f"m{number}")
    pose = rig.held()
    rig.moment("moved", pose, positions=[0])
    rig.view(1, "moved", *rig.see(1, RigidMotion(pose.r, pose.t + 0.4)))
    state = rig.state()
    (moment,) = [m for m in state["moments"] if m["id"] == "moved"]
    assert {one["reason"] for one in moment["set_aside"]} == {"contradicts"}
    assert "contradicts" in {one["code"] for one in state["advice"]}


def test_state_tells_who_is_missing(stack: Server) -> None:
    rig = RigTruth(stack, count=3, seed=7).lead()
    joined = rig.join(1, code=rig.join_code.lower(), position=2)
    assert joined.json["rig"] == {"id": rig.rig_id, "position": 2}
    state = rig.state()
    assert [camera["status"] for camera in state["cameras"]] == ["capturing", "waiting", "capturing"]
    assert state["unlinked"] == [1, 2]
    assert state["advice"][0] == {"code": "waiting", "text": "Camera 1 has not joined yet.", "positions": [1]}
    assert rig.call("POST", "/finish").problem == (409, "unlinked")


def test_a_code_is_replaced_by_asking_again(stack: Server) -> None:
    client = Client(stack)
    client.open()
    made = [client.call("POST", "/v1/rigs", {"cameras": 4}).json for _ in range(9)]
    assert len({one["rig_id"] for one in made}) == 1
    assert len({one["join_code"] for one in made}) == 9
    assert client.state()["rig"] == {"id": made[0]["rig_id"], "position": 0}
    other = Client(stack)
    assert other.open(rig={"code": made[0]["join_code"]}).status == 422, "eight are good at a time"
    assert other.call("POST", "/v1/session", {**CAMERA, "rig": {"code": made[1]["join_code"]}}).status == 201
