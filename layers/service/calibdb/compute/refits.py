"""Refits: the consensuses of a mode, each computed once from what the index has."""

import functools
import hashlib
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from calibdb.compute.pooled_consensus import count, pool
from calibdb.compute.values import camera_of, views_of
from calibdb.errors import UnavailableError
from calibdb.lookup import well_known_ids
from calibdb.rules.contributed_name import mode_names
from calibdb.rules.votes import with_votes
from calibdb.schema import DISTORTION_MODELS, CalibrationDocument, ConsensusDocument, FittingGroup, ModeViews
from calibdb.service import Service
from calibdb.settings import Thresholds
from calibdb.store import Store, StreamMode
from calibsolver import FIT_VERSION, Board, CalibrationError, DeadlineError
from calibsolver.consensus.comparison import fitting_camera

MAX_ROUNDS = 5  # of one computation, for requests that came meanwhile
WAITS_S = (0.1, 0.2, 0.4, 0.8, 1.6, 2.0, 2.0, 2.0, 2.0, 2.0)  # a caller has 25 s
MAX_PUTS = 5  # while other writers win the conditional put

POOLING_VERSION = 6  # results of other versions are recomputed

Consensuses = dict[str, ConsensusDocument | None]


@dataclass(frozen=True)
class ModeRefit:
    """Refit of one mode in one invocation."""

    service: Service
    mode: StreamMode
    context: Any

    @property
    def _me(self) -> str:
        return str(self.context.aws_request_id)

    @property
    def _until(self) -> int:
        """Unix seconds at which this invocation has ended."""
        left_ms: int = self.context.get_remaining_time_in_millis()
        return self.service.now + math.ceil(left_ms / 1000)

    def for_caller(self, models: Sequence[str]) -> Consensuses:
        """Each model's consensus for a waiting caller; raises UnavailableError."""
        current = self._try_once(models, compute=False)
        if current is not None:
            return current
        with self._alone(models):
            return self._ensure_current(models)

    @contextmanager
    def _alone(self, models: Sequence[str]) -> Iterator[None]:
        """Wait until no other invocation computes the same."""
        leases, name = self.service.store.leases, f"NOW#{'+'.join(models)}"
        for pause in (*WAITS_S, None):
            if leases.take(self.mode, self._me, self.service.now, self._until, name):
                break
            if pause is None:
                raise UnavailableError("This consensus is still being computed; try again.")
            time.sleep(pause)
        try:
            yield
        finally:
            leases.abandon(self.mode, self._me, name)

    def under_lease(self) -> None:
        """Refresh every model's consensus, unless the holder of the lease will; raises UnavailableError."""
        leases, until = self.service.store.leases, self._until
        if not leases.take(self.mode, self._me, self.service.now, until):
            return
        done = False
        try:
            for _ in range(MAX_ROUNDS):
                self._ensure_current(DISTORTION_MODELS)
                done = leases.release(self.mode, self._me)
                if done:
                    return
                leases.take(self.mode, self._me, self.service.now, until)
        finally:
            if not done:
                leases.abandon(self.mode, self._me)
        # The queue delivers this request again.
        raise UnavailableError("New calibrations of this camera keep arriving; try again.")

    def _ensure_current(self, models: Sequence[str]) -> Consensuses:
        for _ in range(MAX_PUTS):
            consensuses = self._try_once(models, compute=True)
            if consensuses is not None:
                return consensuses
        raise UnavailableError("Other computations keep updating this consensus; try again.")

    def _try_once(self, models: Sequence[str], *, compute: bool) -> Consensuses | None:
        """Each model's consensus; None if another writer won, or if a stale one is not to be computed."""
        mode, store, thresholds = self.mode, self.service.store, self.service.settings.thresholds
        # Stored consensuses are read first: each was made from what is read after it, or from less.
        stored: Mapping[str, ConsensusDocument] = {c.distortion_model: c for c in store.consensuses.at(mode)}
        counted = store.calibrations.newest(mode, thresholds.max_calibrations, thresholds.contributor_period)
        if not counted:
            return self._drop(models, stored)
        votes = store.votes.newest(mode, one_per_source=thresholds.contributor_period > 0)
        pooled = pool_digest(POOLING_VERSION, [c.id for c in counted], thresholds, FIT_VERSION)
        basis = input_digest(pooled, [vote.id for vote in votes])
        stale = [model for model in models if model not in stored or stored[model].basis != basis]
        if stale and not compute:
            return None
        read = functools.cache(lambda: store.calibrations.read([c.id for c in counted]))
        read_votes = functools.cache(lambda: store.votes.read(votes) if votes else [])
        sources = frozenset(c.source for c in counted)
        written: dict[str, ConsensusDocument] = {}
        late = False
        for model in stale:
            before = document = stored.get(model)
            groups = None
            try:
                if document is None or document.pooled != pooled:
                    document, groups = pool(mode, read(), model, thresholds, pooled)
                counts = count(document, read_votes(), sources, thresholds)
            except DeadlineError:
                late = True
                break
            document = with_votes(document, counts, basis, thresholds)
            if not store.consensuses.put(document, groups, before.basis if before else None):
                break
            written[model] = document
        # Even if another writer won: it may have looked before the first of these was written.
        if written:
            well_known_ids.refresh_well_known(store, mode.camera_key, thresholds)
        if late:
            raise UnavailableError("This consensus takes longer to compute than is left; try again.")
        known = {**stored, **written}
        return {model: known[model] for model in models} if len(written) == len(stale) else None

    def _drop(self, models: Sequence[str], stored: Mapping[str, ConsensusDocument]) -> Consensuses | None:
        """Drop consensuses without calibrations; None if another writer changed one."""
        store, thresholds = self.service.store, self.service.settings.thresholds
        gone = [stored[model] for model in models if model in stored]
        dropped = all(map(store.consensuses.drop, gone))
        if gone and dropped:
            well_known_ids.refresh_well_known(store, self.mode.camera_key, thresholds)
        return dict.fromkeys(models) if dropped else None


def fitting_group(store: Store, document: ConsensusDocument, seen: ModeViews) -> FittingGroup | None:
    """The only group that fits the views, by its most certain calibration, else None."""
    behind = store.consensuses.groups(document)
    if behind is None or len(behind.groups) < 2:
        return None
    ids = [one for group in behind.groups for one in group]
    documents = {d.id: d for d in store.calibrations.read(ids)}
    stored = ([documents[one] for one in group if one in documents] for group in behind.groups)
    groups = [group for group in stored if group]
    model = document.distortion_model

    def rank(d: CalibrationDocument) -> tuple[bool, float]:
        return d.distortion_model != model, d.fits[d.distortion_model].uncertainty.rms

    known = [min(group, key=rank).answer() for group in groups]
    try:
        views = views_of(Board.from_record(seen.board), seen.views)
        index = fitting_camera([camera_of(one) for one in known], views, model)
    except (CalibrationError, ValueError):
        return None
    if index is None:
        return None
    calibration = known[index].model_copy(update={"calibrations": len(groups[index])})
    names = mode_names([[(d.counted_as, d.mode_name or "") for d in group] for group in groups])
    return FittingGroup(calibration=calibration, groups=len(known), name=names[index])


def pool_digest(method: int, ids: Sequence[str], thresholds: Thresholds, solver_version: str) -> str:
    """Hash what a pooled consensus follows from: SHA-256, in hex; `ids`: of calibrations, the newest first.

    The digest is stored. So the hashed text does not depend on names of fields.
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
    """Hash a pool's digest and the ids of the votes: SHA-256, in hex."""
    return hashlib.sha256(repr((pool_digest, list(votes))).encode()).hexdigest()
