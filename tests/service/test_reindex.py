"""All that ever happened follows from the bucket: the table made anew, and a stack made of a dump."""

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from pyarrow import parquet

from calibdb import schema
from calibdb.access.tokens import ApiToken, secret_hash
from calibdb.camera_key import camera_key
from calibsolver.formats import write
from infra.ops import imports, tokens, withdrawal
from infra.ops.context import OpsContext
from infra.ops.dump import dump
from infra.ops.reindex import reindex
from infra.ops.restore import load
from infra.server.server import Server
from tests.helpers.service import published
from tests.helpers.service.client import BRIEF, EDGE, Client, Truth
from tests.helpers.service.index_items import Key, items, remove
from tests.helpers.service.known import fit
from tests.helpers.service.published import PLATFORM, asked, calibration, mode_of, store, views
from tests.helpers.service.strangers import context
from tests.helpers.solver.export_sources import subject

pytestmark = pytest.mark.thorough  # tests/service/test_reindex_at_random.py shows much of it in less

RULES = {
    "MIN_CALIBRATIONS": "3",
    "MIN_CONTRIBUTORS": "3",
    "CONTRIBUTOR_PERIOD": "86400",
    "EDGE_SECRETS": EDGE,
}
KNOWN = "HD Pro Webcam C920 (046d:082d)"


@dataclass(frozen=True)
class History:
    """Table before and after a reindexing from the bucket alone, and the public answers."""

    before: dict[Key, Any]
    anew: dict[Key, Any]
    answers: dict[str, Any]
    dumped: Path


@pytest.fixture(scope="module")
def history(tmp_path_factory: pytest.TempPathFactory) -> History:
    """A database to which everything has happened, where contributors are told apart."""
    folder = tmp_path_factory.mktemp("history")
    with Server(environment=RULES) as stack:
        operator = context(stack)
        calibrated(stack)
        checked(stack)
        captured(stack)
        withdrawn(operator)
        from_elsewhere(operator, folder)
        operator.store.tokens.create(ApiToken("page", secret_hash("secret"), ("https://a.example",), "free"))
        tokens.rotate(operator, "page", 24)
        tokens.revoke(operator, tokens.create(operator, (), "free").split("_")[1])
        before = items(stack)
        remove(stack, *before)
        assert items(stack) == {}
        assert reindex(operator).failed == 0
        anew = items(stack)
        dump(operator, folder / "dump", private=True)
        return History(before, anew, answers(stack), folder / "dump")


publish = partial(published.publish, models=schema.DISTORTION_MODELS)


def calibrated(stack: Server) -> None:
    """Reliably, once more under the name alone; members that disagree; a cropped stream; a key of old."""
    publish(stack, *(calibration(KNOWN, n) for n in range(4)))
    publish(stack, calibration(KNOWN.partition(" (")[0], 0))
    publish(
        stack, *(calibration("Zoom lens Z77", n, fx=f, fy=f) for n, f in enumerate((850.0, 950.0, 1050.0)))
    )
    cropped = calibration("Cropped Z77", 0)
    track = schema.Track(resizeMode="crop-and-scale")
    publish(stack, cropped.model_copy(update={"track": track}), calibration("Cropped Z77", 1))
    old = "c1-of-earlier-rules-0123456789ab"
    former = calibration("Of earlier rules Z77", 0)
    named = {"camera_key": old, "id": former.id.replace(former.camera_key, old)}
    publish(stack, former, former.model_copy(update=named))


def checked(stack: Server) -> None:
    """Votes for a calibration that they confirm, and against a consensus that they withdraw."""
    publish(stack, calibration("Confirmed Z77", 0), *(calibration("Doubted Z77", n) for n in range(3)))
    for n in range(3):
        for camera, fx in (("Confirmed Z77", 950.0), ("Doubted Z77", 700.0)):
            client = Client(stack, address=f"192.0.2.{n}")
            client.authenticate()
            seen = views(Truth(seed=50 + n, fx=fx, fy=fx - 2))
            assert client.check(seen, camera=camera, platform=PLATFORM).json["counted"]


def captured(stack: Server) -> None:
    """A capture that ended, one that is under way, one that was undone, one that was forgotten."""
    client = Client(stack, address="198.51.100.1")
    ended = Truth(seed=3).calibrate(client, camera="Captured Z77", zoom=1.5, **BRIEF)
    store(stack).refit.now(asked(mode_of(store(stack).calibrations.read([ended["calibration_id"]])[0])))
    for end in (None, "/v1/session/views/0", "/v1/session"):
        client.open(camera="Under way Z77")
        assert Truth().show(client).json["accepted"]
        assert end is None or client.call("DELETE", end).status in (200, 204)


def withdrawn(context: OpsContext) -> None:
    """One of two, the only one of a camera, and one that counts again."""
    of_two, alone, again = (calibration(f"Withdrawn {name} Z77", 0) for name in ("first", "alone", "awhile"))
    for document in (of_two, calibration(of_two.camera, 1), alone, again):
        context.store.calibrations.publish(document)
    for document in (of_two, alone, again):
        withdrawal.withdraw(context, document.id, "wrong")
    withdrawal.restore(context, again.id)
    context.store.calibrations.publish(alone)  # by a client that repeats its last view


def from_elsewhere(context: OpsContext, folder: Path) -> None:
    """A file with keypoints, one without, and a guess of the operator's."""
    reported = imports.ReportedCamera("Imported Z77 (1234:5678)", PLATFORM)
    known = subject("rectilinear")
    for name, kept in (("with", known), ("without", replace(known, views=(), board=None))):
        path = folder / f"{name}.json"
        path.write_bytes(write(kept, "photonvision").content)
        imports.import_file(context, path, reported, model="rectilinear")
    key = camera_key("Seeded Z77", PLATFORM)
    guess = {"camera": "Seeded Z77", "platform": PLATFORM, "zoom": 0.0, "source": "a test", "measured": 3}
    context.store.priors.keep(schema.PriorDocument(camera_key=key, fit=fit(), **guess))


def answers(stack: Server) -> dict[str, Any]:
    """Answers for every camera, without the address of the guidance page."""
    client = Client(stack)
    cameras = "Confirmed", "Doubted", "Zoom lens", "Cropped", "Captured", "Seeded", "Of earlier rules"
    labels = KNOWN, KNOWN.partition(" (")[0], "Imported Z77 (1234:5678)", *(f"{name} Z77" for name in cameras)
    found: dict[str, Any] = {}
    for label in (*labels, *(f"Withdrawn {name} Z77" for name in ("first", "alone", "awhile"))):
        for model, size in (("rectilinear", [1280, 720]), ("fisheye", [640, 360])):
            body = {"camera": label, "distortion_model": model, "img_size": size, "redirect": False}
            found[f"{label} {model}"] = client.lookup(**body).json
        path = f"/v1/cameras/{camera_key(label, PLATFORM)}"
        found[f"{label} members"] = client.call("GET", path, token=client.api_token).json
    found["search"] = client.call("GET", "/v1/cameras", token=client.api_token).json
    return json.loads(json.dumps(found).replace(stack.url, ""))


def test_the_table_is_the_same_byte_for_byte(history: History) -> None:
    """But for marks of forgotten sessions, of which the bucket holds nothing.

    That a table which is there stays, too, `test_reindex_at_random` shows.
    """
    kinds = Counter(sk.split("#")[0] if sk != "META" else pk.split("#")[0] for pk, sk in history.before)
    assert {"CALIBRATION", "CONSENSUS", "GROUPS", "CONSENSUS-OF", "VOTE", "PRIOR", "SESSION", "TOKEN"} <= set(
        kinds
    )
    assert (kinds["CALIBRATION"], kinds["VOTE"], kinds["SESSION"], kinds["TOKEN"]) == (
        22,
        6,
        4,
        3,
    )  # one revoked
    marks = {key for key, item in history.before.items() if "forgotten" in item}
    assert len(marks) == 1
    expected = {key: item for key, item in history.before.items() if key not in marks}
    assert history.anew == expected


def test_history_covers_every_kind_of_item(history: History) -> None:
    """Confirmed and withdrawn by votes, reliable, at odds: otherwise the rest proves little."""
    found = history.answers
    assert {found[f"{KNOWN} rectilinear"]["basis"], found["Confirmed Z77 rectilinear"]["basis"]} == {
        "consensus",
        "checked",
    }
    assert found[f"{KNOWN} fisheye"]["exact_size"] is False
    reasons = {label: answer.get("reason") for label, answer in found.items()}
    assert reasons["Doubted Z77 rectilinear"] == reasons["Zoom lens Z77 rectilinear"] == "disagree"
    assert reasons["Withdrawn alone Z77 rectilinear"] == "unknown_camera"
    assert reasons["Withdrawn awhile Z77 rectilinear"] == "too_few"


def test_loaded_dump_is_dumped_alike(history: History, tmp_path: Path) -> None:
    with Server(environment=RULES) as stack:
        operator = context(stack)
        assert load(operator, history.dumped) == (20, 6)
        assert answers(stack) == history.answers
        dump(operator, tmp_path / "again", private=True)
    for name in ("calibrations.jsonl", "votes.jsonl"):
        one, other = (list(unnamed(folder / name)) for folder in (history.dumped, tmp_path / "again"))
        assert one == other
    for name in ("calibrations.parquet", "keypoints.parquet"):
        tables = [parquet.read_table(folder / name) for folder in (history.dumped, tmp_path / "again")]
        one, other = (
            t.drop_columns(["contributor"]) if "contributor" in t.column_names else t for t in tables
        )
        assert one.equals(other)


def unnamed(path: Path) -> Iterator[dict[str, Any]]:
    """The lines without the names that contributors have in one dump only."""
    for line in path.read_text().splitlines():
        found = json.loads(line)
        yield {name: value for name, value in found.items() if name not in ("contributor", "source")}
