"""The operator's command line."""

import gzip
import json
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from calibdb.store.aliases import Alias
from infra.server.server import Server
from tests.helpers.service.client import BRIEF, Client, Truth
from tests.helpers.service.commands import Operator
from tests.helpers.service.index_items import Key, items, remove
from tests.helpers.service.published import calibration, publish, store, views


@pytest.fixture(scope="module")
def operator(tmp_path_factory: pytest.TempPathFactory) -> Operator:
    operator = Operator(tmp_path_factory.mktemp("ops") / "data")
    with Server(operator.folder) as stack:
        for seed in (0, 3):
            Truth(seed=seed).calibrate(Client(stack), **BRIEF)
        stack.wait_until_idle(60)
        assert Client(stack).check(views(Truth(seed=1))).json["counted"]
    return operator


def statuses(operator: Operator, *tokens: str, **headers: str) -> list[int]:
    with Server(operator.folder) as stack:
        client = Client(stack)
        return [client.call("POST", "/v1/auth", token=token, headers=headers).status for token in tokens]


def index(operator: Operator) -> dict[Key, Any]:
    with Server(operator.folder) as stack:
        return items(stack)


def test_lookups_at_the_edge_are_counted_by_camera(operator: Operator, tmp_path: Path) -> None:
    alias = Alias("HD Pro Webcam C920 (046d:082d)", "Linux")
    with Server(operator.folder) as stack:
        assert store(stack).aliases.record(alias, "c4-a", "source", int(time.time()))
    paths = [f"/known/v1/{alias.digest}/1280x720/0/rectilinear.json"] * 3
    paths += [f"/known/v1/{'0' * 32}/640x480/0/fisheye.json", "/calibrate/"]
    with gzip.open(tmp_path / "one.gz", "wt") as log:
        log.writelines(json.dumps({"cs-uri-stem": path, "sc-status": "200"}) + "\n" for path in paths)
    assert operator("camera", "use", tmp_path).split() == ["3", *alias.label.split(), "1", "unknown"]
    (tmp_path / "two.gz").write_bytes(b"no log")
    assert "two.gz" in operator("camera", "use", tmp_path, status=1)
    assert "EdgeLogBucket" in operator("camera", "use", tmp_path / "elsewhere", status=1)


def test_a_token_is_issued_listed_and_revoked(operator: Operator) -> None:
    page = "https://page.example"
    token = operator("token", "create", "--origin", page, "--plan", "page").strip()
    assert re.fullmatch(r"cdb_[0-9a-f]{16}_[0-9a-f]{48}", token)
    _, token_id, secret = token.split("_")
    listed = operator("token", "list")
    today = time.strftime("%Y-%m-%d", time.gmtime())
    assert f"{token_id}  {today}  page  operator  {page}\n" in listed
    assert secret not in listed
    assert statuses(operator, token, origin=page) == [201]
    assert statuses(operator, token, origin="https://other.example") == [403]
    operator("token", "revoke", token_id)
    assert statuses(operator, token, origin=page) == [403]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("create", "--origin", "page.example"), "page.example"),
        (("create", "--origin", "https://page.example/"), "https://page.example/"),
        (("create", "--plan", "golden"), "there is no plan 'golden'; there are trial, free"),
        (("revoke", "nobody"), "no token nobody"),
    ],
)
def test_wrong_arguments_of_tokens_are_refused(
    operator: Operator, arguments: tuple[str, ...], complaint: str
) -> None:
    assert complaint in operator("token", *arguments, status=1)


def objects(stack: Server, prefix: str) -> list[str]:
    return list(stack.storage.objects.names(prefix))


def test_reindex_publishes_after_a_crash(operator: Operator) -> None:
    with Server(operator.folder) as stack:
        before = items(stack)
        lost = objects(stack, "calibrations/")[0]
        stack.storage.objects.delete([lost])
        gone = (lost.split("/")[2][:-5], "CONSENSUS#", "GROUPS#")
        remove(stack, *(key for key in before if any(part in key[1] for part in gone)))
    assert "2 calibrations indexed, 1 of them published only now" in operator("reindex")
    assert index(operator) == before


def test_reindex_removes_items_without_object(operator: Operator) -> None:
    with Server(operator.folder) as stack:
        before = items(stack)
        files = stack.storage.objects
        newest = max(objects(stack, "calibrations/"))
        kept = {name: files.get(name) or b"" for name in (*objects(stack, "sessions/"), newest)}
        files.delete(list(kept))
    assert "1 calibrations indexed" in operator("reindex")
    with Server(operator.folder) as stack:
        after = items(stack)
        gone = {key for key in set(before) - set(after) if not key[0].startswith("SESSION#")}
        assert gone == {key for key in before if newest.split("/")[2][:-5] in key[1]}
        consensuses = [item["document"] for (_, sk), item in after.items() if sk.startswith("CONSENSUS#")]
        assert {json.loads(document)["total"] for document in consensuses} == {1}
        for name, content in kept.items():
            stack.storage.objects.put(name, content)
    operator("reindex")
    assert index(operator) == before


def test_a_token_gets_another_secret(operator: Operator) -> None:
    first = operator("token", "create").strip()
    token_id = first.split("_")[1]
    second = operator("token", "rotate", token_id).strip()
    assert second.split("_")[1] == token_id
    assert statuses(operator, first, second) == [201, 201]
    third = operator("token", "rotate", token_id, "--grace", "0").strip()
    assert statuses(operator, first, second, third) == [403, 403, 201]


def test_cameras_are_listed_and_shown(operator: Operator) -> None:
    line = operator("camera", "list").strip()
    key = line.split()[0]
    assert line == f"{key}  2 calibrations"
    assert operator("camera", "list", "no such") == ""
    shown = operator("camera", "show", key)
    assert "Test camera, " in shown
    assert "rectilinear: not reliable (too_few); 2 of 2 agree, 1 contributor, fx 9" in shown
    assert len(re.findall(rf"{key}-[0-9a-f]{{20}}  .* contributor [0-9a-f]{{12}}  rectilinear", shown)) == 2
    complaint = operator("camera", "show", "c1-none-000000000000", status=1)
    assert "nothing is known of a camera" in complaint


def test_camera_includes_calibrations_of_earlier_keys(tmp_path: Path) -> None:
    operator = Operator(tmp_path / "data")
    one, two = calibration("Renamed Z77", 0), calibration("Renamed Z77", 1)
    key = one.camera_key
    earlier = f"c1-{key[3:]}"
    old = one.model_copy(update={"camera_key": earlier, "id": one.id.replace(key, earlier)})
    with Server(operator.folder) as stack:
        store(stack).calibrations.publish(old)
        publish(stack, two, models=())
    shown = operator("camera", "show", earlier)
    assert "rectilinear: not reliable (too_few); 2 of 2 agree" in shown
    assert [shown.count(f"  {document.id}  ") for document in (old, two)] == [1, 1]
    assert shown.index(old.id) < shown.index(two.id)


def test_calibration_is_withdrawn_and_restored(operator: Operator) -> None:
    with Server(operator.folder) as stack:
        before = items(stack)
        victim = objects(stack, "calibrations/")[1].split("/")[2][:-5]
    operator("calibration", "withdraw", victim, "--reason", "held in front of a mirror")
    assert "withdrawn before" in operator("calibration", "withdraw", victim)
    with Server(operator.folder) as stack:
        withdrawn = items(stack)
        remove(stack, *withdrawn)
    operator("reindex")
    assert index(operator) == withdrawn
    assert operator("camera", "list").strip().endswith("2 calibrations, 1 withdrawn")
    assert f"would be restored: {victim}" in operator("calibration", "restore", victim, "--dry-run")
    assert index(operator) == withdrawn
    operator("calibration", "restore", victim)
    operator("calibration", "restore", victim, status=1)
    assert index(operator) == before
    for action in ("withdraw", "restore"):
        operator("calibration", action, "c1-none-000000000000-00000000000000000000", status=1)


def test_closed_pipe_is_no_error(operator: Operator) -> None:
    command = f"{sys.executable} -m infra.ops --data {operator.folder} camera list | true"
    done = subprocess.run(["bash", "-o", "pipefail", "-c", command], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


def test_storage_elsewhere_must_be_named(operator: Operator, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CALIBDB_STORAGE", "aws")
    assert "TABLE_NAME and BUCKET_NAME do not say where" in operator("token", "list", status=1)


def test_commands_work_while_the_server_runs(operator: Operator, tmp_path: Path) -> None:
    with Server(operator.folder) as stack:
        token = operator("token", "create", "--plan", "free").strip()
        assert Client(stack).call("POST", "/v1/auth", token=token).status == 201
        elsewhere = Operator(tmp_path)
        assert token.split("_")[1] in elsewhere("--data", operator.folder, "token", "list")
