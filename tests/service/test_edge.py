"""Known cameras are answered by objects at the edge: which, how they are served, under which aliases."""

from collections.abc import Iterator

import httpx
import pytest

from calibdb.schema import DISTORTION_MODELS
from calibdb.settings import Settings
from infra.local import LocalStack
from infra.ops.context import OpsContext
from tests.helpers.service.client import EDGE
from tests.helpers.service.edge import Question, aliases, differences, objects, questions
from tests.helpers.service.histories import quick_solver
from tests.helpers.service.published import PLATFORM, asked, calibration, mode_of, store

LABEL = "Webcam Z77 (1111:0001)"
WINDOWS = "Windows NT 10.0; Win64; x64"
SIZE = (1280, 720)
SEEN = questions((LABEL,), (PLATFORM,))
PUBLIC = {
    "MIN_CALIBRATIONS": "3",
    "MIN_CONTRIBUTORS": "3",
    "CONTRIBUTOR_PERIOD": "86400",
    "EDGE_SECRETS": EDGE,
}
PRIVATE = {"MIN_CALIBRATIONS": "3"}


def publish(stack: LocalStack, label: str = LABEL, count: int = 3) -> None:
    documents = [calibration(label, n, views=3) for n in range(count)]
    for document in documents:
        store(stack).calibrations.publish(document)
    store(stack).refit.now(asked(mode_of(documents[0])))


@pytest.fixture(scope="module", params=[PRIVATE, PUBLIC], ids=["private", "public"])
def known(request: pytest.FixtureRequest) -> Iterator[LocalStack]:
    with quick_solver(), LocalStack(environment=request.param) as stack:
        publish(stack)
        yield stack


def context_of(stack: LocalStack) -> OpsContext:
    return OpsContext.of(stack.environment, secret_known=True, echo=lambda _: None)


def test_every_stored_model_has_an_object_for_everybody(known: LocalStack) -> None:
    assert set(objects(known)) >= set(SEEN)
    assert len(SEEN) == len(DISTORTION_MODELS)
    assert not [wrong for wrong in differences(known, SEEN) if "never asked" not in wrong]
    name = next(iter(SEEN))
    assert LABEL.split()[0].lower() not in name
    with known.serve() as url, httpx.Client(base_url=url, timeout=60) as client:
        # As a browser asks from another site, without permission asked first.
        found = client.get(f"/{name}", headers={"origin": "https://page.example", "cookie": "a=b"})
        assert (found.status_code, found.content) == (200, objects(known)[name])
        assert found.headers["cache-control"] == "public, max-age=60, s-maxage=300"
        assert found.headers["access-control-allow-origin"] == "*"
        assert found.headers["content-type"] == "application/json"
        assert not {"vary", "set-cookie"} & set(found.headers)
        again = client.get(f"/{name}", headers={"if-none-match": found.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
        for path in (f"/known/00/{'0' * 32}.json", "/known/", "/known/../config.json", f"/known/{LABEL}"):
            missing = client.get(path)
            assert missing.status_code == 404 or "known" not in str(missing.url.path)
            assert missing.headers["access-control-allow-origin"] == "*"
        assert client.post(f"/{name}").status_code == 405
        assert client.get("/config.json").json()["edge_answers"] == "on"


def test_an_alias_is_answered_once_enough_sources_asked_by_it(known: LocalStack) -> None:
    question = Question("WEBCAM Z77 (1111:0001)", WINDOWS, SIZE, "rectilinear")
    needed = Settings.from_environment(known.environment).thresholds.min_contributors
    for source in range(needed):
        assert question.object not in objects(known)
        for _ in range(2):  # twice the same one is one
            assert question.ask(known, address=f"192.0.2.{source}").status == 200
    assert objects(known)[question.object] == question.ask(known).body
    assert set(questions((question.label,), (question.platform,))) <= set(objects(known))


def test_names_of_persons_and_unknown_ids_have_no_alias(known: LocalStack) -> None:
    before = len(aliases(known))
    for label in ("Webcam Z77 (1111:0009)", "Anna's Webcam Z77 (1111:0001)", "Webcam Z78 (1111:0001)"):
        for source in range(3):
            Question(label, PLATFORM, SIZE, "rectilinear").ask(known, address=f"192.0.2.{source}")
    objects(known)
    assert len(aliases(known)) == before
