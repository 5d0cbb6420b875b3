"""Documents of made-up cameras as the database stores them, made without a capture."""

from calibdb.camera_key import camera_key
from calibdb.schema import (
    Board,
    Calibration,
    CalibrationDocument,
    ConsensusDocument,
    FitRecord,
    Track,
    Uncertainty,
    ViewDocument,
    VoteDocument,
)
from calibdb.store import StreamMode

LINUX = "X11; Linux x86_64"
C920 = "HD Pro Webcam C920 (046d:082d)"
LENS = (-0.12, 0.05, 0.0005, -0.0004, 0.0)
Size = tuple[int, int]


def fit(
    img_size: Size = (1280, 720),
    f: float = 950.0,
    center: tuple[float, float] | None = None,
    distortion: tuple[float, ...] = LENS,
    model: str = "rectilinear",
    uncertainty: float = 0.2,
) -> FitRecord:
    x, y = center or ((img_size[0] - 1) / 2, (img_size[1] - 1) / 2)
    return FitRecord(
        img_size=img_size,
        camera_matrix=((f, 0, x), (0, f, y), (0, 0, 1)),
        distortion_coefficients=distortion,
        distortion_model=model,
        avg_reprojection_error=0.2,
        uncertainty=Uncertainty(rms=uncertainty, max=2 * uncertainty),
    )


def consensus(
    of: FitRecord | None = None,
    *,
    camera: str = C920,
    platform: str = LINUX,
    key: str | None = None,
    zoom: float = 0.0,
    reason: str | None = None,
    calibrations: int = 5,
    time: int = 0,
) -> ConsensusDocument:
    of = of or fit()
    size = of.img_size
    key = key or camera_key(camera, platform)
    calibration = Calibration.of(
        of,
        id=f"{key}~{size[0]}x{size[1]}~{zoom:g}~{of.distortion_model}",
        camera=camera,
        platform=platform,
        zoom=zoom,
        calibration_time=time,
        calibrations=calibrations,
        contributors=min(calibrations, 3),
        reliable=reason is None,
        spread=0.4,
        held_out_error=0.3,
        basis="consensus" if reason is None else None,
    )
    return ConsensusDocument(
        camera_key=key,
        img_size=of.img_size,
        zoom=zoom,
        distortion_model=of.distortion_model,
        total=calibrations,
        latest=time,
        basis="basis",
        reason=reason,
        calibration=calibration,
    )


def calibration(
    camera: str = C920,
    platform: str = LINUX,
    *,
    number: int = 0,
    of: FitRecord | None = None,
    key: str | None = None,
    resize_mode: str | None = None,
    time: int = 1_700_000_000,
) -> CalibrationDocument:
    """A calibration whose one view is not worth anything; `key`: that of earlier rules."""
    of = of or fit()
    key = key or camera_key(camera, platform)
    return CalibrationDocument(
        camera_key=key,
        camera=camera,
        platform=platform,
        img_size=of.img_size,
        zoom=0.0,
        distortion_model=of.distortion_model,
        board=Board(),
        guidance="projection-uncertainty",
        target_error=0.3,
        track=Track(resizeMode=resize_mode),
        id=f"{key}-{number:020x}",
        views=(ViewDocument(index=0, ids=(0,), points=((1.0, 1.0),)),),
        fits={of.distortion_model: of},
        solver="0",
        contributor=f"contributor {number}",
        time=time + number,
    )


def vote(of: CalibrationDocument, **changes: object) -> VoteDocument:
    """A vote on the views of a calibration, given without a licence."""
    consent = {"licence": None, "licence_version": None}
    return VoteDocument(**{**dict(of), **consent, "noise": 0.1, **changes})


def mode_of(document: CalibrationDocument) -> StreamMode:
    return StreamMode(document.camera_key, document.img_size, document.zoom)
