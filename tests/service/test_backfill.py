"""Backfills: every camera, every model; twice is once; and what the state machine does is the same."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from calibdb import schema
from infra.ops import backfill
from infra.server import jobs
from infra.server.server import Server
from tests.helpers.data import ROOT
from tests.helpers.service.commands import Operator
from tests.helpers.service.published import calibration, publish, store

DEFINITION = json.loads((ROOT / "infra/backfill.asl.json").read_text())
CAMERAS = ("Backfilled one", "Backfilled two")
MODELS = set(schema.DISTORTION_MODELS)
EVERYTHING = {(CAMERAS[0], 0.0): MODELS, (CAMERAS[1], 0.0): MODELS, (CAMERAS[1], 2.0): MODELS}


@pytest.fixture
def operator(tmp_path: Path) -> Operator:
    operator = Operator(tmp_path / "data")
    with Server(operator.folder) as stack:
        for camera in CAMERAS:
            documents = [calibration(camera, n) for n in range(2)]
            publish(stack, *documents)
        document = documents[-1]
        other_zoom = document.model_copy(update={"zoom": 2.0, "id": document.id[:-4] + "ffff"})
        store(stack).calibrations.publish(other_zoom)
    return operator


@pytest.fixture
def stack(operator: Operator) -> Iterator[Server]:
    with Server(operator.folder) as stack:
        yield stack


def known(stack: Server) -> dict[tuple[str, float], set[str]]:
    found = {}
    for camera in CAMERAS:
        for c in store(stack).consensuses.of(calibration(camera, 0).camera_key):
            found.setdefault((camera, c.zoom), set()).add(c.distortion_model)
    return found


def test_backfill_command_fills_the_table(operator: Operator) -> None:
    assert f"3 modes of cameras checked, {2 * 3 + 4} consensuses computed" in operator("backfill")
    with Server(operator.folder) as stack:
        assert known(stack) == EVERYTHING
    assert "3 modes of cameras checked, 0 consensuses computed" in operator("backfill")
    first, other = sorted(calibration(camera, 0).camera_key for camera in CAMERAS)
    continued = operator("backfill", "--after", first)
    assert first not in continued
    assert other in continued


def test_backfill_command_that_fails_for_one_mode_checks_the_others(
    operator: Operator, monkeypatch: pytest.MonkeyPatch
) -> None:
    counts = iter((None, 2, 1))
    monkeypatch.setattr(backfill, "_refit", lambda *_: next(counts))
    assert "the consensus of 1 modes could not be computed" in operator("backfill", status=1)
    assert "3 modes of cameras checked, 3 consensuses computed" in operator.printed


def test_state_machine_backfills_every_object(stack: Server) -> None:
    outer = DEFINITION["States"][DEFINITION["StartAt"]]
    assert outer["ItemReader"]["Resource"].endswith(":s3:listObjectsV2")
    prefix, size = outer["ItemReader"]["Parameters"]["Prefix"], outer["ItemBatcher"]["MaxItemsPerBatch"]
    child = outer["ItemProcessor"]["States"]
    first = child[outer["ItemProcessor"]["StartAt"]]
    second = child[first["Next"]]
    (refit,) = second["ItemProcessor"]["States"].values()
    for task, function in ((first, "${Backfill}"), (refit, "${Refit}")):
        assert task["Parameters"] == {"FunctionName": function, "Payload.$": "$"}
    assert first["ResultSelector"] == {"requests.$": "$.Payload.requests"}
    assert second["ItemsPath"] == "$.requests"
    items = [{"Key": name, "Size": 1000} for name in stack.storage.objects.names(prefix)]
    for start in range(0, len(items), size):
        for request in invoke("backfill", {"Items": items[start : start + size]})["requests"]:
            invoke("refit", request)
    assert known(stack) == EVERYTHING


def invoke(function: Any, payload: Any) -> Any:
    return json.loads(jobs.call(function, json.dumps(payload).encode(), jobs.Context()))


def test_backfill_skips_other_objects_and_follows_earlier_keys(stack: Server) -> None:
    old = calibration(CAMERAS[0], 0)
    earlier = f"c1-{old.camera_key[3:]}"
    renamed = old.model_copy(update={"camera_key": earlier, "id": earlier + old.id[-21:]})
    store(stack).calibrations.publish(renamed)
    names = [
        f"calibrations/{earlier}/{renamed.id}.json",
        f"calibrations/{earlier}/{renamed.id}.withdrawn.json",
        "calibrations/",
        "calibrations/x/y.json",
    ]
    found = invoke("backfill", {"Items": [{"Key": name} for name in names]})
    assert [r["camera"] for r in found["requests"]] == [old.camera_key]
    assert invoke("backfill", {"Items": []}) == {"requests": []}


MAX_PAYLOAD_BYTES = 256 * 1024  # of a state's input and output; AWS Step Functions developer guide, "Quotas"


def test_payloads_of_a_large_backfill_stay_within_the_limits() -> None:
    """The results of all children together are the map's output; so each child's are nothing."""
    machine = DEFINITION["States"]["EveryCalibration"]
    last = machine["ItemProcessor"]["States"]["EveryMode"]
    assert last["End"]
    assert last["ResultSelector"] == {}
    assert "ResultPath" not in last  # null would make the input, all requests, the output
    batch = machine["ItemBatcher"]
    assert batch["MaxInputBytesPerBatch"] < MAX_PAYLOAD_BYTES
    # What the function answers of a batch: at most a request for each of its calibrations.
    request = schema.RefitRequest(camera="c4-" + "k" * 60, img_size=(1920, 1080), zoom=1.25)
    answer = schema.BackfillAnswer(requests=(request,) * batch["MaxItemsPerBatch"])
    assert len(answer.model_dump_json()) < MAX_PAYLOAD_BYTES
