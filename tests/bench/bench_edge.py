"""A known camera over sockets: the file at the edge beside the POST, from another process."""

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path

from infra.local import LocalStack
from tests.bench.raw_load import drive
from tests.bench.table import Row
from tests.helpers.service.client import TOKEN
from tests.helpers.service.edge import Question
from tests.helpers.service.published import PLATFORM, asked, calibration, mode_of, store
from tests.helpers.stack.processes import LocalProcess

REQUESTS = 3000
CLIENTS = 4
LABEL = "Known at the edge"


def rows() -> Iterator[Row]:
    question = Question(LABEL, PLATFORM, (1280, 720), "rectilinear")
    with tempfile.TemporaryDirectory() as place:
        data_dir = Path(place, "data")
        with LocalStack(data_dir) as stack:
            for n in range(5):
                store(stack).calibrations.publish(calibration(LABEL, n, views=3))
            store(stack).refit.now(asked(mode_of(calibration(LABEL, 0, views=3))))
        body = {"camera": LABEL, "platform": PLATFORM, "img_size": [1280, 720], "redirect": False}
        post = ("POST", "/v1/lookup", {"authorization": f"Bearer {TOKEN}"}, json.dumps(body))
        get = ("GET", f"/{question.object}", {}, "")
        with LocalProcess(data_dir) as server:
            drive(server.url, *post, requests=200, clients=CLIENTS)
            drive(server.url, *get, requests=200, clients=CLIENTS)
            alone = drive(server.url, *get, requests=REQUESTS, clients=1)
            posted_alone = drive(server.url, *post, requests=REQUESTS // 10, clients=1)
            posted = drive(server.url, *post, requests=REQUESTS // 4, clients=CLIENTS)
            got = drive(server.url, *get, requests=REQUESTS, clients=CLIENTS)
    yield Row("known camera at the edge, 1 client, p50", alone.percentile(0.5), 1, "ms")
    yield Row("the same by POST, 1 client, p50", posted_alone.percentile(0.5), None, "ms")
    rates = f"{1e3 / got.each:.0f}/s and {1e3 / posted.each:.0f}/s, {CLIENTS} clients"
    yield Row("POST's share of the edge's lookups a second", got.each / posted.each, 1 / 8, "x", rates)
