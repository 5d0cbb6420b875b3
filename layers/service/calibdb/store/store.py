"""All of storage, put together for one deployment."""

from __future__ import annotations

from dataclasses import dataclass

from calibdb.settings import Settings
from calibdb.store.aliases import Aliases
from calibdb.store.calibrations import Calibrations
from calibdb.store.cameras import Cameras, Consensuses
from calibdb.store.leases import Leases
from calibdb.store.miss_counts import MissCounts
from calibdb.store.ports import Storage
from calibdb.store.priors import Priors
from calibdb.store.proofs import Proofs
from calibdb.store.quotas import Quotas
from calibdb.store.refit import Refit
from calibdb.store.rigs import RigCodes, Rigs
from calibdb.store.storage import storage_of
from calibdb.store.tokens import Tokens
from calibdb.store.versions import Sessions
from calibdb.store.votes import Votes


@dataclass(frozen=True)
class Store:
    """All stores of the service."""

    tokens: Tokens
    quotas: Quotas
    sessions: Sessions
    rigs: Rigs
    rig_codes: RigCodes
    calibrations: Calibrations
    cameras: Cameras
    consensuses: Consensuses
    votes: Votes
    priors: Priors
    leases: Leases
    aliases: Aliases
    refit: Refit
    proofs: Proofs
    miss_counts: MissCounts

    @classmethod
    def of(cls, settings: Settings) -> Store:
        """Stores of a function with these settings."""
        return cls.over(storage_of(settings))

    @classmethod
    def over(cls, storage: Storage) -> Store:
        """Stores of a storage."""
        table, objects = storage.table, storage.objects
        return cls(
            tokens=Tokens(table, objects),
            quotas=Quotas(table),
            sessions=Sessions(table, objects),
            rigs=Rigs(table, objects),
            rig_codes=RigCodes(table),
            calibrations=Calibrations(table, objects),
            cameras=Cameras(table),
            consensuses=Consensuses(table),
            votes=Votes(table, objects),
            priors=Priors(table, objects),
            leases=Leases(table),
            miss_counts=MissCounts(table),
            proofs=Proofs(table, storage.jobs),
            aliases=Aliases(table),
            refit=Refit(storage.jobs),
        )
