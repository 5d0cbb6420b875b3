"""Plan of a refit: which stored consensuses are stale, and what each of them needs.

A consensus is identified by the digests of its inputs.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from calibdb.schema import ConsensusDocument
from calibdb.settings import Thresholds


@dataclass(frozen=True)
class Step:
    """Step of a refit: the action that one model's consensus needs.

    `keep`: nothing has changed. `recount`: only the votes have. `pool`: the calibrations are repooled, and
    the votes counted.
    """

    model: str
    stored: ConsensusDocument | None
    action: Literal["keep", "recount", "pool"]


def plan_refit(
    models: Sequence[str], stored: Mapping[str, ConsensusDocument], pool_digest: str, input_digest: str
) -> list[Step]:
    """Plan the refit of `models`, in their order; `stored`: consensuses by model."""
    steps = []
    for model in models:
        document = stored.get(model)
        if document is not None and document.basis == input_digest:
            steps.append(Step(model, document, "keep"))
        elif document is not None and document.pooled == pool_digest:
            steps.append(Step(model, document, "recount"))
        else:
            steps.append(Step(model, document, "pool"))
    return steps


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
