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
    CameraEntry,
    CameraList,
    CameraMember,
    CameraMode,
    CameraSize,
    CamerasRequest,
)
from calibdb.schema.checks import CheckAnswer, CheckRequest, CheckView
from calibdb.schema.conversion import ConvertRequest
from calibdb.schema.documents import (
    CalibrationDocument,
    ConsensusDocument,
    EstimateDocument,
    Finish,
    GroupsDocument,
    SessionDocument,
    ViewDocument,
    VoteDocument,
    Votes,
)
from calibdb.schema.estimate import Estimate
from calibdb.schema.export import FORMATS, ExportQuery
from calibdb.schema.fields import DISTORTION_MODELS
from calibdb.schema.health import DeepHealth, HealthProblem
from calibdb.schema.lookup import LookupRequest, Miss, NoCalibration, UnknownCamera
from calibdb.schema.managed_token import (
    HourlyLimits,
    ManagedToken,
    RotationRequest,
    TokenChange,
    TokenCreated,
    TokenFacts,
    TokenRequest,
    TokenRotated,
    UsageAnswer,
)
from calibdb.schema.prior import PriorDocument
from calibdb.schema.problem import FieldProblem, LookupProblem, Problem
from calibdb.schema.refit import BackfillAnswer, BackfillBatch, NewAlias, RefitAnswer, RefitRequest
from calibdb.schema.rig import MomentRequest, RigOpened, RigRequest, RigResult, RigState
from calibdb.schema.rig_documents import (
    RigCalibrationDocument,
    RigDocument,
    RigEstimateDocument,
    RigFinish,
)
from calibdb.schema.session import (
    Health,
    Pose,
    SessionOpened,
    SessionRequest,
    SessionState,
    Track,
    ViewAnswer,
    ViewRequest,
    ViewState,
)
from calibdb.schema.token import TokenDocument

__all__ = [
    "DICTIONARIES",
    "DISTORTION_MODELS",
    "FORMATS",
    "Adapted",
    "BackfillAnswer",
    "BackfillBatch",
    "Board",
    "Calibration",
    "CalibrationDocument",
    "CameraDetail",
    "CameraEntry",
    "CameraList",
    "CameraMember",
    "CameraMode",
    "CameraSize",
    "CamerasRequest",
    "CheckAnswer",
    "CheckRequest",
    "CheckView",
    "ConsensusDocument",
    "ConvertRequest",
    "DeepHealth",
    "Estimate",
    "EstimateDocument",
    "ExportQuery",
    "FieldProblem",
    "Finish",
    "FitRecord",
    "GroupsDocument",
    "Health",
    "HealthProblem",
    "HourlyLimits",
    "LookupAnswer",
    "LookupProblem",
    "LookupRequest",
    "ManagedToken",
    "Miss",
    "MomentRequest",
    "NewAlias",
    "NoCalibration",
    "Pose",
    "PriorDocument",
    "Problem",
    "RefitAnswer",
    "RefitRequest",
    "ReportedCalibration",
    "RigCalibrationDocument",
    "RigDocument",
    "RigEstimateDocument",
    "RigFinish",
    "RigOpened",
    "RigRequest",
    "RigResult",
    "RigState",
    "RotationRequest",
    "SessionDocument",
    "SessionOpened",
    "SessionRequest",
    "SessionState",
    "TokenChange",
    "TokenCreated",
    "TokenDocument",
    "TokenFacts",
    "TokenRequest",
    "TokenRotated",
    "Track",
    "Uncertainty",
    "UnknownCamera",
    "UsageAnswer",
    "ViewAnswer",
    "ViewDocument",
    "ViewRequest",
    "ViewState",
    "VoteDocument",
    "Votes",
]
