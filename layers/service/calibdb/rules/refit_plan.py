"""Plan of a refit: which stored consensuses are stale, and what each of them needs.

A consensus is identified by the digests of what it was computed from. Nothing here reads or writes storage.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from calibdb.schema import ConsensusDocument


@dataclass(frozen=True)
class Step:
    """Step of a refit: the action that one model's consensus needs.

    Attributes
    ----------
    model
        Name of the distortion model.
    stored
        The consensus that is stored, None where there is none.
    action
        `keep`: nothing has changed. `recount`: only the votes have. `pool`: the calibrations are pooled anew,
        and the votes counted.
    """

    model: str
    stored: ConsensusDocument | None
    action: Literal["keep", "recount", "pool"]


def plan_refit(
    models: Sequence[str], stored: Mapping[str, ConsensusDocument], pool_digest: str, input_digest: str
) -> list[Step]:
    """Plan the refit of `models`, in their order.

    Parameters
    ----------
    stored
        Consensuses by model.
    pool_digest
        Of the calibrations that count, and of the rules and the code that pool them.
    input_digest
        Of these and the votes: everything that a consensus is computed from.
    """
    return [_step(model, stored.get(model), pool_digest, input_digest) for model in models]


def _step(model: str, stored: ConsensusDocument | None, pool_digest: str, input_digest: str) -> Step:
    if stored is not None and stored.basis == input_digest:
        return Step(model, stored, "keep")
    if stored is not None and stored.pooled == pool_digest:
        return Step(model, stored, "recount")
    return Step(model, stored, "pool")


def digest(*parts: object) -> str:
    """Return the SHA-256 of the values' representations, in hex."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()
