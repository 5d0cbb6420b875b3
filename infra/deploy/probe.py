"""Function that looks up an unknown camera, for which site, edge, API, secrets and index have to answer.

The template contains this file as inline code, at most 4,096 characters.
"""

import json
import os
import urllib.error
import urllib.request

LOOKUP = {"camera": "Probe 0000", "platform": "X11; Linux x86_64", "img_size": [640, 480], "redirect": False}


def handler(_event: object, _context: object) -> None:
    """Look up as a page does; raises RuntimeError if the answer is another."""
    status, content = _ask("/config.json")
    if status != 200:
        raise RuntimeError(f"GET /config.json: {status}")
    status, content = _ask("/v1/lookup", json.loads(content)["token"], LOOKUP)
    if status != 404 or b'"reason"' not in content:
        raise RuntimeError(f"POST /v1/lookup: {status}")


def _ask(path: str, token: str = "", body: object = None) -> tuple[int, bytes]:
    headers = {"authorization": f"Bearer {token}", "content-type": "application/json"} if token else {}
    content = json.dumps(body).encode() if body else None
    request = urllib.request.Request(os.environ["SITE_URL"] + path, content, headers)  # noqa: S310 - our own
    try:
        with urllib.request.urlopen(request, timeout=8) as answer:  # noqa: S310
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()
