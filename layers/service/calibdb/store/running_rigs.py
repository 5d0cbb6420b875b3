"""Running rigs and the sessions of their cameras."""

from dataclasses import dataclass

from calibdb.errors import InvalidError, NotFoundError, TooManyError
from calibdb.rules import rig_rules, session_rules
from calibdb.schema import (
    RigDocument,
    RigOpened,
    RigRequest,
    SessionDocument,
    ViewDocument,
)
from calibdb.schema.membership import RigJoin
from calibdb.schema.rig_documents import CodeDocument
from calibdb.store.rigs import GUESS_WINDOW_S, MAX_GUESSES, is_rig_id
from calibdb.store.store import Store


def abandoned_positions(store: Store, document: RigDocument, before: int) -> list[int]:
    """List the positions of members whose session was forgotten, or not started until a unix time."""
    positions = []
    for position, member in enumerate(document.members):
        if position and member is not None:
            head = store.sessions.head(member.session)
            if head.forgotten if head else member.joined < before:
                positions.append(position)
    return positions


@dataclass(frozen=True)
class Lead:
    """Caller that makes a rig; contributor and source as keyed hashes."""

    session: str
    contributor: str
    source: str


def create(store: Store, lead: Lead, request: RigRequest, code: str, secret: str, now: int) -> RigOpened:
    """Create the rig of a session, unless it exists, and let cameras join by a code.

    Raises ConflictError or InvalidError if the session cannot lead a rig.
    """
    session = store.sessions.get(lead.session)
    rig_id = rig_rules.rig_id(secret, session)
    rig_rules.with_lead(session, rig_id)
    rig_rules.require_linking_board(session.board)
    document, _ = store.rigs.start(
        rig_id, now, lambda _: rig_rules.begin(request, rig_id, session, lead.contributor, now)
    )
    rig_rules.require_same_start(document, request)
    rig_rules.require_open(document)
    store.sessions.revise(lead.session, now, lambda known: rig_rules.with_lead(known, rig_id, lead.source))
    until = now + rig_rules.CODE_LIFETIME_S
    stored = CodeDocument(digest=rig_rules.code_digest(secret, code), until=until)
    for digest in store.rigs.update(rig_id, now, lambda known: rig_rules.with_code(known, stored, now)):
        store.rig_codes.remove(digest)
    store.rig_codes.put(stored.digest, rig_id, until)
    return RigOpened(rig_id=rig_id, join_code=code, expires_at=until)


def named(store: Store, wanted: RigJoin, source: str, secret: str, now: int) -> str:
    """Id of the rig that a code or an id names; wrong codes are counted by source.

    Raises InvalidError or TooManyError.
    """
    if wanted.code is None:
        if not is_rig_id(wanted.id or ""):
            raise InvalidError.field("rig.id", "there is no running rig with this id")
        return wanted.id or ""
    if not store.rig_codes.count_guess(source, now):
        raise TooManyError(
            GUESS_WINDOW_S - now % GUESS_WINDOW_S,
            f"More than {MAX_GUESSES} wrong join codes came from here; retry after the time in Retry-After.",
        )
    rig_id = store.rig_codes.find(rig_rules.code_digest(secret, wanted.code), now)
    if rig_id is None:
        raise rig_rules.wrong_code()
    store.rig_codes.uncount_guess(source, now)
    return rig_id


def open_moment(store: Store, rig_id: str, leader: str, moment: str, now: int) -> None:
    """Open a moment; raises ForbiddenError, ConflictError."""

    def change(document: RigDocument) -> RigDocument | None:
        rig_rules.require_leader(document, leader)
        return rig_rules.with_moment(document, moment, now)

    store.rigs.revise(rig_id, now, change)


def forget(store: Store, rig_id: str, leader: str, now: int) -> None:
    """Forget a running rig and the sessions of its cameras; raises NotFoundError, ForbiddenError."""
    document = store.rigs.find(rig_id)
    if document is not None:
        rig_rules.require_leader(document, leader)
        rig_rules.require_open(document)
        for code in document.codes:
            store.rig_codes.remove(code.digest)
        for member in filter(None, document.members):
            session = store.sessions.find(member.session)
            # A session that left may be a camera of another rig by now.
            if session is not None and session.rig and session.rig.id == rig_id:
                store.sessions.forget(member.session, now)
    if not store.rigs.forget(rig_id, now):
        raise NotFoundError("There is no rig with this id.", kind="no-rig")


def is_replay(store: Store, document: SessionDocument, view: ViewDocument) -> bool:
    """True if the session has the view; False if it may be added."""
    if document.rig is None:
        return session_rules.is_idempotent_replay(document, view)
    if rig_rules.is_replay(document, view):
        return True
    rig_rules.require_moment(store.rigs.find(document.rig.id), document, view)
    return False
