"""Requests that a capture may send: keypoints, never an image."""

import json
from collections.abc import Iterable
from urllib.parse import urlsplit

from playwright.sync_api import Request

KEYPOINTS = {"index", "ids", "points"}
SESSION = {"camera", "platform", "img_size", "zoom", "board", "distortion_model", "track", "target_error"}


def assert_only_keypoints(sent: Iterable[Request]) -> None:
    """Assert that a page sends only GETs, start and end of a session, and corner positions."""
    views = 0
    for request in sent:
        if request.method == "GET":
            assert not request.post_data_buffer
            continue
        assert request.method == "POST", request.method
        path = urlsplit(request.url).path
        body = json.loads(request.post_data or "null")
        if path in ("/v1/auth", "/v1/session/finish"):
            assert body is None
        elif path == "/v1/session":
            assert set(body) <= SESSION
            assert all(isinstance(value, (str, int, float)) for value in body["track"].values())
        else:
            assert path == "/v1/session/views"
            assert set(body) == KEYPOINTS
            assert len(body["ids"]) == len(body["points"]) <= 40
            assert all(len(point) == 2 for point in body["points"])
            assert len(request.post_data or "") < 4096
            views += 1
    assert views >= 4
