"""Target pose of a session: its choice and picture."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

from calibdb.compute.session_course import Session, current_camera, open_target, target_poses
from calibdb.compute.values import camera_of, in_time
from calibdb.errors import ConflictError
from calibdb.http.call import Call
from calibdb.rules import session_rules
from calibdb.schema import FitRecord, Pose, SessionDocument
from calibdb.schema.rig import RigTarget
from calibsolver import Board, CalibrationError, Camera
from calibsolver.guidance import TargetPose, overlay

PictureFormat = Literal["jpeg", "png"]


@contextmanager
def choosing_target(call: Call) -> Iterator[None]:
    """Limit the time; raises ConflictError or UnavailableError."""
    slow = "The views take longer to compute than a request may; undo one."
    try:
        with in_time(call, ConflictError(slow, kind="too-slow")):
            yield
    except CalibrationError as error:
        raise ConflictError(f"No target can be chosen: {error.message}; undo one.") from error


@dataclass(frozen=True)
class DrawnTarget:
    """A target as a camera sees it."""

    board: Board
    camera: Camera
    target: TargetPose

    @classmethod
    def of(cls, document: SessionDocument) -> DrawnTarget:
        """Draw the session's open target."""
        session = Session.of(document)
        camera = current_camera(document, session.rules)
        return cls(session.rules.board, camera, open_target(document, session))

    @classmethod
    def of_rig(cls, document: SessionDocument, target: RigTarget, fit: FitRecord | None) -> DrawnTarget:
        """Draw the target of the session's rig; raises ConflictError if it is for other cameras."""
        position = None if document.rig is None else document.rig.position
        view = next((one for one in target.cameras if one.position == position), None)
        if view is None:
            raise not_in_view()
        rules = Session.of(document).rules
        camera = current_camera(document, rules) if fit is None else camera_of(fit)
        values = {**view.model_dump(), "purpose": target.purpose, "gain": 0.0}
        return cls(rules.board, camera, TargetPose.from_dict(values))

    def pose(self, index: int) -> Pose:
        """Target as numbers; `index`: of the view that answers it."""
        return Pose.model_validate({**self.target.to_dict(), "index": index})

    def picture(self, kind: PictureFormat) -> bytes:
        """Picture to lay over the video."""
        return overlay.render(self.board, self.camera, self.target, kind)


def not_in_view() -> ConflictError:
    """Error of a target for other cameras."""
    return ConflictError(
        "This camera is not to see the board now: the target is for others.", kind="not-in-view"
    )


def with_chosen_target(document: SessionDocument) -> SessionDocument:
    """Open the best target, except unwanted ones."""
    session = Session.of(document)
    skipped, unreached = map(target_poses, (document.skipped, document.unreached))
    target = session.rules.next_target(session.views, session.estimate(), skipped, unreached)
    return session_rules.with_target(document, target.to_record())
