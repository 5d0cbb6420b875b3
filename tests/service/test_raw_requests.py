"""Requests that no HTTP library would send, over raw sockets: odd lines, headers, paths and framing.

Every answer is HTTP with a status below 500, or 503. Nothing that was sent comes back as a header, and no
file outside the site is served. `make thorough ONLY=fuzz` sends 10,000.
"""

import json
import os
import random
import re
import socket
from collections import Counter
from collections.abc import Iterator

import pytest

from infra.server import app
from infra.server.protocol import TimedProtocol
from infra.server.server import Server
from infra.web_build.openapi import OPERATIONS
from tests.helpers.service import in_process
from tests.helpers.service.client import BRIEF, CAMERA, TOKEN, Client, Truth
from tests.helpers.service.rigs import RigTruth

CASES = 2 * int(os.environ.get("CASES", "150"))
SECRETS = (b"def handler", b"root:x:", b"AWSTemplateFormatVersion", b"[project]", b"Traceback (most recent")
PATHS = (
    *(operation.path.replace("/rigs/{id}", "/rigs/{rig}") for operation in OPERATIONS),
    *("/", "/config.json", "/rig/", "/sdk/index.js", "/v1/nothing", "/known/aa/bb.json"),
)
VERBS = ("GET", "POST", "DELETE", "PUT", "HEAD", "OPTIONS", "TRACE", "CONNECT", "get", "G\x00T", "X" * 300)
ODD = (
    "..", "../", "..%2f", "%2e%2e/", "..\\", "%5c..", "%00", "%0d%0aX-Injected: 1", "%c0%ae/", "%zz", "//",
    ";a=b", "\u00e9", "%ff", '"', "<script>", "a" * 2000, "%25" * 50, "?", "#", " ", "template.yaml",
)  # fmt: skip
HEADERS = (
    "Accept", "Authorization", "Connection", "Content-Encoding", "Content-Length", "Content-Type", "Expect",
    "Host", "If-None-Match", "Origin", "Range", "Transfer-Encoding", "Upgrade", "X-Forwarded-For",
    "x-calibdb-edge",
)  # fmt: skip
VALUES = (
    "", "-1", "1", "99999999999999999999", "1, 1", "bytes=9-1", "chunked", "identity, chunked", "gzip",
    "application/json", "image/png;q=x", "*/*;q=0", "null", "https://evil.example", "websocket",
    "100-continue", "\x7f", "\xff\xfe", "Bearer ", "bearer " + "a" * 4000, "x" * 9000, "\u0001",
)  # fmt: skip


@pytest.fixture(scope="module")
def sent_to(stack: Server) -> Iterator[tuple[str, dict[str, str], str]]:
    client = Client(stack)
    calibration = Truth().calibrate(client, **BRIEF)["calibration_id"]
    rig = RigTruth(stack).open()
    rig.moment("m0")
    ids = {"id": calibration, "key": calibration.rpartition("-")[0], "rig": rig.rig_id}
    ids |= {"index": "0", "moment": "m0", "file": "1x1.svg", "digest": "0", "size": "1x1", "zoom": "0"}
    with stack.serve() as url:
        yield url, ids, rig.clients[0].session_id


def target(rng: random.Random, ids: dict[str, str]) -> str:
    path = rng.choice(PATHS).format(**ids)
    for _ in range(rng.choice((0, 0, 0, 1, 1, 3))):
        at = rng.randrange(len(path) + 1)
        path = path[:at] + rng.choice(ODD) + path[at:]
    if rng.random() < 0.4:
        names = ("format", "crop", "skip", "camera", "img_size", "key", "query", "id")
        values = (*ODD, "1", "kalibr", "0,0,64,64", "1e400", TOKEN, "9" * 400)
        path += "?" + "&".join(f"{rng.choice(names)}={rng.choice(values)}" for _ in range(rng.randint(1, 4)))
    return path


def body(rng: random.Random) -> bytes:
    return rng.choice(
        (
            b"", b"{}", b"[", b"\xff\xfe{\x00}\x00", b"[" * 5000, b"1e999999", b'"\\ud800"',
            json.dumps(CAMERA).encode(), json.dumps({**CAMERA, "redirect": False}).encode(),
            json.dumps({"index": 0, "ids": [0], "points": [[1, 1]], "moment": "m0"}).encode(),
            b'{"index":' + b"9" * 5000 + b"}", rng.randbytes(rng.randint(1, 300)), b"x" * 20_000,
        )
    )  # fmt: skip


def request(rng: random.Random, ids: dict[str, str], session_id: str) -> bytes:
    verb = rng.choice(VERBS) if rng.random() < 0.3 else rng.choice(("GET", "POST"))
    line = f"{verb} {target(rng, ids)}"
    line += rng.choice((" HTTP/1.1",) * 8 + (" HTTP/1.0", " HTTP/2.0", "", " HTTP/1.1 x", " http/1.1"))
    content = body(rng)
    fields = [] if rng.random() < 0.05 else ["Host: localhost"]
    fields += ["Connection: close"] * (rng.random() < 0.97)  # else the server waits for another
    if rng.random() < 0.8:
        fields.append(f"Authorization: Bearer {rng.choice((TOKEN, session_id, TOKEN + 'x'))}")
    for _ in range(rng.choice((0, 0, 0, 0, 1, 1, 2, 8))):
        colon = rng.choice((": ",) * 9 + (":", " : ", "\t:", "=", ":\r\n "))
        fields.append(f"{rng.choice(HEADERS)}{colon}{rng.choice(VALUES)}")
    if rng.random() < 0.9:
        fields.append(f"Content-Length: {len(content) + rng.choice((0,) * 12 + (-1, 5, 10**9))}")
    rng.shuffle(fields)
    end = rng.choice(("\r\n",) * 9 + ("\n",))
    head = end.join([line, *fields, "", ""]).encode("latin-1", "replace")
    whole = head + content
    if rng.random() < 0.05:
        whole += whole  # pipelined
    if rng.random() < 0.05:
        whole = whole[: rng.randrange(1, len(whole))]
    return whole


def exchange(address: tuple[str, int], content: bytes) -> bytes:
    with socket.create_connection(address, timeout=60) as connection:
        received = b""
        try:
            connection.sendall(content)
            while piece := connection.recv(1 << 16):
                received += piece
        except ConnectionError:
            pass  # refused before all of it was sent
        return received


def statuses(received: bytes) -> list[int]:
    return [int(found) for found in re.findall(rb"(?:^|\r\n|[}>\n])HTTP/1\.1 ([0-9]{3}) ", received)]


def test_no_raw_request_breaks_the_server(
    sent_to: tuple[str, dict[str, str], str],
    stack: Server,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Of the requests that never end none is waited for longer than this.
    monkeypatch.setattr(TimedProtocol, "header_timeout_s", 0.2)
    monkeypatch.setattr(app, "BODY_TIMEOUT_S", 0.2)
    url, ids, session_id = sent_to
    address = ("127.0.0.1", int(url.rpartition(":")[2]))
    seen = Counter()
    for seed in range(CASES):
        content = request(random.Random(seed), ids, session_id)
        received = exchange(address, content)
        if received:
            assert received.startswith(b"HTTP/1.1 "), (seed, content[:300], received[:300])
        found = statuses(received)
        seen.update(found)
        assert all(status < 500 or status == 503 for status in found), (seed, content[:300], received[:600])
        heads = [part.partition(b"\r\n\r\n")[0].lower() for part in received.split(b"HTTP/1.1 ")[1:]]
        assert not any(b"\r\nx-injected" in head for head in heads), (seed, content[:300])
        assert not any(secret in received for secret in SECRETS), (seed, content[:300], received[:300])
    assert {200, 400, 404, 422} <= set(seen)
    assert in_process.request(stack, "GET", "/healthz").status == 200
