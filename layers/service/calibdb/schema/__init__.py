"""Schema: requests, responses and stored documents, as pydantic models with their bounds."""

from calibdb.schema.board import DICTIONARIES, Board
from calibdb.schema.calibration import (
    Adapted,
    Calibration,
    FitRecord,
    LookupAnswer,
    ReportedCalibration,
    Uncertainty,
)
from calibdb.schema.cameras import (
    CameraDetail,
    CameraList,
)
from calibdb.schema.checks import CheckAnswer, CheckRequest, ComparisonAnswer, GivenCalibration
from calibdb.schema.documents import (
    CalibrationDocument,
    ConsensusDocument,
    EstimateDocument,
    Finish,
    GroupsDocument,
    PriorDocument,
    SessionDocument,
    ShapeDocument,
    ViewDocument,
    VoteDocument,
    Votes,
)
from calibdb.schema.export import FORMATS, ConvertRequest, ExportQuery
from calibdb.schema.fields import DISTORTION_MODELS
from calibdb.schema.health import DeepHealth, HealthProblem
from calibdb.schema.lookup import LookupRequest, Miss, NoCalibration, UnknownCamera
from calibdb.schema.managed_token import (
    ManagedToken,
    RotationRequest,
    TokenChange,
    TokenCreated,
    TokenRequest,
    TokenRotated,
    UsageAnswer,
)
from calibdb.schema.problem import LookupProblem, Problem
from calibdb.schema.refit import (
    BackfillAnswer,
    BackfillBatch,
    FittingGroup,
    ModeViews,
    NewAlias,
    RefitAnswer,
    RefitRequest,
)
from calibdb.schema.rig import MomentRequest, RigOpened, RigRequest, RigResult, RigState
from calibdb.schema.rig_documents import (
    RigCalibrationDocument,
    RigDocument,
    RigEstimateDocument,
    RigFinish,
)
from calibdb.schema.session import (
    BatchAnswer,
    BatchRequest,
    Health,
    LicenceRequest,
    Pose,
    SessionOpened,
    SessionRequest,
    SessionState,
    Track,
    ViewAnswer,
    ViewRequest,
    ViewState,
)
