"""Capture of a computed camera through the site, as a page makes one."""

import functools
import json
import math
import random
import urllib.error
import urllib.request
from collections.abc import Iterator, Mapping
from typing import Any

from calibdb.schema.health import CanaryStep

_TIMEOUT_S = 20.0  # the first call starts a function
_MAX_RESPONSE_BYTES = 1_000_000
_KEY = {"camera": "calibDB canary", "platform": "X11; Linux x86_64", "img_size": [1280, 720]}
FOCAL, _CENTER = 950.0, (652.0, 351.0)  # px
_MAX_FOCAL_ERROR = 0.02  # of the focal length
_NOISE_PX = 0.1
_TARGET_ERROR_PX = 0.02  # out of reach, so that the capture does not end and store a calibration
_TURNS = ((0.5, 0.0), (-0.5, 0.1), (0.1, 0.55), (0.0, -0.6), (0.4, 0.4), (-0.4, -0.4))  # rad about x and y


class CanaryError(Exception):
    """The service failed; the text is for the operator."""


def _call(site: str, credential: str, method: str, path: str, body: Mapping[str, Any] | None = None) -> Any:
    """JSON of a successful response, None without a body; raises CanaryError."""
    headers = {
        "authorization": f"Bearer {credential}",
        "content-type": "application/json",
        "accept": "application/json",
    }
    content = None if body is None else json.dumps(body).encode()
    # The address is the operator's own.
    request = urllib.request.Request(f"{site}{path}", content, headers, method=method)  # noqa: S310
    try:
        with urllib.request.urlopen(request, timeout=_TIMEOUT_S) as answer:  # noqa: S310
            text = answer.read(_MAX_RESPONSE_BYTES)
        return json.loads(text) if text else None
    except urllib.error.HTTPError as error:
        error.close()
        raise CanaryError(f"{method} {path}: {error.code}") from error
    except OSError as error:
        raise CanaryError(f"{method} {path}: {error}") from error
    except ValueError as error:
        raise CanaryError(f"{method} {path}: no JSON") from error


def see_board(seed: int) -> Iterator[tuple[list[int], list[list[float]]]]:
    """Ids and pixels of the default board's corners in each view."""
    noise = random.Random(seed)  # noqa: S311
    for n, (about_x, about_y) in enumerate(_TURNS):
        sin_x, cos_x = math.sin(about_x), math.cos(about_x)
        sin_y, cos_y = math.sin(about_y), math.cos(about_y)
        ids, points = [], []
        for corner in range(40):
            x, y = corner % 8 + 1 - 4.5, corner // 8 + 1 - 3.0
            # About y, then about x, and ten squares away.
            across, depth = x * cos_y, -x * sin_y
            down, depth = y * cos_x - depth * sin_x, y * sin_x + depth * cos_x + 9.0 + n % 3
            u = FOCAL * across / depth + _CENTER[0] + noise.gauss(0, _NOISE_PX)
            v = FOCAL * down / depth + _CENTER[1] + noise.gauss(0, _NOISE_PX)
            if 0 <= u <= 1279 and 0 <= v <= 719:
                ids.append(corner)
                points.append([u, v])
        yield ids, points


def steps(site: str, token: str) -> Iterator[CanaryStep]:
    """Look up and calibrate; yield each step before it is taken. Raises CanaryError."""
    page = functools.partial(_call, site, token)
    yield "lookup"
    missed = page("POST", "/v1/lookup", {**_KEY, "miss": "ok"})
    if missed["calibration"] is not None or not missed["guidance_url"]:
        raise CanaryError("a camera that does not exist was found")
    yield "open"
    capture = functools.partial(_call, site, page("POST", "/v1/auth")["session_id"])
    state = capture("POST", "/v1/session", {**_KEY, "target_error": _TARGET_ERROR_PX})
    try:
        for ids, points in see_board(seed=len(_TURNS)):
            yield "pose"
            index = capture("GET", "/v1/session/pose")["index"]
            yield "view"
            state = capture("POST", "/v1/session/views", {"index": index, "ids": ids, "points": points})
        yield "result"
        (fx, *_), (_, fy, _), _ = state["calibration"]["camera_matrix"]
        if not all(abs(focal / FOCAL - 1) < _MAX_FOCAL_ERROR for focal in (fx, fy)):
            raise CanaryError(f"fx {fx}, fy {fy} px, not {FOCAL} px")
        if state["calibration_id"] is not None:
            raise CanaryError("the capture ended, and stored a calibration")
    finally:
        capture("DELETE", "/v1/session")
