"""The licence of what a contributor gives: everything that operators give away holds to it."""

import json
from pathlib import Path
from typing import Any

import pytest

from calibdb.schema import VoteDocument
from calibsolver import formats
from infra.ops.__main__ import main
from infra.server.server import Server
from tests.helpers.service.client import BRIEF, CAMERA, Client, Truth, until
from tests.helpers.service.published import calibration, publish, store, views
from tests.helpers.solver.export_sources import subject

CONSENT = {"licence": "CC0-1.0", "licence_version": "2026-11-22"}


def lines(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_what_was_given_without_counts_and_stays_out_of_dumps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Five calibrations, two of them given; a check that was given, and one that was not."""
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "data"))
    with Server(tmp_path / "data") as stack:
        client = Client(stack)
        given = [Truth(seed=3).calibrate(client, **BRIEF, **CONSENT)["calibration_id"]]
        others = [calibration(str(CAMERA["camera"]), n) for n in range(4)]
        others[0] = others[0].model_copy(update=CONSENT)
        publish(stack, *others)
        given += [one.id for one in others]
        found = until(lambda: (a := client.lookup(redirect=False)).status == 200 and a)
        assert found.json["calibrations"] == 5, "they count alike"
        for seed, consent in ((7, CONSENT), (8, {})):
            client.authenticate()
            assert client.open(camera=f"opened {seed}").status == 201
            checked = client.check(views(Truth(seed=seed)), **consent)
            assert checked.json["counted"], checked.body
    assert main(["dump", str(tmp_path / "dump")]) == 0
    assert "2 calibrations and 1 votes" in capsys.readouterr().out
    calibrations = lines(tmp_path / "dump" / "calibrations.jsonl")
    assert {one["id"] for one in calibrations} == set(given[:2])
    votes = lines(tmp_path / "dump" / "votes.jsonl")
    for one in (*calibrations, *votes):
        assert {name: one[name] for name in CONSENT} == CONSENT
    assert VoteDocument.model_validate_json(json.dumps(votes[0])).consent == CONSENT
    assert main(["dump", str(tmp_path / "copy"), "--private"]) == 0
    assert "5 calibrations and 2 votes" in capsys.readouterr().out
    assert "NOT TO BE GIVEN AWAY" in (tmp_path / "copy" / "README.txt").read_text()
    everything = b"".join(path.read_bytes() for path in (tmp_path / "dump").iterdir())
    assert not [one for one in given[2:] if one.encode() in everything]


def test_import_says_its_licence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "data"))
    path = tmp_path / "corners.vnl"
    path.write_bytes(formats.write(subject("rectilinear"), "corners-vnl").content)
    told = ["import", str(path), "--squares", "9x6", "--img-size", "1280x720", "--model", "rectilinear"]
    told += ["--platform", "X11; Linux x86_64", "--camera"]
    assert main([*told, "Microsoft LifeCam HD-3000 (045e:0779)", "--licence", "MIT"]) == 1
    assert main([*told, "Microsoft LifeCam HD-3000 (045e:0779)", "--licence", "CC0-1.0"]) == 0
    assert main([*told, "HD Pro Webcam C920 (046d:082d)"]) == 0
    with Server(tmp_path / "data") as stack:
        given = {document.camera: document.licence for document in store(stack).calibrations.all()}
    assert [licence for _, licence in sorted(given.items())] == [None, "CC0-1.0"]
