"""Rules of a capture session, as pure functions from one session document to the next.

The open pose carries `next_index`, which an accepted view takes. An index is never used again: a delayed
replay of an undone view is a conflict. A converged session no longer changes.
"""

from collections.abc import Mapping, Sequence

from pydantic import JsonValue

from calibdb.camera_key import camera_key, public_label, public_platform
from calibdb.errors import MAX_FIELD_ERRORS, ConflictError, FieldError, InvalidError, NotFoundError
from calibdb.rules.quality_gates import TARGET_ERROR_PER_WIDTH
from calibdb.schema import (
    ConsensusDocument,
    EstimateDocument,
    FitRecord,
    SessionDocument,
    SessionRequest,
    ViewDocument,
)
from calibdb.schema.board import Board
from calibdb.schema.membership import RigMembership
from calibdb.schema.observed_corners import ObservedCorners
from calibdb.schema.session import MAX_RECORDED_VIEWS

MAX_POINTS = 20_000  # of all views: few enough to fit within a request
MIN_RECORDED_VIEWS = 4  # that agree: fewer can agree by chance
MAX_SKIPPED_TARGETS = 8
MAX_QUARANTINED_VIEWS = 4
_EDGE_PX = 0.5  # a pixel centre at 0 reaches from -0.5 to 0.5


def begin(
    request: SessionRequest,
    sid: str,
    first_version: int,
    now: int,
    seed: FitRecord | None = None,
    contributor: str | None = None,
    rig: RigMembership | None = None,
    source: str | None = None,
) -> SessionDocument:
    """Document of a session that starts, without personal names.

    `contributor`, `source`: keyed hashes of the starter and, of a session in a `rig`, of their address.
    """
    target = request.target_error
    changed = {
        "camera_key": camera_key(request.camera, request.platform),
        "camera": public_label(request.camera),
        "platform": public_platform(request.platform),
        "target_error": TARGET_ERROR_PER_WIDTH * request.img_size[0] if target is None else target,
        "rig": rig,
    }
    return SessionDocument(
        **{**dict(request), **changed},
        session=sid,
        first_version=first_version,
        started=now,
        contributor=contributor,
        source=source,
        prior=seed,
    )


def is_same_start(running: SessionDocument, asked: SessionDocument) -> bool:
    """True if `asked` would have started the session that is running."""
    names = (
        *("camera", "platform", "img_size", "zoom", "distortion_model", "board", "guidance", "target_error"),
        *("track", "capture", "rig", "licence", "licence_version"),
    )
    return all(getattr(running, name) == getattr(asked, name) for name in names)


def is_idempotent_replay(document: SessionDocument, view: ViewDocument) -> bool:
    """True if `view` replays one that was accepted before; False if its index is open.

    Raises ConflictError if the index carries another view or is not open.
    """
    known = next((one for one in document.views if one.index == view.index), None)
    if is_replay(document, known, view, "Another view was accepted under this index."):
        return True
    if view.index != document.next_index:
        raise ConflictError(
            f"This index is not open; send the view with index {document.next_index}.", kind="index-not-open"
        )
    return False


def is_replay(document: SessionDocument, known: ViewDocument | None, view: ViewDocument, detail: str) -> bool:
    """True if `view` replays `known`, False without it; raises ConflictError with `detail`."""
    if known is None:
        require_open(document)
        return False
    if _corners(known) != _corners(view):
        raise ConflictError(detail, kind="other-content")
    return True


def validate_view(document: SessionDocument, view: ViewDocument) -> None:
    """Validate `view`; raises InvalidError, or ConflictError if the session is full."""
    wrong = _corner_errors(document.board, document.img_size, view)
    if wrong:
        raise InvalidError(wrong[:MAX_FIELD_ERRORS])
    _require_room(document, [view])


def validate_batch(
    document: SessionDocument, index: int, views: Sequence[ObservedCorners]
) -> list[ViewDocument | None]:
    """Validate a batch as `validate_view` does; for each view, find the one that an earlier request added.

    InvalidError has the first error of each bad view. Also raises ConflictError.
    """
    if document.capture != "recorded" or document.rig is not None:
        raise ConflictError(
            "Only a session that was started with `capture: recorded`, outside a rig, takes several views in "
            "one request.",
            kind="not-recorded",
        )
    added = [(_corners(view), view) for view in document.views if view.index >= index]
    if index > document.next_index or len(added) < document.next_index - index:
        raise ConflictError(
            f"This index is not open; send the views with index {document.next_index}.",
            kind="index-not-open",
        )
    replayed: list[ViewDocument | None] = []
    for view in views:
        corners = _corners(view)
        same = next((n for n, (known, _) in enumerate(added) if known == corners), None)
        replayed.append(None if same is None else added.pop(same)[1])
    if None in replayed:
        require_open(document)
    wrong: list[FieldError] = []
    for n, view in enumerate(views):
        wrong += _corner_errors(document.board, document.img_size, view, f"views.{n}.")[:1]
    if wrong:
        raise InvalidError(wrong[:MAX_FIELD_ERRORS])
    _require_room(document, [view for view, known in zip(views, replayed, strict=True) if known is None])
    return replayed


def _require_room(document: SessionDocument, views: Sequence[ObservedCorners | ViewDocument]) -> None:
    if sum(len(view.ids) for view in (*document.views, *views)) > MAX_POINTS:
        raise ConflictError(
            f"The session is full: it holds at most {MAX_POINTS} points.", kind="session-full"
        )
    recorded = document.capture == "recorded" or document.rig is not None
    if recorded and len(document.views) + len(views) > MAX_RECORDED_VIEWS:
        raise ConflictError(
            f"The session is full: it holds at most {MAX_RECORDED_VIEWS} views; finish it.",
            kind="session-full",
        )


def with_view(
    document: SessionDocument,
    views: tuple[ViewDocument, ...],
    estimate: EstimateDocument,
    target: Mapping[str, JsonValue] | None,
    on_target: bool | None = None,
) -> SessionDocument:
    """Add an accepted view, the last of `views`. Progress only grows.

    The end of the capture depends on `on_target` and the stated error of each view.
    """
    *others, view = views
    stated = estimate.uncertainty.rms if estimate.uncertainty else None
    view = view.model_copy(update={"on_target": on_target, "stated": stated})
    update = {
        "progress": max(document.estimate.progress, estimate.progress),
        # A suggestion is made once, since it is expensive to compute.
        "suggested_model": estimate.suggested_model or document.estimate.suggested_model,
    }
    unreached = (*document.unreached, *document.skipped)
    changed = {
        "next_index": max(document.next_index, view.index + 1),
        "unreached": unreached[-MAX_SKIPPED_TARGETS:],
        "doubted": (),
    }
    grown = with_views(document, (*others, view), estimate.model_copy(update=update), target)
    return grown.model_copy(update=changed)


def with_quarantined(document: SessionDocument, view: ViewDocument) -> SessionDocument | None:
    """Keep a refused view in quarantine; None if it is there already.

    More views like it show that the accepted ones were wrong.
    """
    if any(_corners(doubted) == _corners(view) for doubted in document.doubted):
        return None
    return document.model_copy(update={"doubted": (*document.doubted, view)[-MAX_QUARANTINED_VIEWS:]})


def without_view(document: SessionDocument, index: int) -> tuple[ViewDocument, ...] | None:
    """Views without that of `index`; None if it was undone before.

    Raises ConflictError or NotFoundError.
    """
    require_open(document)
    if index >= document.next_index:
        raise NotFoundError("No view was accepted under this index.", kind="no-view")
    left = tuple(view for view in document.views if view.index != index)
    return left if len(left) < len(document.views) else None


def with_views(
    document: SessionDocument,
    views: tuple[ViewDocument, ...],
    estimate: EstimateDocument,
    target: Mapping[str, JsonValue] | None,
) -> SessionDocument:
    """Replace the views and their estimate."""
    changed = {"views": views, "estimate": estimate, "target": target, "skipped": (), "duplicates": 0}
    return document.model_copy(update=changed)


def with_estimate(
    document: SessionDocument, views: tuple[ViewDocument, ...], estimate: EstimateDocument
) -> SessionDocument:
    """Replace the estimate, except its advice, and the views, which have other errors."""
    known = document.estimate
    kept = {"suggested_model": known.suggested_model, "advice": known.advice}
    return document.model_copy(update={"views": views, "estimate": estimate.model_copy(update=kept)})


def with_advice(document: SessionDocument, estimate: EstimateDocument) -> SessionDocument:
    """Replace the advice by that of `estimate`."""
    suggested = estimate.suggested_model or document.estimate.suggested_model
    advised = {"advice": estimate.advice, "suggested_model": suggested}
    return document.model_copy(update={"estimate": document.estimate.model_copy(update=advised)})


def with_target(document: SessionDocument, target: Mapping[str, JsonValue]) -> SessionDocument:
    """Open `target` in the document."""
    return document.model_copy(update={"target": target})


def without_seed(document: SessionDocument) -> SessionDocument:
    """Drop the initial camera, and the target, which depends on it."""
    return document.model_copy(update={"prior": None, "target": None})


def without_target(document: SessionDocument) -> SessionDocument:
    """Close the open target, which is not wanted."""
    unwanted = document.skipped if document.target is None else (*document.skipped, document.target)
    return document.model_copy(update={"target": None, "skipped": unwanted[-MAX_SKIPPED_TARGETS:]})


def require_open(document: SessionDocument) -> None:
    """Raise ConflictError if the session has converged."""
    if document.finish is not None:
        raise ConflictError("The session has converged and accepts no more changes.", kind="converged")


def require_finishable(document: SessionDocument) -> None:
    """Raise ConflictError unless the session has enough views that agree."""
    used = sum(view.set_aside is None for view in document.views)
    if used < MIN_RECORDED_VIEWS or document.estimate.fit is None:
        raise ConflictError(
            f"A calibration needs {MIN_RECORDED_VIEWS} views that agree; {used} are in. Submit more views.",
            kind="too-few-views",
        )


def _corners(view: ViewDocument | ObservedCorners) -> dict[int, tuple[float, float]]:
    """Points of a view by corner: equal for the same corners in any order."""
    return dict(zip(view.ids, view.points, strict=True))


def find_seed(
    consensuses: Sequence[ConsensusDocument], img_size: tuple[int, int], zoom: float, model: str
) -> FitRecord | None:
    """Initial camera of a capture: the reliable consensus of this size, zoom and model.

    Others may be of another camera.
    """
    for consensus in consensuses:
        same = (consensus.img_size, consensus.zoom, consensus.distortion_model) == (img_size, zoom, model)
        if same and consensus.reliable and consensus.calibration is not None:
            return FitRecord.model_validate(consensus.calibration.model_dump())
    return None


def require_corners(board: Board, img_size: tuple[int, int], views: Sequence[ObservedCorners]) -> None:
    """Raise InvalidError for corners that the board does not have, or outside the image."""
    wrong = [
        error
        for n, view in enumerate(views)
        for error in _corner_errors(board, img_size, view, f"views.{n}.")
    ]
    if wrong:
        raise InvalidError(wrong[:MAX_FIELD_ERRORS])


def _corner_errors(
    board: Board, img_size: tuple[int, int], view: ViewDocument | ObservedCorners, prefix: str = ""
) -> list[FieldError]:
    corners = board.corner_count
    width, height = img_size
    wrong = [
        FieldError(f"{prefix}ids.{i}", f"the board has corners 0 to {corners - 1}")
        for i, corner in enumerate(view.ids)
        if corner >= corners
    ]
    wrong += [
        FieldError(f"{prefix}points.{i}", f"outside the image of {width} x {height} px")
        for i, (x, y) in enumerate(view.points)
        if not (-_EDGE_PX <= x <= width - _EDGE_PX and -_EDGE_PX <= y <= height - _EDGE_PX)
    ]
    return wrong
