"""Calibrations as finished sessions leave them, made without any session."""

import functools
import hashlib
from collections.abc import Sequence
from typing import Any

import calibsolver
from calibdb import schema
from calibdb.settings import Settings
from calibdb.store import Store, StreamMode
from calibsolver import Board, fit
from infra.server.server import Server
from tests.helpers.service import known
from tests.helpers.service.client import Truth
from tests.helpers.service.known import mode_of

IMG_SIZE = (1280, 720)
NOW = 1_700_000_000
PLATFORM = known.LINUX
TILTS = ((0.5, 0.1, 0.1), (-0.4, 0.5, 0.0), (0.1, -0.6, 0.2), (0.0, 0.5, -0.3), (0.4, -0.4, 0.0))
BOARD = Board()
MODELS = ("rectilinear",)
Vector = tuple[float, float, float]


def store(stack: Server) -> Store:
    return Store.of(Settings.from_environment(stack.environment))


def publish(stack: Server, *documents: schema.CalibrationDocument, models: Sequence[str] = MODELS) -> None:
    at_rest = store(stack)
    for document in documents:
        at_rest.calibrations.publish(document)
    for mode in dict.fromkeys(map(mode_of, documents)):
        at_rest.refit.now(asked(mode, *models))


def put(store: Store, *documents: schema.ConsensusDocument) -> None:
    for document in documents:
        assert store.consensuses.put(document, schema.GroupsDocument(pooled=document.pooled), None)


def held(
    truth: Truth, count: int, tilts: Sequence[Vector] = TILTS
) -> list[tuple[list[int], list[list[float]]]]:
    """Views of a board held by hand in several ways: ids and points."""
    seen = []
    for n in range(count):
        tvec = [-4.5 + truth.rng.normal(0, 0.7), -3 + truth.rng.normal(0, 0.5), 8 + 0.7 * n]
        seen.append(truth.see({"rvec": tilts[n % len(tilts)], "tvec": tvec}))
    return seen


def views(truth: Truth, count: int = 3, tilts: Sequence[Vector] = TILTS) -> list[dict[str, Any]]:
    return [{"ids": ids, "points": points} for ids, points in held(truth, count, tilts)]


def mirrored(view: dict[str, Any]) -> dict[str, Any]:
    return {**view, "points": [[IMG_SIZE[0] - 1 - x, y] for x, y in view["points"]]}


@functools.cache
def fitted(n: int, count: int, **truth: Any) -> tuple[tuple[schema.ViewDocument, ...], schema.FitRecord]:
    seen = views(Truth(seed=n, **truth), count)
    record = fit([BOARD.view(**view) for view in seen], IMG_SIZE).record()
    documents = (schema.ViewDocument(index=i, **view) for i, view in enumerate(seen))
    return tuple(documents), schema.FitRecord.model_validate(record)


@functools.lru_cache(maxsize=256)
def calibration(
    camera: str, n: int, views: int = 3, begun: int = NOW, **truth: Any
) -> schema.CalibrationDocument:
    """The `n`th calibration of a camera, of a contributor of its own, `n` seconds after the first was begun.

    Each is made once in a process: a document never changes.

    `truth`: what differs from the camera that `Truth` is.
    """
    seen, record = fitted(n, views, **truth)
    made = known.calibration(camera, PLATFORM, of=record)
    name = hashlib.sha256(f"{camera}/{n}".encode()).hexdigest()[:12]
    update = {
        "id": f"{made.camera_key}-{begun + n:08x}{name}",
        "views": seen,
        "solver": calibsolver.FIT_VERSION,
        "contributor": hashlib.sha256(f"contributor {n}".encode()).hexdigest(),
        "time": begun + n + 60,
    }
    return made.model_copy(update=update)


def asked(mode: StreamMode, *models: str) -> schema.RefitRequest:
    """The request for the consensus; of all models, where none is named."""
    return schema.RefitRequest(camera=mode.camera_key, img_size=mode.img_size, zoom=mode.zoom, models=models)


def pooled(store: Store, document: schema.CalibrationDocument) -> Any:
    """Compute the rectilinear consensus of a calibration's mode."""
    (found,) = store.refit.now(asked(mode_of(document), "rectilinear")).models.values()
    return found


def stored(store: Store, document: schema.CalibrationDocument, model: str = "rectilinear") -> Any:
    (found,) = (one for one in store.consensuses.at(mode_of(document)) if one.distortion_model == model)
    return found
