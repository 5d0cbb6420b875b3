"""The operator's files."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pyarrow import parquet

from calibdb.camera_key import camera_key
from calibdb.schema import DISTORTION_MODELS
from calibsolver import formats
from infra.server.server import Server
from tests.helpers.service import published
from tests.helpers.service.client import CAMERA, Client, Truth
from tests.helpers.service.commands import Operator
from tests.helpers.service.published import calibration
from tests.helpers.solver.export_sources import subject

LABEL = "Anna's iPhone Camera"
PLATFORM = "iPhone; CPU iPhone OS 17_1 like Mac OS X"
LICENSED = {"licence": "CC0-1.0", "licence_version": "2026-11-22"}


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> Operator:
    operator = Operator(tmp_path_factory.mktemp("files") / "data")
    with Server(operator.folder) as stack:
        phone, key = calibration("Phone", 7), camera_key(LABEL, PLATFORM)
        named = {"camera": LABEL, "platform": PLATFORM, "camera_key": key}
        phone = phone.model_copy(update=named | {"id": phone.id.replace(phone.camera_key, key)})
        given = (phone, *(calibration(str(CAMERA["camera"]), n) for n in range(5)))
        published.publish(stack, *(one.model_copy(update=LICENSED) for one in given), models=())
        assert Client(stack).check(published.views(Truth(seed=9)), **LICENSED).json["counted"]
    return operator


@pytest.fixture
def dumped(known: Operator, tmp_path: Path) -> Path:
    known("dump", tmp_path / "dump")
    return tmp_path / "dump"


def lines(path: Path) -> Iterator[dict[str, Any]]:
    for line in path.read_text().splitlines():
        yield json.loads(line)


def content(folder: Path) -> bytes:
    return b"".join(path.read_bytes() for path in folder.iterdir())


def lookups(folder: Path) -> list[Any]:
    asked = [{"distortion_model": model} for model in DISTORTION_MODELS]
    asked += [{"img_size": [640, 360]}, {"img_size": [640, 480]}, {"zoom": 2}]
    asked += [{"camera": LABEL, "platform": PLATFORM}]
    with Server(folder) as stack:
        client = Client(stack)
        answers = [client.lookup(**what, redirect=False).json for what in asked]
        answers.append(client.call("GET", "/v1/cameras").json)
        answers.append({"votes": list(stack.storage.objects.names("votes/"))})
    return [{k: v for k, v in one.items() if k not in ("guidance_url", "type")} for one in answers]


def test_loaded_dump_answers_alike(known: Operator, dumped: Path, operator: Operator) -> None:
    expected = lookups(known.folder)
    assert all("camera_matrix" in answer for answer in expected[:2])  # rectilinear and fisheye
    for _ in range(2):  # the second time changes nothing
        assert "6 calibrations and 1 votes stored" in operator("load", dumped)
        assert lookups(operator.folder) == expected


def test_a_dump_names_nobody(known: Operator, dumped: Path, tmp_path: Path) -> None:
    with Server(known.folder) as stack:
        contributors = {document.contributor for document in published.store(stack).calibrations.all()}
    everything = content(dumped)
    for secret in (*contributors, "Anna", "127.0.0.1", "cdb_"):
        assert secret.encode() not in everything
    known("dump", tmp_path / "again")
    named, again = (
        {one["contributor"] for one in lines(folder / "calibrations.jsonl")}
        for folder in (dumped, tmp_path / "again")
    )
    assert named.isdisjoint(again)
    assert len(named) == len(contributors)  # and yet they can be told apart


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


def test_a_dump_is_never_written_over_another(known: Operator, dumped: Path) -> None:
    assert "is there already" in known("dump", dumped, status=1)


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("not JSON\n", "line 7: the line: Invalid JSON"),
        ('{"layout": 2}\n', "line 7: layout"),
    ],
)
def test_a_broken_dump_is_not_taken_in_by_half(
    dumped: Path, operator: Operator, line: str, complaint: str
) -> None:
    with (dumped / "calibrations.jsonl").open("a") as file:
        file.write(line)
    assert complaint in operator("load", dumped, status=1)
    assert operator("camera", "list") == ""
    assert "not the folder of a dump" in operator("load", dumped.parent, status=1)


def test_contradictory_rows_seed_nothing(operator: Operator, tmp_path: Path) -> None:
    file = tmp_path / "rows.csv"
    focals = [("One camera", "900"), ("One camera", "930"), ("One camera", "910")]
    focals += [("Two lenses", "900"), ("Two lenses", "1400"), ("No camera", "-900"), ("No number", "nan")]
    rows = [f"A,{model},,1280,720,{f},{f},640,360,0,0,0,0" for model, f in focals]
    rows += ["A,No camera,,1280,720,900,900,6400,360,0,0,0,0", "A,No camera,,1,720,900,900,0.5,360,0,0,0,0"]
    file.write_text("\n".join(["brand,model,lens,w,h,fx,fy,cx,cy,k1,k2,k3,k4", *rows]))
    names = ("--camera", "{brand} {model} {lens}", "--platform", "photograph", "--model", "fisheye")
    printed = operator("seed", file, *names)
    assert "9 rows: 1 first guesses for 1 cameras" in printed
    assert "2 skipped: several lenses or modes under one name" in printed
    assert "3 skipped: no camera is like that" in printed
    assert "1 skipped: a number is missing" in printed
    [counted] = operator.document("seed", file, *names, "--dry-run")
    assert (counted["rows"], sum(counted["skipped"].values())) == (9, 6)
    key = camera_key("A One camera", "photograph")
    with Server(operator.folder) as stack:
        fit = published.store(stack).priors.find(key, (1280, 720), 0, "fisheye")
        assert fit.camera_matrix[0][0] == 910
        asked = {"camera": "A One camera", "platform": "photograph", "distortion_model": "fisheye"}
        assert Client(stack).lookup(**asked).json["reason"] == "unknown_camera", "it is a guess"
    operator("reindex")
    with Server(operator.folder) as stack:
        assert published.store(stack).priors.find(key, (1280, 720), 0, "fisheye") == fit
    for arguments, complaint in (
        ((file,), "'{camera}' cannot be made of the columns"),
        ((file, "--camera", "{brand}", "--platform", "p"), "no column p1, which rectilinear"),
        ((tmp_path / "none.csv",), "No such file"),
    ):
        assert complaint in operator("seed", *arguments, status=1)


def test_fits_of_one_lens_with_other_xi_seed_one_camera(operator: Operator, tmp_path: Path) -> None:
    """At the axis both have 800 px per radian."""
    file = tmp_path / "omni.csv"
    file.write_text(
        "camera,w,h,fx,fy,cx,cy,xi,k1,k2,p1,p2\n"
        "One camera,1280,960,800,800,640,480,0,0,0,0,0\n"
        "One camera,1280,960,1600,1600,640,480,1,0,0,0,0\n"
    )
    printed = operator("seed", file, "--platform", "p", "--model", "omnidirectional")
    assert "2 rows: 1 first guesses for 1 cameras" in printed


def test_bundle_reports_bytes_per_camera(known: Operator, tmp_path: Path) -> None:
    file = tmp_path / "new/cameras.json"
    printed = known("bundle", file, "--most", "1").splitlines()
    assert re.fullmatch(r" +\d+ bytes  Test camera \(c4-[\w-]+\)", printed[0]), printed
    data = json.loads(file.read_text())
    assert (data["format"], data["version"]) == ("calibdb-bundle", 1)
    # So many cameras may be called that: it is the one that was calibrated on this system.
    assert (data["labels"], data["places"]) == ({}, {"linux": {"Test camera": 0}})
    [camera] = data["cameras"]
    assert camera["camera"] == "Test camera"
    written = f"1 cameras, {len(camera['rows'])} calibrations, 1 labels written to {file}"
    assert printed[-1].startswith(written)


def test_what_was_given_without_counts_and_stays_out_of_dumps(operator: Operator, tmp_path: Path) -> None:
    documents = [calibration(str(CAMERA["camera"]), n) for n in range(5)]
    documents[:2] = [one.model_copy(update=LICENSED) for one in documents[:2]]
    with Server(operator.folder) as stack:
        published.publish(stack, *documents)
        client = Client(stack)
        assert client.lookup(redirect=False).json["calibrations"] == 5, "they count alike"
        for seed, consent in ((7, LICENSED), (8, {})):
            assert client.check(published.views(Truth(seed=seed)), **consent).json["counted"]
    public = tmp_path / "dump"
    assert "2 calibrations and 1 votes" in operator("dump", public)
    calibrations, votes = list(lines(public / "calibrations.jsonl")), lines(public / "votes.jsonl")
    assert {one["id"] for one in calibrations} == {one.id for one in documents[:2]}
    for one in (*calibrations, *votes):
        assert {name: one[name] for name in LICENSED} == LICENSED
    everything = content(public)
    assert not [one for one in documents[2:] if one.id.encode() in everything]
    assert "5 calibrations and 2 votes" in operator("dump", tmp_path / "copy", "--private")
    assert "NOT TO BE GIVEN AWAY" in (tmp_path / "copy" / "README.txt").read_text()


def test_import_says_its_licence(operator: Operator, tmp_path: Path) -> None:
    path = tmp_path / "corners.vnl"
    path.write_bytes(formats.write(subject("rectilinear"), "corners-vnl").content)
    arguments = ["import", path, "--squares", "9x6", "--img-size", "1280x720", "--model", "rectilinear"]
    arguments += ["--platform", "Linux", "--camera", "Microsoft LifeCam HD-3000 (045e:0779)"]
    operator(*arguments, "--licence", "MIT", status=1)
    operator(*arguments, "--licence", "CC0-1.0")
    with Server(operator.folder) as stack:
        assert [document.licence for document in published.store(stack).calibrations.all()] == ["CC0-1.0"]
