"""The Python client without a service: edge, cache, retries, errors; the same for its asynchronous twin."""

import asyncio
import inspect
import json
import os
import re
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest

from calibdb_client import (
    Answer,
    AsyncClient,
    Client,
    ConflictError,
    CredentialError,
    NotFoundError,
    ProblemError,
    QuotaError,
    ServiceUnavailableError,
    UsageError,
)
from calibdb_client.key import CameraKey
from tests.unit.client.test_calibration import RECORD

ROOT = Path(__file__).parents[3]
SITE = "https://calibdb.test"
KEY = CameraKey("HD Pro Webcam C920 (046d:082d)", "X11; Linux x86_64", (1280, 720))
TOKEN = "cdb_a_secret"

ROW = re.compile(r"^\| `(.+)` \| `(.+)` \| (\d+)x(\d+) \| ([\d.]+) \| (\w+) \| `/(known/.+)` \|$", re.M)
#: the vectors of docs/api.md
VECTORS = [
    (CameraKey(label, platform, (int(w), int(h)), float(zoom)), model, path)
    for label, platform, w, h, zoom, model, path in ROW.findall((ROOT / "docs" / "api.md").read_text())
]
assert len(VECTORS) == 3


class Service:
    """Answers by path, and what was asked."""

    def __init__(self, answer: Callable[[httpx.Request], httpx.Response]) -> None:
        self.answer = answer
        self.asked: list[httpx.Request] = []
        self.pauses: list[float] = []

    def __call__(self, request: httpx.Request) -> httpx.Response:
        self.asked.append(request)
        return self.answer(request)

    @property
    def paths(self) -> list[str]:
        return [f"{each.method} {each.url.path}" for each in self.asked]

    def client(self, token: str | None = TOKEN, cache: Path | bool = False) -> Client:
        return Client(SITE, token, transport=httpx.MockTransport(self), sleep=self.pauses.append, cache=cache)

    def lookup(self, twin: bool, cache: Path | bool = False) -> Answer:
        """Look `KEY` up with the client or with its twin."""
        if twin:
            return asyncio.run(self._lookup(cache))
        with self.client(cache=cache) as client:
            return client.lookup(KEY)

    async def _lookup(self, cache: Path | bool) -> Answer:
        async def sleep(seconds: float) -> None:
            self.pauses.append(seconds)

        network = httpx.MockTransport(self)
        async with AsyncClient(SITE, TOKEN, transport=network, sleep=sleep, cache=cache) as client:
            return await client.lookup(KEY)


def known(cache_control: str = "") -> Service:
    """Service whose edge knows the camera."""
    headers = {"cache-control": cache_control}
    return Service(lambda _: httpx.Response(200, json=RECORD, headers=headers))


both = pytest.mark.parametrize("twin", [False, True], ids=["sync", "async"])


def by_post(request: httpx.Request) -> httpx.Response:
    """Nothing at the edge; the service knows the camera."""
    return httpx.Response(200, json=RECORD) if request.method == "POST" else httpx.Response(404)


def problem(status: int, **members: Any) -> Callable[[httpx.Request], httpx.Response]:
    def answer(request: httpx.Request) -> httpx.Response:
        if request.method == "GET":
            return httpx.Response(404)
        headers = {"retry-after": str(members.get("after", ""))}
        said = {"type": f"{SITE}/docs/problems/#kind", "title": "T", "status": status, "detail": "It is so."}
        return httpx.Response(status, json=said | members, headers=headers)

    return answer


@pytest.mark.parametrize(("key", "model", "path"), VECTORS)
def test_digest_equals_the_documented_vectors(key: CameraKey, model: str, path: str) -> None:
    assert key.known_path(model) == path


def test_digest_normalises_the_label_and_refuses_fine_zooms() -> None:
    decomposed = CameraKey(" Inte\u0301gre\u0301e Kamera (04f2:b6cb)", VECTORS[2][0].platform, (640, 480))
    assert decomposed.known_path("fisheye") == VECTORS[2][2]
    assert CameraKey("a", "b", (640, 480), 1.23456789).known_path() is None


@both
def test_known_camera_is_answered_by_one_get_without_credential(twin: bool) -> None:
    service = known()
    answer = service.lookup(twin)
    assert answer.calibration is not None
    assert answer.calibration.record == RECORD
    assert answer.source == "edge"
    assert service.paths == [f"GET /{VECTORS[0][2]}"]
    assert "authorization" not in service.asked[0].headers


@both
def test_camera_that_the_edge_does_not_know_is_asked_of_the_service(twin: bool) -> None:
    service = Service(by_post)
    assert service.lookup(twin).source == "service"
    assert service.paths == [f"GET /{VECTORS[0][2]}", "POST /v1/lookup"]
    assert service.asked[1].headers["authorization"] == f"Bearer {TOKEN}"
    assert json.loads(service.asked[1].content)["redirect"] is False


@both
def test_answer_of_the_edge_is_kept_as_long_as_it_allows(twin: bool, tmp_path: Path) -> None:
    folder = tmp_path / "cache"
    service = known("public, max-age=60, s-maxage=300")
    assert [service.lookup(twin, folder).source for _ in range(2)] == ["edge", "cache"]
    assert len(service.asked) == 1
    (kept,) = folder.iterdir()
    assert stat.S_IMODE(kept.stat().st_mode) == 0o600
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert TOKEN not in kept.read_text()
    stored = json.loads(kept.read_text())
    kept.write_text(json.dumps(stored | {"expires": stored["expires"] - 61}))
    assert service.lookup(twin, folder).source == "edge"
    kept.write_text("{not json")
    assert service.lookup(twin, folder).source == "edge"
    known("no-store, max-age=60").lookup(twin, tmp_path / "other")
    assert not (tmp_path / "other").exists()
    assert service.lookup(twin, kept / "cache").source == "edge", "where nothing can be written"


@both
def test_unknown_camera_has_reason_and_page(twin: bool) -> None:
    service = Service(problem(404, reason="too_few", guidance_url=f"{SITE}/calibrate/?camera=x"))
    answer = service.lookup(twin)
    assert (answer.calibration, answer.reason, answer.detail) == (None, "too_few", "It is so.")
    assert answer.guidance_url.startswith(SITE)


@both
@pytest.mark.parametrize(
    ("status", "members", "kind", "words"),
    [
        (401, {}, CredentialError, "It is so. Check the token"),
        (403, {}, CredentialError, "It is so"),
        (409, {}, ConflictError, "It is so"),
        (410, {}, NotFoundError, "It is so"),
        (422, {"errors": [{"field": "img_size.1", "detail": "at least 16"}]}, ProblemError, "1: at least 16"),
        (429, {"after": 1800}, QuotaError, "in 30 min"),
    ],
)
def test_problem_is_an_error_with_its_fields(
    twin: bool, status: int, members: dict[str, Any], kind: type[ProblemError], words: str
) -> None:
    service = Service(problem(status, **members))
    with pytest.raises(kind, match=words) as raised:
        service.lookup(twin)
    error = raised.value
    assert (error.status, error.kind, error.title) == (status, "kind", "T")
    assert [each.field for each in error.errors] == [each["field"] for each in members.get("errors", [])]
    assert error.retry_after == members.get("after")
    assert service.pauses == []
    assert TOKEN not in str(error)


@both
def test_busy_service_is_asked_again_after_growing_pauses(twin: bool) -> None:
    answers = iter([httpx.Response(503), httpx.Response(429, json={"message": "Too Many Requests"})])

    def answer(request: httpx.Request) -> httpx.Response:
        return httpx.Response(404) if request.method == "GET" else next(answers, None) or by_post(request)

    service = Service(answer)
    assert service.lookup(twin).calibration
    assert len(service.pauses) == 2
    assert 0.125 <= service.pauses[0] <= 0.25 <= service.pauses[1] <= 0.5


@both
@pytest.mark.parametrize(
    ("error", "said"),
    [(httpx.ConnectError("[Errno 111]"), "no connection"), (httpx.ReadTimeout("x"), "no response in time")],
)
def test_service_that_is_away_is_said_in_one_sentence(twin: bool, error: Exception, said: str) -> None:
    def answer(_: httpx.Request) -> httpx.Response:
        raise error

    service = Service(answer)
    with pytest.raises(ServiceUnavailableError, match=said) as raised:
        service.lookup(twin)
    assert "try again" in str(raised.value)
    assert len(service.pauses) == 3
    assert len(service.asked) == 1 + 4, "the edge once, the service four times"


@both
def test_other_programs_answers_are_recognised(twin: bool) -> None:
    service = Service(lambda _: httpx.Response(200, text="<html>Welcome to the hotel</html>"))
    with pytest.raises(ServiceUnavailableError, match="not the service"):
        service.lookup(twin)


def test_redirect_is_not_followed_with_the_token() -> None:
    def answer(request: httpx.Request) -> httpx.Response:
        assert request.url.host == "calibdb.test"
        return httpx.Response(307, headers={"location": "https://elsewhere.test/"}, json={})

    with pytest.raises(ServiceUnavailableError):
        Service(answer).lookup(False)


def test_token_is_shown_nowhere() -> None:
    with Client(SITE, TOKEN, cache=False) as client:
        assert TOKEN not in repr(client)
        assert TOKEN not in repr(vars(client)["_connection"])


@pytest.mark.parametrize("url", ["", "calibdb.test", "ftp://calibdb.test", "https://user@calibdb.test"])
def test_address_that_is_none_is_refused(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CALIBDB_URL", raising=False)
    with pytest.raises(UsageError):
        Client(url, TOKEN)


def test_missing_token_is_said_where_it_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CALIBDB_TOKEN", raising=False)
    with known().client(token=None) as client:
        assert client.lookup(KEY).calibration, "the edge asks for none"
        with pytest.raises(UsageError, match="CALIBDB_TOKEN"):
            client.cameras()


def test_ids_do_not_leave_their_place_in_the_address() -> None:
    service = known()
    with service.client() as client:
        for identifier in ("../tokens", "..", "a/b", "a?b", ""):
            for read in (client.calibration, client.rig):
                with pytest.raises(UsageError):
                    read(identifier)
            for export in (client.export, client.rig_file):
                with pytest.raises(UsageError):
                    export(identifier, "kalibr")
    assert service.asked == []


def test_file_is_described_by_its_headers() -> None:
    headers = {
        "content-disposition": 'attachment; filename="camchain.yaml"',
        "x-conversion-error": "0.25",
        "x-conversion-coverage": "0.9",
        "x-conversion-warning": "near the axis only",
    }
    service = Service(lambda _: httpx.Response(200, content=b"cam0:\n", headers=headers))
    with service.client() as client:
        file = client.rig_file("0" * 32, "kalibr")
    assert (file.content, file.filename) == (b"cam0:\n", "camchain.yaml")
    assert (file.error, file.coverage, file.warning) == (0.25, 0.9, "near the axis only")


IMPORT = """
import sys, threading
sys.modules["cv2"] = None
import calibdb_client
heavy = {"numpy", "httpx", "rich"} & set(sys.modules)
assert not heavy, heavy
from calibdb_client import Client, Calibration, CameraKey
with Client("https://calibdb.test", "cdb_x", cache=False): pass
assert threading.active_count() == 1
assert set(calibdb_client.__all__) <= {n for n in calibdb_client.__all__ if getattr(calibdb_client, n)}
"""


def test_import_loads_nothing_heavy_works_without_opencv_and_leaves_no_thread() -> None:
    environment = {"PYTHONPATH": f"{ROOT}/clients/python:{ROOT}/layers/solver"}
    environment |= {name: os.environ[name] for name in ("PYTHONPYCACHEPREFIX",) if name in os.environ}
    subprocess.run([sys.executable, "-c", IMPORT], check=True, env=environment)


@pytest.mark.parametrize("client", [Client, AsyncClient])
def test_help_says_what_a_call_returns(client: type) -> None:
    calls = [each for name, each in vars(client).items() if name[0] != "_" and inspect.isfunction(each)]
    said = {each.__name__: inspect.signature(each).return_annotation for each in calls}
    assert said["lookup"] == "Answer"
    assert said["cameras"] == "list[Mapping[str, Any]]"
    assert not [name for name, result in said.items() if "Flow" in result]
