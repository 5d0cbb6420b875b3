"""Endings of sessions and rigs. Each step is idempotent: a repetition completes what a crash left undone."""

from calibdb.errors import NotFoundError
from calibdb.rules import rig_rules, session_result
from calibdb.schema import DISTORTION_MODELS, RefitRequest, RigDocument, SessionDocument
from calibdb.schema.rig_documents import EndingDocument
from calibdb.schema.session import LicenceRequest
from calibdb.store.store import Store


def publish(store: Store, document: SessionDocument) -> None:
    """Publish the calibration of a session, and queue the computation of every model's consensus."""
    calibration = session_result.to_calibration(document)
    store.calibrations.publish(calibration)
    store.refit.later(
        RefitRequest(
            camera=calibration.camera_key,
            img_size=calibration.img_size,
            zoom=calibration.zoom,
            models=DISTORTION_MODELS,
        )
    )


def license_session(store: Store, sid: str, request: LicenceRequest, now: int) -> SessionDocument:
    """Add the contributor's licence to a session and its calibration; return the session."""
    document = store.sessions.revise(
        sid, now, lambda known: None if known.licence else known.model_copy(update=request.consent)
    )
    if document.finish is not None:
        publish(store, document)  # if a crash left that undone
        store.calibrations.license(document.finish.calibration_id, request)
    return document


def publish_rig(store: Store, document: RigDocument, now: int) -> None:
    """Store the result of a finished rig, then end and publish the sessions of its cameras."""
    for session in end_sessions(store, document, now):
        publish(store, session)


def end_sessions(store: Store, document: RigDocument, now: int) -> list[SessionDocument]:
    """Store the result of a finished rig and end the sessions of its cameras; return those that exist."""
    if document.finish is None:
        raise ValueError("the rig is not finished")
    store.rigs.publish(document.finish.calibration)
    ended = [_end(store, ending, now) for ending in document.finish.endings]
    return [session for session in ended if session is not None and session.finish is not None]


def _end(store: Store, ending: EndingDocument, now: int) -> SessionDocument | None:
    try:
        return store.sessions.revise(ending.session, now, lambda known: rig_rules.end_session(known, ending))
    except NotFoundError:  # forgotten meanwhile
        return None
