"""Conversations with the service, without a network: generators that yield requests and are sent replies.

Both clients drive the same conversations. An error that a reply stands for is raised inside the conversation,
which may continue without it.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from email.message import Message
from typing import TYPE_CHECKING, Any, TypeVar

from .cache import Cache
from .calibration import Answer, Estimate
from .errors import CalibDBError, NotFoundError, ServiceUnavailableError, UsageError
from .files import ExportedFile
from .key import CameraKey
from .wire import Reply, Request

if TYPE_CHECKING:
    from .calibration import Maker
    from .recording import Recording

T = TypeVar("T")
Flow = Generator[Request, Reply, T]

MAX_LOOKUP_VIEWS = 5
MAX_PAGES = 200


def facts(reported: Mapping[str, float] | None, views: Recording | None) -> dict[str, Any]:
    """Return the members of a lookup that only the estimate uses.

    Raises UsageError for views of a board that the service does not take.
    """
    out: dict[str, Any] = {"reported": dict(reported)} if reported else {}
    if views is not None:
        from .checks import views_of

        if views.board.kind.endswith("circles"):
            raise UsageError("the service takes no grids of circles: send views of another board")
        out |= views_of(views, MAX_LOOKUP_VIEWS)
    return out


def lookup(
    key: CameraKey,
    model: str,
    site: str,
    cache: Cache | None,
    make: Maker,
    facts: Mapping[str, Any],
) -> Flow[Answer]:
    """Look a camera up: in the cache, at the edge of a site, then by POST.

    `make` turns a record into a calibration. `facts`: further members of the request, for the estimate.
    """
    path = key.known_path(model)
    if path is not None:
        address = f"{site}/{path}"
        if cache and (entry := cache.get(address)) and _is_record(entry):
            return Answer(make(entry), source="cache")
        try:
            reply = yield Request("GET", path, credential="none", repeats=False)
            if _is_record(record := reply.json):
                if cache:
                    cache.put(address, record, reply.headers)
                return Answer(make(record), source="edge")
        except CalibDBError:
            pass  # unknown at the edge, or no edge: ask the service
    body = {**key.record(), **facts, "redirect": False, "distortion_model": model}
    try:
        reply = yield Request("POST", "v1/lookup", body)
    except NotFoundError as error:
        if not isinstance(reason := error.members.get("reason"), str):
            raise
        url = str(error.members.get("guidance_url") or "")
        likely = error.members.get("estimate")  # older services give none
        estimate = Estimate(likely) if isinstance(likely, dict) else None
        return Answer(None, reason, error.detail, url, estimate=estimate)
    if _is_record(record := reply.json):
        return Answer(make(record))
    raise ServiceUnavailableError(f"{site} answered a lookup with something else: check the address")


def file(path: str, query: Mapping[str, str], unnamed: str) -> Flow[ExportedFile]:
    """Read a file, with what its headers say of it; `unnamed` is its name if they give none."""
    reply = yield Request("GET", path, query=query, accept="*/*")
    headers = reply.headers
    return ExportedFile(
        content=reply.body,
        filename=_filename(headers.get("content-disposition", "")) or unnamed,
        media_type=headers.get("content-type", "application/octet-stream"),
        error=_number(headers.get("x-conversion-error"), 0.0),
        coverage=_number(headers.get("x-conversion-coverage"), 1.0),
        warning=headers.get("x-conversion-warning", ""),
    )


def cameras(query: str, limit: int) -> Flow[list[Mapping[str, Any]]]:
    """Search the database, page by page, for at most `limit` cameras."""
    records: list[Mapping[str, Any]] = []
    parameters = {"query": query, "limit": str(min(limit, 50))}
    for _ in range(MAX_PAGES):
        reply = yield Request("GET", "v1/cameras", query=parameters)
        page = reply.json
        records += page.get("cameras", [])
        if len(records) >= limit or not page.get("next"):
            break
        parameters["after"] = str(page["next"])
    return records[:limit]


def _is_record(said: Mapping[str, Any]) -> bool:
    return "camera_matrix" in said


def segment(text: str) -> str:
    """Return an id as one segment of a path. Raises UsageError for text that is not an id."""
    if not text or not all(c.isascii() and (c.isalnum() or c in "-_.~") for c in text) or set(text) == {"."}:
        raise UsageError(f"{text!r} is not an id of a calibration, camera or rig")
    return text


def _filename(disposition: str) -> str:
    message = Message()
    message["content-disposition"] = disposition or "attachment"
    name = str(message.get_filename() or "").replace("\\", "/").rpartition("/")[2]
    return name.lstrip(".")


def _number(text: str | None, default: float) -> float:
    try:
        return float(text) if text is not None else default
    except ValueError:
        return default
