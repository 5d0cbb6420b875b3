"""Requests, answers, and the documents that are stored: all that crosses a boundary, with its bounds."""

from calibdb.schema.board import DICTIONARIES, Board
from calibdb.schema.calibration import Calibration, FitRecord, Uncertainty
from calibdb.schema.documents import (
    CalibrationDocument,
    ConsensusDocument,
    EstimateDocument,
    Finish,
    SessionDocument,
    ViewDocument,
)
from calibdb.schema.fields import DISTORTION_MODELS
from calibdb.schema.lookup import LookupRequest, Miss
from calibdb.schema.problem import FieldProblem, LookupProblem, Problem
from calibdb.schema.refit import RefitAnswer, RefitRequest
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
    "Board",
    "Calibration",
    "CalibrationDocument",
    "ConsensusDocument",
    "EstimateDocument",
    "FieldProblem",
    "Finish",
    "FitRecord",
    "Health",
    "LookupProblem",
    "LookupRequest",
    "Miss",
    "Pose",
    "Problem",
    "RefitAnswer",
    "RefitRequest",
    "SessionDocument",
    "SessionOpened",
    "SessionRequest",
    "SessionState",
    "TokenDocument",
    "Track",
    "Uncertainty",
    "ViewAnswer",
    "ViewDocument",
    "ViewRequest",
    "ViewState",
]
