"""Running rigs with the sessions of their cameras, and what is computed of them once for each state."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from calibdb.errors import ConflictError
from calibdb.rules.rig_state import Rig
from calibdb.schema import RigDocument, RigEstimateDocument, SessionDocument
from calibdb.store.ports import READERS
from calibdb.store.store import Store

TOO_SLOW = "These moments take longer to compute than a request may; undo some of them."
Compute = Callable[[dict[str, Any]], dict[str, Any]]


def head_tag(store: Store, rig_id: str, solver: str) -> str | None:
    """Return the tag of a running rig's state from the index alone, None if it does not run."""
    head = store.rigs.head(rig_id)
    if head is None or head.forgotten:
        return None
    names = head.facts.get("sessions")
    versions = [_version(store, name) for name in (names if isinstance(names, list) else [])]
    return _tag(solver, head.version, versions)


def load(store: Store, rig_id: str, solver: str) -> tuple[Rig, str]:
    """Read a running rig and the tag of its state; raises NotFoundError."""
    document, version = store.rigs.get_version(rig_id)
    sessions = _sessions(store, document)
    versions = [version for _, version in sessions]
    return Rig(document, tuple(session for session, _ in sessions)), _tag(solver, version, versions)


def ensure_estimate(store: Store, rig: Rig, solver: str, compute: Compute) -> RigEstimateDocument:
    """Return fit and target of a rig, computed now if they are not stored yet.

    Raises ConflictError where `compute` said, now or before, that these moments take too long (`too_slow`).
    """
    basis = rig.basis(solver)
    digest = rig.digest(basis)
    known = store.rigs.estimate(rig.document.rig, digest)
    if known is None:
        known = RigEstimateDocument.model_validate(compute(rig.solver_record(basis)))
        store.rigs.keep_estimate(rig.document.rig, digest, known)
    if known.too_slow:
        raise ConflictError(TOO_SLOW, kind="too-slow")
    return known


def abandoned_positions(store: Store, document: RigDocument, before: int) -> list[int]:
    """List the positions of members whose session was forgotten, or not started until a unix time."""
    found = []
    for position, member in enumerate(document.members):
        if position and member is not None:
            head = store.sessions.head(member.session)
            if (head is None and member.joined < before) or (head is not None and head.forgotten):
                found.append(position)
    return found


def _sessions(store: Store, document: RigDocument) -> list[tuple[SessionDocument | None, int]]:
    """Read the sessions of a rig by position, with their versions."""
    names = [member.session if member else "" for member in document.members]

    def read(name: str) -> tuple[SessionDocument | None, int]:
        found = store.sessions.find_version(name) if name else None
        # A session restarted without the rig is not part of it.
        if found is None or found[0].rig is None or found[0].rig.id != document.rig:
            return None, found[1] if found else 0
        return found

    with ThreadPoolExecutor(min(READERS, len(names))) as readers:
        return list(readers.map(read, names))


def _version(store: Store, name: str) -> int:
    head = store.sessions.head(name) if name else None
    return 0 if head is None or head.forgotten else head.version


def _tag(solver: str, version: int, versions: Sequence[int]) -> str:
    text = "\n".join(map(str, (solver, version, *versions)))
    return f'"{hashlib.sha256(text.encode()).hexdigest()[:32]}"'
