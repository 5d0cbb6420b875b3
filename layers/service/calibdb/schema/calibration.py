"""Calibrations as returned and stored."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from calibdb.schema.board import Board
from calibdb.schema.estimate import Estimate
from calibdb.schema.fields import (
    CameraLabel,
    CameraMatrix,
    Coefficients,
    ImgSize,
    LensModel,
    Members,
    Open,
    Platform,
    TrackZoom,
    UnixTime,
    is_none,
)
from calibdb.schema.licence import Licensed

Basis = Literal["consensus", "checked"]
Relation = Literal["scale", "crop", "scale+crop", "neither"]


class Uncertainty(Open):
    """Predicted projection error, px, over the image and inside the part that the boards have shown."""

    rms: float = Field(description="Root mean square, px.")
    max: float = Field(description="At the worst place of the image, px.")
    inside: float | None = Field(
        None,
        description="rms inside the part of the image that the boards have shown, the convex hull of their "
        "corners; null: not recorded.",
    )
    covered: float | None = Field(None, description="Share of the image that this part is, 0 to 1.")


class BoardShape(Open):
    """Shape that a fit found of the board: shares of its longer side, with their standard deviations."""

    sag: float = Field(description="Largest height over the plane.")
    sag_std: float
    stretch: float = Field(description="Error of the print: of its width against its height, or shear.")
    stretch_std: float
    stretch_kind: Literal["wider", "narrower", "skewed"] | None = Field(
        None, exclude_if=is_none, description="What `stretch` measures; missing in older ones."
    )


class Intrinsics(Open):
    """Camera by its size, matrix, distortion and model."""

    img_size: ImgSize
    camera_matrix: CameraMatrix
    distortion_coefficients: Coefficients
    distortion_model: LensModel


class Fitted(Intrinsics):
    """Camera by a fit, and its errors."""

    avg_reprojection_error: float = Field(description="rms over all measurements, px")
    uncertainty: Uncertainty = Field(
        description="Predicted error of a projection over the image, px; null before the first fit."
    )
    systematic: float | None = Field(
        None,
        description="Variance of the parameters that the views show / variance that independent noise of the "
        "corners would give; 1: nothing systematic. null: made before it was estimated.",
    )


class FitRecord(Fitted):
    """One fit of one model, as the solver records it."""

    board_shape: BoardShape | None = Field(
        None, exclude_if=is_none, description="Estimated shape of the board; missing: as drawn."
    )


class Calibration(Fitted):
    """Calibration of a camera: the fit, its camera, and how far to trust it.

    Saved as a file, a rectilinear or rational one loads in WPILib's WPIcal: top-level `camera`, nested
    `camera_matrix`, flat coefficients.
    """

    id: str | None = Field(
        description="Name of the calibration or consensus, for `GET /v1/calibrations/{id}`."
    )
    camera: CameraLabel
    platform: Platform
    zoom: TrackZoom
    calibrations: int = Field(description="Number of agreeing calibrations.")
    contributors: int = Field(description="Number of their contributors.")
    reliable: bool = Field(description="True if enough calibrations agree, or votes confirm it.")
    exact_size: bool = Field(description="false: the closest known size, not the requested one.")
    calibration_time: UnixTime
    spread: float | None = Field(
        None,
        description="px rms over the image between the calibrations that agree, after the best rotation.",
    )
    held_out_error: float | None = Field(
        None, description="rms of views of the camera under a fit without them, px."
    )
    basis: Basis | None = Field(
        None,
        description="`consensus`: enough calibrations agree; `checked`: fewer, and checks confirm them.",
    )

    @classmethod
    def of(
        cls,
        fit: FitRecord,
        *,
        id: str | None,  # noqa: A002 - the contract's name
        camera: str,
        platform: str,
        zoom: float,
        calibration_time: int,
        **consensus: Any,
    ) -> Calibration:
        """Return `fit` with the facts around it; `consensus`: those that differ from one calibration's."""
        facts = {"id": id, "camera": camera, "platform": platform, "zoom": zoom, "reliable": False}
        one = {"calibrations": 1, "contributors": 1, "exact_size": True, "calibration_time": calibration_time}
        return cls(**{**dict(fit), **facts, **one, **consensus})


class Adapted(Open):
    """The calibration, carried to the requested size or zoom."""

    img_size: ImgSize
    zoom: TrackZoom
    camera_matrix: CameraMatrix
    distortion_coefficients: Coefficients
    interpolated: bool = Field(False, description="true: between two calibrated zooms.")


class LookupAnswer(Calibration):
    """Response of a lookup: the stored calibration, and the part for this request."""

    relation: Relation | None = Field(
        None,
        description="Relation of the image at this size to that at the requested size, or, if that has no "
        "calibrations, at the closest other size; verified by calibrations. null: unknown.",
    )
    adapted: Adapted | None = Field(
        None, description="Parameters for the requested size or zoom; null if they could not be verified."
    )
    estimate: Estimate | None = Field(
        None,
        exclude_if=is_none,
        description="Estimate of the camera without its calibrations, if the request asked for it.",
    )


class ReportedCalibration(Calibration, Licensed):
    """One stored calibration, and what its session found out about it."""

    report: Members | None = Field(
        None,
        description="Verdict with reasons, standard deviations, error over the image, residuals.",
    )
    covariance: tuple[tuple[float, ...], ...] | None = Field(
        None,
        description="Covariance of fx, fy, cx, cy and the distortion coefficients, in this order; null: made "
        "before it was kept.",
    )
    board: Board | None = Field(None, description="Board of the capture; null for a consensus.")
    board_shape: BoardShape | None = Field(
        None,
        exclude_if=is_none,
        description="Shape of the board in the fit; missing: as drawn, or a consensus.",
    )
    camera_key: str | None = Field(None, description="Key of the camera, as a search returns it.")
