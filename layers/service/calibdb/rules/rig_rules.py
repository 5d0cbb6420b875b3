"""Rules of a rig, as pure functions from one rig document to the next.

Position 0 is the leader's, who made the rig. The leader opens a moment before cameras send views of it. An
undone moment is never opened again. A finished rig no longer changes.
"""

import hashlib
import hmac
from collections.abc import Collection, Sequence

from calibdb.errors import ConflictError, ForbiddenError, InvalidError
from calibdb.rules import session_result, session_rules
from calibdb.rules.session_rules import MIN_RECORDED_VIEWS
from calibdb.schema import (
    RigDocument,
    RigFinish,
    RigRequest,
    SessionDocument,
    ViewDocument,
    ViewRequest,
)
from calibdb.schema.board import Board
from calibdb.schema.membership import RigJoin, RigMembership
from calibdb.schema.rig_documents import (
    CodeDocument,
    EndingDocument,
    MemberDocument,
    MomentDocument,
    SkipsDocument,
)

CODE_ALPHABET = "23456789ABCDEFGHJKMNPQRSTUVWXYZ"
CODE_LENGTH = 6
CODE_LIFETIME_S = 900
MAX_CODES = 8  # per rig at a time
MAX_MOMENTS = 100
MAX_SKIPPED_POSES = 8
ABANDONED_S = 60  # until a position is free again whose session was never started
MIN_AGREEING_VIEWS = MIN_RECORDED_VIEWS
_ID_DIGITS = 32


def rig_id(secret: str, session: SessionDocument) -> str:
    """Id of a session's rig, which cannot be guessed."""
    text = f"rig\n{session.session}/{session.first_version}"
    return hmac.new(secret.encode(), text.encode(), hashlib.sha256).hexdigest()[:_ID_DIGITS]


def code_of(random: str) -> str:
    """Join code of a random number, in hex, of 64 bits."""
    number, letters = int(random, 16), []
    for _ in range(CODE_LENGTH):
        number, digit = divmod(number, len(CODE_ALPHABET))
        letters.append(CODE_ALPHABET[digit])
    return "".join(letters)


def code_digest(secret: str, code: str) -> str:
    """Keyed hash of a code, regardless of case, spaces and hyphens."""
    text = "".join(c for c in code.upper() if c not in " -")
    return hmac.new(secret.encode(), f"rig code\n{text}".encode(), hashlib.sha256).hexdigest()


def begin(request: RigRequest, rig: str, session: SessionDocument, contributor: str, now: int) -> RigDocument:
    """Document of a rig whose camera 0 is that of the session."""
    first = MemberDocument(session=session.session, contributor=contributor, joined=now)
    return RigDocument(
        rig=rig,
        started=now,
        board=session.board,
        square_size=request.square_size,
        members=(first, *(None,) * (request.cameras - 1)),
    )


def with_lead(session: SessionDocument, rig: str, source: str | None = None) -> SessionDocument | None:
    """Make a session camera 0 of its rig; None if it is. Raises ConflictError."""
    membership = RigMembership(id=rig, position=0)
    if session.rig == membership:
        return None
    if session.rig is not None:
        raise ConflictError("The session is in a rig that another session made.", kind="in-rig")
    if session.views or session.finish is not None:
        raise ConflictError(
            "The session has views of its own already; make the rig before the first view.", kind="has-views"
        )
    return session.model_copy(update={"rig": membership, "source": source, "target": None})


def require_same_start(document: RigDocument, request: RigRequest) -> None:
    """Raise ConflictError unless `request` would have made the rig."""
    if (len(document.members), document.square_size) != (request.cameras, request.square_size):
        raise ConflictError(
            "The session has a rig with another number of cameras, or another square size.",
            kind="other-content",
        )


def require_linking_board(board: Board) -> None:
    """Raise InvalidError for a board that cannot link cameras."""
    if board.is_half_turn_symmetric:
        raise InvalidError.field(
            "board",
            "a chessboard that looks the same after half a turn cannot link cameras; take a ChArUco board, "
            "or a chessboard with an even and an odd number of squares",
        )


def require_open(document: RigDocument) -> None:
    """Raise ConflictError if the rig is finished."""
    if document.finish is not None:
        raise ConflictError("The rig is finished and accepts no more changes.", kind="rig-finished")


def require_leader(document: RigDocument, sid: str) -> None:
    """Raise ForbiddenError unless the session is that of camera 0."""
    if document.leader != sid:
        raise ForbiddenError(
            "Only the session of camera 0, which made the rig, may do this.", kind="not-leader"
        )


def _position_of(document: RigDocument, sid: str) -> int | None:
    return next((i for i, m in enumerate(document.members) if m is not None and m.session == sid), None)


def join(
    document: RigDocument,
    wanted: RigJoin,
    board: Board,
    member: MemberDocument,
    abandoned: Collection[int] = (),
) -> tuple[RigDocument | None, RigMembership]:
    """Add a member; return the changed document if any, and its place. Raises InvalidError."""
    if document.finish is not None:
        raise _cannot_join(wanted, "the rig is finished")
    if board != document.board:
        raise InvalidError.field("board", "all cameras of a rig see one board, and the rig has another")
    current = _position_of(document, member.session)
    if current is not None:
        if wanted.position not in (None, current):
            raise InvalidError.field("rig.position", f"this session has position {current}")
        return None, RigMembership(id=document.rig, position=current)
    count = len(document.members)
    free = [i for i in range(1, count) if document.members[i] is None or i in abandoned]
    if not free:
        raise _cannot_join(wanted, f"The rig has all its {count} cameras.", "rig.position")
    position = free[0] if wanted.position is None else wanted.position
    if not 1 <= position < count:
        raise InvalidError.field("rig.position", f"must be 1 to {count - 1}: camera 0 made the rig")
    if position not in free:
        raise InvalidError.field("rig.position", f"taken; free: {', '.join(map(str, free))}")
    members = (*document.members[:position], member, *document.members[position + 1 :])
    joined = document.model_copy(update={"members": members})
    return joined, RigMembership(id=document.rig, position=position)


def _cannot_join(wanted: RigJoin, detail: str, field: str = "rig.id") -> InvalidError:
    """Error of a rig that cannot be joined; for codes the same for every reason."""
    return wrong_code() if wanted.code is not None else InvalidError.field(field, detail)


def with_code(document: RigDocument, code: CodeDocument, now: int) -> tuple[RigDocument, Sequence[str]]:
    """Add a join code; return the document, and the digests of removed codes."""
    valid = [one for one in document.codes if one.until > now]
    codes = [*valid, code][-MAX_CODES:]
    gone = [one.digest for one in document.codes if one not in codes]
    return document.model_copy(update={"codes": tuple(codes)}), gone


def with_moment(document: RigDocument, moment: str, now: int) -> RigDocument | None:
    """Open a moment; None if it is open. Raises ConflictError."""
    require_open(document)
    known = _moment(document, moment)
    if known is not None:
        if known.undone:
            raise _moment_undone()
        return None
    if len(document.moments) >= MAX_MOMENTS:
        raise ConflictError(f"A rig has at most {MAX_MOMENTS} moments; finish it.", kind="rig-full")
    opened = (*document.moments, MomentDocument(id=moment, opened=now))
    return document.model_copy(update={"moments": opened})


def without_moment(document: RigDocument, moment: str) -> RigDocument | None:
    """Undo a moment; None if it is undone. Raises ConflictError or InvalidError."""
    require_open(document)
    known = _moment(document, moment)
    if known is None:
        raise InvalidError.field("moment", "this rig never opened it")
    if known.undone:
        return None
    undone = known.model_copy(update={"undone": True})
    changed = tuple(undone if one is known else one for one in document.moments)
    return document.model_copy(update={"moments": changed})


def _moment(document: RigDocument, moment: str | None) -> MomentDocument | None:
    return next((one for one in document.moments if one.id == moment), None)


def with_skip(document: RigDocument, basis: str, pose: Sequence[float] | None) -> RigDocument:
    """Note that the target after the views `basis` is not wanted."""
    skips = document.skips if document.skips and document.skips.basis == basis else SkipsDocument(basis=basis)
    poses = skips.poses if pose is None else (*skips.poses, tuple(pose))[-MAX_SKIPPED_POSES:]
    changed = skips.model_copy(update={"poses": poses, "missed": skips.missed + (pose is None)})
    return document.model_copy(update={"skips": changed})


def with_finish(document: RigDocument, decided: RigDocument, finish: RigFinish) -> RigDocument:
    """End the rig; raises ConflictError if it changed since `decided`."""
    if (document.members, document.moments) != (decided.members, decided.moments):
        raise ConflictError("The rig changed meanwhile; send this request again.", kind="overtaken")
    return document.model_copy(update={"finish": finish, "skips": None, "codes": ()})


def require_moment(document: RigDocument | None, session: SessionDocument, view: ViewDocument) -> None:
    """Check the moment of a new view; raises InvalidError or ConflictError."""
    if document is None:
        raise InvalidError.field("moment", "the rig of this session was deleted")
    if _position_of(document, session.session) is None:
        raise InvalidError.field("moment", "this session's place in the rig was given to another")
    require_open(document)
    moment = _moment(document, view.moment)
    if moment is None:
        raise InvalidError.field("moment", "the leader of the rig has not opened it")
    if moment.undone:
        raise _moment_undone()


def is_replay(session: SessionDocument, view: ViewDocument) -> bool:
    """True if `view` replays one that this session of a rig has; False if its moment is open.

    Raises ConflictError if the moment carries another view.
    """
    known = next((one for one in session.views if one.moment == view.moment), None)
    return session_rules.is_replay(session, known, view, "This camera has another view of the moment.")


def ending_of(ended: SessionDocument) -> EndingDocument:
    """End of a session, as its rig stores it."""
    if ended.finish is None:
        raise ValueError("the session has not ended")
    views = tuple((view.index, view.rms, view.set_aside) for view in ended.views)
    return EndingDocument(session=ended.session, estimate=ended.estimate, finish=ended.finish, views=views)


def end_session(session: SessionDocument, ending: EndingDocument) -> SessionDocument | None:
    """End a session as its rig ended, without views that came too late.

    None if it has ended, or was restarted.
    """
    if session.finish is not None or session_result.calibration_id(session) != ending.finish.calibration_id:
        return None
    statuses = {index: {"rms": rms, "set_aside": aside} for index, rms, aside in ending.views}
    views = [view.model_copy(update=statuses[view.index]) for view in session.views if view.index in statuses]
    ended = {"views": tuple(views), "estimate": ending.estimate, "finish": ending.finish, "doubted": ()}
    return session.model_copy(update=ended)


def sent_view(session: SessionDocument, request: ViewRequest) -> ViewDocument:
    """View that was sent; one of a rig's takes the next index. Raises InvalidError."""
    index = request.index
    if session.rig is not None:
        if request.moment is None:
            raise InvalidError.field("moment", "a view of a session in a rig names its moment")
        index = session.next_index
    elif request.moment is not None:
        raise InvalidError.field("moment", "the session is in no rig")
    elif index is None:
        raise InvalidError.field("index", "Field required")
    return ViewDocument(index=index, ids=request.ids, points=request.points, moment=request.moment)


def wrong_code() -> InvalidError:
    """Error of a code without a rig."""
    text = "no rig can be joined by this code; codes last 15 minutes: ask for a new one"
    return InvalidError.field("rig.code", text)


def _moment_undone() -> ConflictError:
    return ConflictError("This moment was undone.", kind="moment-undone")


def in_rig() -> ConflictError:
    """Error of a change that only the rig may make."""
    return ConflictError("The session is in a rig: undo moments and finish through the rig.", kind="in-rig")
