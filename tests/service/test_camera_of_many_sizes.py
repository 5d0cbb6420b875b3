"""Anybody can add a size to a camera."""

from collections import Counter
from itertools import pairwise

from calibdb.camera_key import camera_key
from infra.server.server import Server
from tests.helpers.service.client import Client
from tests.helpers.service.known import LINUX, calibration, consensus, fit
from tests.helpers.service.published import put, store
from tests.helpers.service.storage_calls import storage_calls

CAMERA = "Many sizes Z77 (1111:0077)"


def test_best_known_sizes_are_shown_by_two_reads_each(stack: Server) -> None:
    small, often = (320, 240), (336, 240)
    published = [calibration(CAMERA, of=fit(size)) for size in (small, often)]
    for document in published:
        store(stack).calibrations.publish(document)
    put(store(stack), consensus(fit(small), camera=CAMERA))
    put(store(stack), consensus(fit(often), camera=CAMERA, reason="too_few", calibrations=4))
    for n in range(98):
        few = consensus(fit((1280 + 16 * n, 720)), camera=CAMERA, reason="too_few", calibrations=1)
        put(store(stack), few)
    client, path = Client(stack), f"/v1/cameras/{camera_key(CAMERA, LINUX)}"
    client.lookup()  # the token is remembered from here on
    with storage_calls(stack) as asked:
        modes = client.call("GET", path).json["modes"]
    assert Counter(asked) == {"GetItem": 1 + 60, "Query": 1 + 60}
    sizes = [tuple(mode["img_size"]) for mode in modes]
    assert len(sizes) == 60
    assert {small, often} <= set(sizes)
    assert all(a[0] * a[1] >= b[0] * b[1] for a, b in pairwise(sizes)), "the largest first"
