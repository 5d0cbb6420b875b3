"""Storage: S3 is the source of truth, DynamoDB an index derived from it. No other package talks to AWS."""

from calibdb.store.calibrations import Calibrations
from calibdb.store.cameras import CameraRecords, Cameras
from calibdb.store.keys import StreamMode
from calibdb.store.ports import Objects, Table
from calibdb.store.store import Store
from calibdb.store.tokens import Tokens
