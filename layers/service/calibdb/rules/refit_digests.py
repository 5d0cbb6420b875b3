"""Digests of the inputs of a consensus, by which a refit recognises that it is stale."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from calibdb.settings import Thresholds


def pool_digest(method: int, ids: Sequence[str], thresholds: Thresholds, solver_version: str) -> str:
    """Hash what a pooled consensus follows from: SHA-256, in hex; `ids`: of calibrations, the newest first.

    The digest is stored with each consensus. So the hashed text is written out here: it stays the same when a
    field of the thresholds is renamed.
    """
    t = thresholds
    rule = (
        f"min_calibrations={t.min_calibrations!r}, min_contributors={t.min_contributors!r}, "
        f"min_share={t.min_share!r}, max_unexplained={t.max_unexplained!r}"
    )
    others = (
        f"most_calibrations={t.max_calibrations!r}, contributor_period={t.contributor_period!r}, "
        f"min_votes={t.min_votes!r}, min_doubt={t.min_doubt!r}, max_check_ratio={t.max_check_ratio!r}"
    )
    text = f"({method!r}, {list(ids)!r}, Rule({rule}), Thresholds({rule}, {others}), {solver_version!r})"
    return hashlib.sha256(text.encode()).hexdigest()


def input_digest(pool_digest: str, votes: Sequence[str]) -> str:
    """Hash a pool's digest and the ids of the votes, the newest first: SHA-256, in hex."""
    return hashlib.sha256(repr((pool_digest, list(votes))).encode()).hexdigest()
