"""The licence of what a contributor gives."""

import json
from pathlib import Path
from typing import Any

from calibsolver import formats
from infra.server.server import Server
from tests.helpers.service.client import BRIEF, CAMERA, Client, Truth, until
from tests.helpers.service.commands import Operator
from tests.helpers.service.published import calibration, publish, store, views
from tests.helpers.solver.export_sources import subject

CONSENT = {"licence": "CC0-1.0", "licence_version": "2026-11-22"}


def lines(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_what_was_given_without_counts_and_stays_out_of_dumps(operator: Operator, tmp_path: Path) -> None:
    with Server(operator.folder) as stack:
        client = Client(stack)
        given = [Truth(seed=3).calibrate(client, **BRIEF, **CONSENT)["calibration_id"]]
        others = [calibration(str(CAMERA["camera"]), n) for n in range(4)]
        others[0] = others[0].model_copy(update=CONSENT)
        publish(stack, *others)
        given += [one.id for one in others]
        found = until(lambda: (a := client.lookup(redirect=False)).status == 200 and a)
        assert found.json["calibrations"] == 5, "they count alike"
        for seed, consent in ((7, CONSENT), (8, {})):
            checked = client.check(views(Truth(seed=seed)), **consent)
            assert checked.json["counted"], checked.body
    public = tmp_path / "dump"
    assert "2 calibrations and 1 votes" in operator("dump", public)
    calibrations, votes = lines(public / "calibrations.jsonl"), lines(public / "votes.jsonl")
    assert {one["id"] for one in calibrations} == set(given[:2])
    for one in (*calibrations, *votes):
        assert {name: one[name] for name in CONSENT} == CONSENT
    everything = b"".join(path.read_bytes() for path in public.iterdir())
    assert not [one for one in given[2:] if one.encode() in everything]
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
        assert [document.licence for document in store(stack).calibrations.all()] == ["CC0-1.0"]
