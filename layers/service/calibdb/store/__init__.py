"""Storage: S3 is the truth, DynamoDB an index rebuilt from it. The only place that knows AWS."""

from calibdb.store.calibrations import Calibrations
from calibdb.store.consensus import Consensuses
from calibdb.store.objects import Objects
from calibdb.store.quotas import Quotas
from calibdb.store.refit import Refit
from calibdb.store.sessions import Sessions
from calibdb.store.store import Store
from calibdb.store.table import Condition, Table
from calibdb.store.tokens import Tokens

__all__ = [
    "Calibrations",
    "Condition",
    "Consensuses",
    "Objects",
    "Quotas",
    "Refit",
    "Sessions",
    "Store",
    "Table",
    "Tokens",
]
