"""The operator's command line: tokens, and an index that follows from the bucket alone."""

import gzip
import json
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from calibdb.store.aliases import Alias
from infra.ops.__main__ import main
from infra.server.server import Server
from tests.helpers.marks import thorough
from tests.helpers.service.client import BRIEF, Client, Truth
from tests.helpers.service.index_items import items, remove
from tests.helpers.service.published import calibration, publish, store


@pytest.fixture(scope="module")
def data_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A stack's folder in which a camera was calibrated twice."""
    folder = tmp_path_factory.mktemp("ops") / "data"
    with Server(folder) as stack:
        for seed in (0, 3):
            Truth(seed=seed).calibrate(Client(stack), **BRIEF)
    return folder


@pytest.fixture(autouse=True)
def on_it(data_dir: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DATA_DIR", str(data_dir))


def test_lookups_at_the_edge_are_counted_by_camera(
    data_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alias = Alias("HD Pro Webcam C920 (046d:082d)", "Linux")
    with Server(data_dir) as stack:
        assert store(stack).aliases.record(alias, "c4-a", "source", int(time.time()))
    paths = [f"/known/v1/{alias.digest}/1280x720/0/rectilinear.json"] * 3
    paths += [f"/known/v1/{'0' * 32}/640x480/0/fisheye.json", "/calibrate/"]
    with gzip.open(tmp_path / "one.gz", "wt") as log:
        log.writelines(json.dumps({"cs-uri-stem": path, "sc-status": "200"}) + "\n" for path in paths)
    assert main(["camera", "use", str(tmp_path)]) == 0
    assert capsys.readouterr().out.split() == ["3", *alias.label.split(), "1", "unknown"]
    (tmp_path / "two.gz").write_bytes(b"no log")
    assert main(["camera", "use", str(tmp_path)]) == 1
    assert "two.gz" in capsys.readouterr().err
    assert main(["camera", "use", str(tmp_path / "elsewhere")]) == 1
    assert "EdgeLogBucket" in capsys.readouterr().err


@pytest.fixture
def stack(data_dir: Path) -> Iterator[Server]:
    with Server(data_dir) as running:
        yield running


def test_a_token_is_issued_listed_and_revoked(data_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["token", "create", "--origin", "https://page.example", "--plan", "page"]) == 0
    token = capsys.readouterr().out.strip()
    assert re.fullmatch(r"cdb_[0-9a-f]{16}_[0-9a-f]{48}", token)
    _, token_id, secret = token.split("_")
    assert main(["token", "list"]) == 0
    listed = capsys.readouterr().out
    assert (
        f"{token_id}  {time.strftime('%Y-%m-%d', time.gmtime())}  page  operator  https://page.example\n"
        in listed
    )
    assert secret not in listed
    with Server(data_dir) as stack:
        client = Client(stack)
        page, other = {"origin": "https://page.example"}, {"origin": "https://other.example"}
        assert client.call("POST", "/v1/auth", token=token, headers=page).status == 201
        assert client.call("POST", "/v1/auth", token=token, headers=other).status == 403
    assert main(["token", "revoke", token_id]) == 0
    with Server(data_dir) as stack:
        assert Client(stack).call("POST", "/v1/auth", token=token, headers=page).status == 403


@pytest.mark.parametrize("origin", ["page.example", "https://page.example/"])
def test_malformed_origins_are_refused(origin: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["token", "create", "--origin", origin]) == 1
    answer = capsys.readouterr()
    assert origin in answer.err
    assert answer.out == ""


def test_an_unknown_token_cannot_be_revoked(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["token", "revoke", "nobody"]) == 1
    assert "no token nobody" in capsys.readouterr().err


def objects(stack: Server, prefix: str = "") -> list[str]:
    return list(stack.storage.objects.names(prefix))


def test_reindex_publishes_after_a_crash(data_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with Server(data_dir) as stack:
        before = items(stack)
        lost = objects(stack, "calibrations/")[0]
        stack.storage.objects.delete([lost])
        for key in before:
            if lost.split("/")[2][:-5] in key[1] or key[1].startswith(("CONSENSUS#", "GROUPS#")):
                remove(stack, key)
    assert main(["reindex"]) == 0
    assert "2 calibrations indexed, 1 of them published only now" in capsys.readouterr().out
    with Server(data_dir) as stack:
        assert items(stack) == before


def test_reindex_removes_items_without_object(data_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with Server(data_dir) as stack:
        before = items(stack)
        files = stack.storage.objects
        kept = {
            name: files.get(name) or b""
            for name in (*objects(stack, "sessions/"), max(objects(stack, "calibrations/")))
        }
        newest = max(name for name in kept if name.startswith("calibrations/"))
        files.delete(list(kept))
    assert main(["reindex"]) == 0
    assert "1 calibrations indexed" in capsys.readouterr().out
    with Server(data_dir) as stack:
        after = items(stack)
        gone = {key for key in set(before) - set(after) if not key[0].startswith("SESSION#")}
        assert gone == {key for key in before if newest.split("/")[2][:-5] in key[1]}
        totals = {
            json.loads(str(item["document"]))["total"]
            for (_, sk), item in after.items()
            if sk.startswith("CONSENSUS#")
        }
        assert totals == {1}
        for name, content in kept.items():
            stack.storage.objects.put(name, content)
    assert main(["reindex"]) == 0
    with Server(data_dir) as stack:
        assert items(stack) == before


def test_a_token_gets_another_secret(data_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def said(*arguments: str) -> str:
        assert main(list(arguments)) == 0
        return capsys.readouterr().out.strip()

    def admitted(*tokens: str) -> list[bool]:
        with Server(data_dir) as stack:
            return [Client(stack).call("POST", "/v1/auth", token=t).status == 201 for t in tokens]

    first = said("token", "create")
    token_id = first.split("_")[1]
    second = said("token", "rotate", token_id)
    assert second.split("_")[1] == token_id
    assert admitted(first, second) == [True, True]
    third = said("token", "rotate", token_id, "--grace", "0")
    assert admitted(first, second, third) == [False, False, True]


def test_a_plan_must_be_known(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["token", "create", "--plan", "golden"]) == 1
    assert "there is no plan 'golden'; there are trial, free" in capsys.readouterr().err


def test_cameras_are_listed_and_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["camera", "list"]) == 0
    line = capsys.readouterr().out.strip()
    key = line.split()[0]
    assert line == f"{key}  2 calibrations"
    assert main(["camera", "list", "no such"]) == 0
    assert capsys.readouterr().out == ""
    assert main(["camera", "show", key]) == 0
    shown = capsys.readouterr().out
    assert "Test camera, " in shown
    assert "rectilinear: not reliable (too_few); 2 of 2 agree, 1 contributor, fx 9" in shown
    assert len(re.findall(rf"{key}-[0-9a-f]{{20}}  .* contributor [0-9a-f]{{12}}  rectilinear", shown)) == 2
    assert main(["camera", "show", "c1-none-000000000000"]) == 1
    assert "nothing is known of a camera" in capsys.readouterr().err


@pytest.mark.parametrize("asked_by", ["the earlier key", *thorough("today's key")])
def test_camera_includes_calibrations_of_earlier_keys(
    asked_by: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "data"))
    one, two = calibration("Renamed Z77", 0), calibration("Renamed Z77", 1)
    key = one.camera_key
    earlier = f"c1-{key[3:]}"
    old = one.model_copy(update={"camera_key": earlier, "id": one.id.replace(key, earlier)})
    with Server(tmp_path / "data") as stack:
        store(stack).calibrations.publish(old)
        publish(stack, two, models=())
    assert main(["camera", "show", key if asked_by == "today's key" else earlier]) == 0
    shown = capsys.readouterr().out
    assert "rectilinear: not reliable (too_few); 2 of 2 agree" in shown
    assert [shown.count(f"  {document.id}  ") for document in (old, two)] == [1, 1]
    assert shown.index(old.id) < shown.index(two.id)


def test_calibration_is_withdrawn_and_restored(data_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with Server(data_dir) as stack:
        before = items(stack)
        victim = objects(stack, "calibrations/")[1].split("/")[2][:-5]
    assert main(["calibration", "withdraw", victim, "--reason", "held in front of a mirror"]) == 0
    assert main(["calibration", "withdraw", victim]) == 0
    assert "withdrawn before" in capsys.readouterr().out
    assert [main(["calibration", "restore", victim]) for _ in range(2)] == [0, 1]
    with Server(data_dir) as stack:
        assert items(stack) == before
    for action in ("withdraw", "restore"):
        assert main(["calibration", action, "c1-none-000000000000-00000000000000000000"]) == 1


def test_closed_pipe_is_no_error(data_dir: Path) -> None:
    assert data_dir.exists()
    command = f"{sys.executable} -m infra.ops camera list | true"
    done = subprocess.run(["bash", "-o", "pipefail", "-c", command], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


def test_storage_elsewhere_must_be_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("CALIBDB_STORAGE", "aws")
    assert main(["token", "list"]) == 1
    assert "TABLE_NAME and BUCKET_NAME do not say where" in capsys.readouterr().err


def test_commands_work_while_the_server_runs(stack: Server, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["token", "create", "--plan", "free"]) == 0
    token = capsys.readouterr().out.strip()
    assert Client(stack).call("POST", "/v1/auth", token=token).status == 201
    assert main(["--data", str(stack.folder.path), "token", "list"]) == 0
    assert token.split("_")[1] in capsys.readouterr().out
