"""Quality gates: precisions of sessions, of evidence, and of what checks may confirm.

Errors are in pixels / image width, where the boards were if that is known, else over the image.
"""

from calibdb.schema import Calibration, CalibrationDocument, Uncertainty

TARGET_ERROR_PER_WIDTH = 0.3 / 1280  # predicted rms over the image: the default of a session
MAX_EVIDENCE_PER_WIDTH = 3 / 1280  # stated error of evidence; vague calibrations have little weight
MAX_OWN_ERROR_PER_WIDTH = 3 / 1280  # reprojection error, rms, of a calibration that fits its own views
MAX_CONFIRMABLE_PER_WIDTH = 1.5 / 1280  # stated error of a consensus that checks may confirm
MAX_NOISE_PER_WIDTH = 1e-3  # reprojection error, rms, of a consensus that checks may confirm


def is_evidence(document: CalibrationDocument) -> bool:
    """True if a calibration fits its own views, and is precise where its board was."""
    fit = document.fits.get(document.distortion_model)
    if fit is None:
        return False
    width = document.img_size[0]
    is_fitted = fit.avg_reprojection_error <= MAX_OWN_ERROR_PER_WIDTH * width
    return is_fitted and _stated_error(fit.uncertainty) <= MAX_EVIDENCE_PER_WIDTH * width


def is_confirmable(calibration: Calibration) -> bool:
    """True if a consensus is as precise as a reliable one, and of clean corners."""
    width = calibration.img_size[0]
    return (
        _stated_error(calibration.uncertainty) <= MAX_CONFIRMABLE_PER_WIDTH * width
        and calibration.avg_reprojection_error <= MAX_NOISE_PER_WIDTH * width
    )


def _stated_error(uncertainty: Uncertainty) -> float:
    return uncertainty.rms if uncertainty.inside is None else uncertainty.inside
