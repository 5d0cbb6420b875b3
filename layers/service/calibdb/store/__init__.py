"""Storage: S3 is the source of truth, DynamoDB an index derived from it. No other package talks to AWS."""

from calibdb.store.aliases import Alias, Aliases
from calibdb.store.calibrations import Calibrations
from calibdb.store.cameras import CameraRecords, Cameras, Consensuses
from calibdb.store.keys import StreamMode
from calibdb.store.leases import Leases
from calibdb.store.ports import Condition, Objects, Table
from calibdb.store.priors import Priors
from calibdb.store.proofs import Proofs
from calibdb.store.quotas import Quotas
from calibdb.store.refit import Refit
from calibdb.store.rig_codes import RigCodes
from calibdb.store.rigs import Rigs
from calibdb.store.sessions import Sessions
from calibdb.store.store import Store
from calibdb.store.tokens import Tokens
from calibdb.store.votes import IndexedVote, Votes

__all__ = [
    "Alias",
    "Aliases",
    "Calibrations",
    "CameraRecords",
    "Cameras",
    "Condition",
    "Consensuses",
    "IndexedVote",
    "Leases",
    "Objects",
    "Priors",
    "Proofs",
    "Quotas",
    "Refit",
    "RigCodes",
    "Rigs",
    "Sessions",
    "Store",
    "StreamMode",
    "Table",
    "Tokens",
    "Votes",
]
