"""Checks of a consensus, or a given calibration, on fresh views."""

from typing import Annotated, Literal

from pydantic import Field

from calibdb.schema.board import Board, DescribedBoard
from calibdb.schema.calibration import Calibration, Intrinsics
from calibdb.schema.documents import Votes
from calibdb.schema.fields import Coefficients, Open, StreamKey
from calibdb.schema.licence import Licensed
from calibdb.schema.observed_corners import MAX_VIEWS, ObservedCorners

MAX_COEFFICIENTS = 14  # of a distortion model


Fit = Annotated[
    Literal["fits", "does_not_fit"], Field(description="`fits` if the consensus explains these views.")
]


class GivenCalibration(Intrinsics):
    """A calibration at hand: a document as the service returns it, of which these members count."""

    distortion_coefficients: Annotated[Coefficients, Field(max_length=MAX_COEFFICIENTS)]


class CheckRequest(StreamKey, Licensed):
    """A camera key and fresh views."""

    board: DescribedBoard = Board()
    views: tuple[ObservedCorners, ...] = Field(
        min_length=1, max_length=MAX_VIEWS, description="Views with different tilts."
    )
    calibration: GivenCalibration | None = Field(
        None,
        description="Check this calibration instead of the camera's consensus, in its own model. Nothing is "
        "looked up or stored, and no vote counts.",
    )


class CheckAnswer(Open):
    """Result of a check: whether the stored consensus fits these views."""

    fits: Fit
    error: float = Field(description="px rms of the views under the consensus; only poses are fitted.")
    expected: float = Field(description="px rms of these views under their own fit.")
    counted: bool = Field(
        description="True if it counts as a vote: a contributor has one per day, camera and size, and none "
        "for a camera that they calibrated; ambiguous views do not count."
    )
    votes: Votes = Field(description="Votes on the current consensus, including this one.")
    calibration: Calibration = Field(description="The current consensus, reliable or not.")


class ComparisonAnswer(Open):
    """Result of a check of a given calibration: how far it is from a fit of these views."""

    fits: Fit
    error: float | None = Field(
        description="px rms of the views under the calibration; null: it explains none."
    )
    expected: float = Field(description="px rms of these views under a camera fitted to them.")
    drift: float | None = Field(
        description="px rms over the image between the projections of the calibration and that camera, after "
        "the best rotation; null: they share less than half of the image."
    )
    drift_uncertainty: float | None = Field(
        description="px rms, standard deviation of that camera's projections; null: not known."
    )
    views: int = Field(description="How many of the views count.")
