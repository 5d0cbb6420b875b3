"""The operator's files: a dump that anyone may have, a stack made of it, and guesses from elsewhere."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pyarrow import parquet

from calibdb.camera_key import camera_key
from calibdb.schema import DISTORTION_MODELS, VoteDocument
from calibsolver import models
from calibsolver.models.rectilinear import Rectilinear
from infra.ops.__main__ import main
from infra.server.server import Server
from tests.helpers.service import published
from tests.helpers.service.client import CAMERA, Client
from tests.helpers.service.published import calibration

LABEL = "Anna's iPhone Camera"
PLATFORM = "iPhone; CPU iPhone OS 17_1 like Mac OS X"


@pytest.fixture(scope="module")
def data_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A stack in which one camera is reliably known, and a phone with a name on it once."""
    folder = tmp_path_factory.mktemp("files") / "data"
    with Server(folder) as stack:
        phone, key = calibration("Phone", 7), camera_key(LABEL, PLATFORM)
        named = {"camera": LABEL, "platform": PLATFORM, "camera_key": key}
        phone = phone.model_copy(update=named | {"id": phone.id.replace(phone.camera_key, key)})
        given = (phone, *(calibration(str(CAMERA["camera"]), n) for n in range(5)))
        consented = [one.model_copy(update={"licence": "CC0-1.0"}) for one in given]
        published.publish(stack, *consented, models=())
        assert Client(stack).lookup().status == 200
    return folder


@pytest.fixture
def dumped(data_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("DATA_DIR", str(data_dir))
    assert main(["dump", str(tmp_path / "dump")]) == 0
    return tmp_path / "dump"


def lines(path: Path) -> Iterator[dict[str, Any]]:
    for line in path.read_text().splitlines():
        yield json.loads(line)


def lookups(stack: Server) -> list[Any]:
    """Answers to all sorts of requests, to the byte where something is known.

    The address of the guidance page, which every miss names, is each stack's own.
    """
    client = Client(stack)
    asked: list[dict[str, Any]] = [{"distortion_model": model} for model in DISTORTION_MODELS]
    asked += [{"img_size": [640, 360]}, {"img_size": [640, 480]}, {"zoom": 2}, {"camera": "Other"}]
    asked += [{"camera": LABEL, "platform": PLATFORM}]
    answers = [client.lookup(**what, redirect=False) for what in asked]
    cameras = client.call("GET", "/v1/cameras", token=client.api_token)
    answers += [cameras]
    for known in cameras.json["cameras"]:
        answers.append(client.call("GET", f"/v1/cameras/{known['key']}", token=client.api_token))
        asked = [
            {"camera": known["camera"], "platform": known["platform"], "img_size": size["img_size"]}
            for size in known["sizes"]
        ]
        answers += [client.lookup(**what, redirect=False) for what in asked]
    return [(a.status, a.body if a.status == 200 else without_guidance(a.json)) for a in answers]


def without_guidance(answer: dict[str, Any]) -> dict[str, Any]:
    kind = answer["type"].rpartition("#")[2]  # its address is that of the stack
    return {k: v for k, v in answer.items() if k != "guidance_url"} | {"type": kind}


def test_loaded_dump_answers_alike(
    data_dir: Path,
    dumped: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    with Server(data_dir) as stack:
        expected = lookups(stack)
    assert [status for status, _ in expected[:2]] == [200, 200]  # rectilinear and fisheye
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "elsewhere"))
    for _ in range(2):  # the second time changes nothing
        assert main(["load", str(dumped)]) == 0
        assert "6 calibrations and 0 votes stored" in capsys.readouterr().out
        with Server(tmp_path / "elsewhere") as stack:
            assert lookups(stack) == expected


def test_a_dump_names_nobody(data_dir: Path, dumped: Path, tmp_path: Path) -> None:
    with Server(data_dir) as stack:
        store = published.store(stack)
        known = {document.contributor for document in store.calibrations.all()}
    documents = list(lines(dumped / "calibrations.jsonl"))
    everything = b"".join(path.read_bytes() for path in dumped.iterdir())
    assert {len(d["contributor"]) for d in documents} == {64}
    for secret in (*known, "Anna", "127.0.0.1", "cdb_"):
        assert secret.encode() not in everything
    assert main(["dump", str(tmp_path / "again")]) == 0
    again = list(lines(tmp_path / "again" / "calibrations.jsonl"))
    assert [d["id"] for d in documents] == [d["id"] for d in again]
    assert {d["contributor"] for d in documents}.isdisjoint({d["contributor"] for d in again})
    assert len({d["contributor"] for d in documents}) == len(known)  # and yet they can be told apart


def test_dumped_labels_follow_the_current_rules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "data"))
    label, platform = "Anna's webcam Z77 +49 170 1234567", "Linux; Anna Schmidt"
    named = {"camera": label, "platform": platform, "licence": "CC0-1.0"}
    stored = calibration("webcam Z77", 0).model_copy(update=named)
    vote = VoteDocument(**stored.model_dump(exclude={"layout", "fits", "time"}), noise=0.1, time=0)
    with Server(tmp_path / "data") as stack:
        store = published.store(stack)
        store.calibrations.publish(stored)
        store.votes.cast(vote)
    assert main(["dump", str(tmp_path / "dump")]) == 0
    everything = b"".join(path.read_bytes() for path in (tmp_path / "dump").iterdir())
    dumped = [one for name in ("calibrations", "votes") for one in lines(tmp_path / "dump" / f"{name}.jsonl")]
    assert [(one["camera"], one["platform"]) for one in dumped] == [("webcam Z77", "Linux")] * 2
    assert not [personal for personal in (b"Anna", b"Schmidt", b"170 1234567") if personal in everything]


def test_a_dump_is_a_table_of_everything(dumped: Path) -> None:
    documents = {d["id"]: d for d in lines(dumped / "calibrations.jsonl")}
    rows = parquet.read_table(dumped / "calibrations.parquet").to_pylist()
    assert len(rows) == len(documents) == 6
    for row in rows:
        fit = documents[row["id"]]["fits"]["rectilinear"]
        assert (row["fx"], row["cy"]) == (fit["camera_matrix"][0][0], fit["camera_matrix"][1][2])
        assert row["distortion_coefficients"] == fit["distortion_coefficients"]
        assert row["time"].timestamp() == documents[row["id"]]["time"]
    corners = parquet.read_table(dumped / "keypoints.parquet").to_pylist()
    expected = [
        (d["id"], view["index"], corner, *point)
        for d in documents.values()
        for view in d["views"]
        for corner, point in zip(view["ids"], view["points"], strict=True)
    ]
    assert [tuple(corner.values()) for corner in corners] == expected
    assert "CC0 1.0" in (dumped / "README.txt").read_text()


def test_a_dump_is_never_written_over_another(dumped: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dump", str(dumped)]) == 1
    assert "is there already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("not JSON\n", "line 7: the line: Invalid JSON"),
        ('{"layout": 2}\n', "line 7: layout"),
    ],
)
def test_a_broken_dump_is_not_taken_in_by_half(
    dumped: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    line: str,
    said: str,
) -> None:
    with (dumped / "calibrations.jsonl").open("a") as file:
        file.write(line)
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "elsewhere"))
    assert main(["load", str(dumped)]) == 1
    assert said in capsys.readouterr().err
    assert main(["camera", "list"]) == 0
    assert capsys.readouterr().out == ""


def test_only_a_dump_is_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "elsewhere"))
    assert main(["load", str(tmp_path)]) == 1
    assert "not the folder of a dump" in capsys.readouterr().err


def seed(path: Path, *options: str) -> int:
    names = ("--camera", "{brand} {model} {lens}", "--platform", "photograph", "--model", "fisheye")
    return main(["seed", str(path), *names, *options])


def test_contradictory_rows_seed_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "data"))
    rows = [
        "brand,model,lens,w,h,fx,fy,cx,cy,k1,k2,k3,k4",
        "A,One camera,,1280,720,900,900,640,360,0,0,0,0",
        "A,One camera,,1280,720,930,930,640,360,0,0,0,0",
        "A,One camera,,1280,720,910,910,640,360,0,0,0,0",
        "A,Two lenses,,1280,720,900,900,640,360,0,0,0,0",
        "A,Two lenses,,1280,720,1400,1400,640,360,0,0,0,0",
        "A,No camera,,1280,720,-900,900,640,360,0,0,0,0",
        "A,No camera,,1280,720,900,900,6400,360,0,0,0,0",
        "A,No camera,,1,720,900,900,0.5,360,0,0,0,0",
        "A,No number,,1280,720,nan,900,640,360,0,0,0,0",
    ]
    file = tmp_path / "rows.csv"
    file.write_text("\n".join(rows))
    assert seed(file) == 0
    said = capsys.readouterr().out
    assert "9 rows: 1 first guesses for 1 cameras" in said
    assert "2 skipped: several lenses or modes under one name" in said
    assert "3 skipped: no camera is like that" in said
    assert "1 skipped: a number is missing" in said
    with Server(tmp_path / "data") as stack:
        store = published.store(stack)
        key = camera_key("A One camera", "photograph")
        fit = store.priors.find(key, (1280, 720), 0, "fisheye")
        assert fit is not None
        assert fit.camera_matrix[0][0] == 910
        client = Client(stack)
        asked = {"camera": "A One camera", "platform": "photograph", "distortion_model": "fisheye"}
        assert client.lookup(**asked, redirect=False).json["reason"] == "unknown_camera", (
            "a guess does not count as an answer"
        )
        assert client.call("GET", "/v1/cameras", token=client.api_token).json["cameras"] == []
    assert main(["reindex"]) == 0
    capsys.readouterr()
    with Server(tmp_path / "data") as stack:
        assert published.store(stack).priors.find(key, (1280, 720), 0, "fisheye") == fit
    for arguments, complaint in (
        (["seed", str(file)], "'{camera}' cannot be made of the columns"),
        (["seed", str(file), "--camera", "{brand}", "--platform", "p"], "no column p1, which rectilinear"),
        (["seed", str(tmp_path / "none.csv")], "No such file"),
    ):
        assert main(arguments) == 1
        assert complaint in capsys.readouterr().err


def test_fits_of_one_lens_with_other_xi_seed_one_camera(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """At the axis both have 800 px per radian."""
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "data"))
    file = tmp_path / "omni.csv"
    file.write_text(
        "brand,model,lens,w,h,fx,fy,cx,cy,xi,k1,k2,p1,p2\n"
        "A,One camera,,1280,960,800,800,640,480,0,0,0,0,0\n"
        "A,One camera,,1280,960,1600,1600,640,480,1,0,0,0,0\n"
    )
    assert (
        main(
            [
                "seed",
                str(file),
                "--camera",
                "{brand} {model}",
                "--platform",
                "p",
                "--model",
                "omnidirectional",
            ]
        )
        == 0
    )
    assert "2 rows: 1 first guesses for 1 cameras" in capsys.readouterr().out


def test_bundle_reports_bytes_per_camera(
    data_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("DATA_DIR", str(data_dir))
    file = tmp_path / "new/cameras.json"
    assert main(["bundle", str(file), "--most", "1"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r" +\d+ bytes  Test camera \(c4-[\w-]+\)", said[0]), said
    data = json.loads(file.read_text())
    assert (data["format"], data["version"]) == ("calibdb-bundle", 1)
    # So many cameras may be called that: it is the one that was calibrated on this system.
    assert (data["labels"], data["places"]) == ({}, {"linux": {"Test camera": 0}})
    [camera] = data["cameras"]
    assert camera["camera"] == "Test camera"
    assert said[-1].startswith(f"1 cameras, {len(camera['rows'])} calibrations, 1 labels written to {file}")
    rows = {
        row["distortion_model"]: row
        for row in (dict(zip(data["columns"], r, strict=True)) for r in camera["rows"])
    }
    assert (rows["rectilinear"]["img_size"], rows["rectilinear"]["calibrations"]) == ([1280, 720], 5)
    for most in ("0", "-1", "many"):
        with pytest.raises(SystemExit):
            main(["bundle", str(file), f"--most={most}"])
    assert json.loads(file.read_text()) == data


def test_new_model_can_be_seeded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The columns of a model are its own; the schema's list of models is the one thing that must follow."""

    class Division(Rectilinear):
        name = "division"
        coefficients = ("lambda",)

    monkeypatch.setitem(models.REGISTRY, "division", Division())
    file = tmp_path / "some.csv"
    file.write_text("camera,platform,w,h,fx,fy,cx,cy,k1\nA camera,Linux,640,480,500,500,320,240,0\n")
    assert main(["seed", str(file), "--model", "division"]) == 1
    assert "there is no column lambda, which division needs" in capsys.readouterr().err
