"""Quality gates: the precision a session aims at, that may count, and that checks may confirm."""

from __future__ import annotations

from calibdb.schema import Calibration, CalibrationDocument

TARGET_ERROR_PER_WIDTH = (
    0.3 / 1280
)  # px of predicted rms over the image, a pixel of its width; a session's default
MAX_UNCERTAINTY_RATIO = 2.0  # times that, up to which a calibration counts
MAX_NOISE_PER_WIDTH = (
    1e-3  # px rms of the corners, a pixel of the image's width, up to which checks may confirm
)


def is_precise(document: CalibrationDocument) -> bool:
    """Tell whether a calibration counts where others rely on it.

    A session may ask for less than the default, or end at its limit of views far from what it asked for: it
    is of use to whoever made it, and what it knows of the camera is too little to support others, or to hide
    among them.
    """
    fit = document.fits.get(document.distortion_model)
    most = MAX_UNCERTAINTY_RATIO * TARGET_ERROR_PER_WIDTH * document.img_size[0]
    return document.target_error <= most and fit is not None and fit.uncertainty.rms <= most


def is_confirmable(calibration: Calibration) -> bool:
    """Tell whether a consensus is as sure as a calibration that counts, and of clean corners.

    Its uncertainty holds the differences between specimens, which one calibration cannot know.
    """
    width = calibration.img_size[0]
    return (
        calibration.uncertainty.rms <= MAX_UNCERTAINTY_RATIO * TARGET_ERROR_PER_WIDTH * width
        and calibration.avg_reprojection_error <= MAX_NOISE_PER_WIDTH * width
    )
