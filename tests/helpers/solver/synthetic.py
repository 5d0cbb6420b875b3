"""Made-up cameras and a clumsy user: the closed loop in which guidance is measured.

The world is that of the published comparison: 12 cameras with f = 500 to 1600 px at 1280 x 720 and k1 from
-0.35 to +0.10, a 9 x 6 board, independent Gaussian noise on the corners.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from calibsolver import Board, Calibration, Camera, View, models
from calibsolver import rotation as rotations
from calibsolver.camera import pixel_grid
from calibsolver.capture import Capture, Estimate, History, ViewDecision
from calibsolver.fitting.initial_guess import plane_poses
from calibsolver.guidance.candidates import distance_to_border
from calibsolver.guidance.target import TargetPose
from tests.helpers.solver.hands import STEADY, Hand

IMG_SIZE = (1280, 720)
BORDER_PX = 2.0
"""Border in which neither corners nor markers are found."""


def camera_matrix(focal: float, rng: np.random.Generator) -> np.ndarray:
    """Camera matrix (3, 3) whose centre and aspect are a little off, as those of real cameras."""
    w, h = IMG_SIZE
    cx = (w - 1) / 2 + 0.012 * w * rng.normal()
    cy = (h - 1) / 2 + 0.012 * w * rng.normal()
    return np.array([[focal, 0, cx], [0, focal * (1 + 0.002 * rng.normal()), cy], [0, 0, 1]])


@cache
def rectilinear_cameras(count: int = 12, seed: int = 0) -> tuple[Camera, ...]:
    """Cameras from wide to narrow, each with some distortion, as far as real ones bend."""
    rng = np.random.default_rng(seed)
    cameras = []
    radial = rng.permutation(np.linspace(-0.35, 0.10, count))
    for focal, k1 in zip(np.geomspace(500, 1600, count), radial, strict=True):
        k2 = 0.3 * k1 * k1 + 0.01 * rng.normal()
        p1, p2 = 0.0006 * rng.normal(size=2)
        matrix = camera_matrix(focal, rng)
        # Real wide lenses draw the corners a third as large as the middle, not smaller, and nothing between
        # them smaller still: one that is about to fold (its radial stretch near 0) does not bend that much.
        while least_stretch(camera := Camera("rectilinear", matrix, [k1, k2, p1, p2, 0], IMG_SIZE)) < 0.3:
            k1, k2 = 0.95 * k1, k2 + 0.002
        cameras.append(camera)
    return tuple(cameras)


def least_stretch(camera: Camera) -> float:
    """Least radial magnification over the image / that in the middle; 0 where a corner is not seen."""
    w, h = camera.img_size
    rays = camera.unproject(np.array([[x, y] for x in (0.0, w - 1.0) for y in (0.0, h - 1.0)]))
    farthest = ((rays[:, 0] ** 2 + rays[:, 1] ** 2) / rays[:, 2] ** 2).max()
    if not np.isfinite(farthest):
        return 0.0
    k1, k2, k3 = camera.distortion[[0, 1, 4]]
    s = np.linspace(0, farthest, 100)
    return float((1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3))).min())


@cache
def fisheye_cameras(count: int = 12, seed: int = 0) -> tuple[Camera, ...]:
    """Kannala-Brandt cameras of 118 to 166 degrees over the image's diagonal."""
    rng = np.random.default_rng(seed)
    cameras = []
    for angle in np.radians(np.linspace(118, 166, count)):
        k = np.array([-0.03, 0.004, -0.001, 0.0001]) * rng.uniform(0.3, 1.5, 4)
        cameras.append(of_diagonal("fisheye", k, angle, rng))
    return tuple(cameras)


def of_diagonal(model: str, d: np.ndarray, angle: float, rng: np.random.Generator) -> Camera:
    reach = models.get(model).distort(d, np.array([np.sin(angle / 2), 0, np.cos(angle / 2)]))[0]
    return Camera(model, camera_matrix(np.hypot(*IMG_SIZE) / 2 / reach, rng), d, IMG_SIZE)


def zoomed(camera: Camera, factor: float) -> Camera:
    """The camera with `factor` times its focal lengths."""
    k = camera.intrinsics
    k[:2] *= factor
    return Camera.from_intrinsics(camera.model, k, camera.img_size)


def tilt_deg(board: Board, r: np.ndarray, tvec: np.ndarray) -> float:
    """Angle between the normal of a board and the line of sight to its middle."""
    center = r @ board.outline.mean(axis=0) + tvec
    return float(np.degrees(np.arccos(np.clip(r[:, 2] @ center / np.linalg.norm(center), -1, 1))))


def detect(
    board: Board,
    camera: Camera,
    rvec: np.ndarray,
    tvec: np.ndarray,
    rng: np.random.Generator,
    noise: float = 0.2,
    wild: float = 0.0,
    hand: Hand = STEADY,
    corners: np.ndarray | None = None,
    whole_markers: bool = True,
) -> View:
    """Corners as a detector reports them: Gaussian noise, a share `wild` 3 to 50 px off.

    With `whole_markers` the image must also contain what identifies a corner (`Board.support`). `corners` (n,
    3) are those of a bent board.
    """
    r = rotations.matrix(rvec)
    corners = board.points if corners is None else corners
    q = camera.project(corners @ r.T + tvec)
    if hand.readout_s:
        q = hand.project(corners, camera, rvec, tvec, rng)
    inside = distance_to_border(q, camera.img_size) >= BORDER_PX
    if whole_markers:
        places = camera.project(board.support.reshape(-1, 3) @ r.T + tvec)
        whole = (distance_to_border(places, camera.img_size) >= BORDER_PX).reshape(board.support.shape[:3])
        inside &= np.any(np.all(whole, axis=2), axis=1)
    q = q[inside] + noise * rng.normal(size=(int(inside.sum()), 2))
    bad = rng.uniform(size=len(q)) < wild
    w, h = camera.img_size
    angle = rng.uniform(0, 2 * np.pi, len(q))
    off = rng.uniform(3, 50, len(q))[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return View(board.points[inside], np.where(bad[:, None], np.clip(q + off, 0, (w - 1, h - 1)), q))


@dataclass(frozen=True)
class User:
    """Someone who misses the target: rotation by `degrees` per axis, place by `share` of the distance."""

    degrees: float = 3.0
    share: float = 0.03

    def hold(
        self, board: Board, target: TargetPose, rng: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """Pose (rvec, tvec) in their hands, turned about the board's centre."""
        center = board.outline.mean(axis=0)
        r = rotations.matrix(target.rvec)
        place = r @ center + target.tvec
        r = rotations.matrix(np.radians(self.degrees) * rng.normal(size=3)) @ r
        place = place + self.share * np.linalg.norm(place) * rng.normal(size=3)
        return rotations.vector(r), place - r @ center


def match_picture(board: Board, drawn: Camera, camera: Camera, target: TargetPose) -> TargetPose:
    """Pose at which `camera` sees the board where the picture drawn with the estimate `drawn` shows it.

    Users follow the picture: with a wrong focal length they hold the board at another distance.
    """
    pixels = drawn.project(board.points @ rotations.matrix(target.rvec).T + target.tvec)
    rays = camera.unproject(pixels)
    good = np.isfinite(rays).all(axis=1) & np.isfinite(pixels).all(axis=1)
    if good.sum() < 6:
        return target
    poses = plane_poses(board.points[good].T[None], rays[good].T[None], np.ones((1, int(good.sum()))))
    return replace(target, rvec=rotations.vector(poses.r)[0], tvec=poses.t[0])


@dataclass(frozen=True)
class Planned:
    """Chooser of the poses of a plan (`guidance.fixed_plan`), one after the other."""

    poses: tuple[TargetPose, ...]

    def next_pose(
        self, views: Sequence[View], _: object, skipped: Sequence[TargetPose] = (), *_unreached: object
    ) -> TargetPose:
        return self.poses[(len(views) + len(skipped)) % len(self.poses)]


def aligned_errors(camera: Camera, rays: np.ndarray, q: np.ndarray, r: np.ndarray, steps: int) -> np.ndarray:
    """Projections of rays (n, 3) less pixels (n, 2), after the rotation, near `r`, that fits best."""
    for _ in range(steps):
        p = rays @ r.T
        e = camera.project(p) - q
        step = 1e-6
        turned = [camera.project(p @ rotations.matrix(step * axis).T) for axis in np.eye(3)]
        j = np.stack([(t - q - e) / step for t in turned], axis=-1)
        good = np.isfinite(e).all(axis=1) & np.isfinite(j).all(axis=(1, 2))
        turn = -np.linalg.lstsq(j[good].reshape(-1, 3), e[good].reshape(-1), rcond=None)[0]
        r = rotations.matrix(turn) @ r
    errors: np.ndarray = camera.project(rays @ r.T) - q
    return errors


def projection_error(truth: Camera, found: Camera, grid: tuple[int, int] = (20, 15)) -> np.ndarray:
    """|true - estimated projection| (n,) px over the image, after the rotation that fits best."""
    rays = truth.unproject(pixel_grid(truth.img_size, grid).reshape(2, -1).T)
    rays = rays[np.isfinite(rays[:, 0])]
    q = truth.project(rays)
    e = aligned_errors(found, rays, q, np.eye(3), 6)
    # Where the found camera sees nothing at all the error is as large as the image.
    return np.where(np.isfinite(e).all(axis=1), np.hypot(e[:, 0], e[:, 1]), truth.img_size[0])


def rms_error(truth: Camera, found: Camera) -> float:
    return float(np.sqrt(np.mean(projection_error(truth, found) ** 2)))


@dataclass
class Sitting:
    """State of a capture between its views, as the service keeps it."""

    rules: Capture
    views: list[View] = field(default_factory=list)
    quarantined: list[View] = field(default_factory=list)
    history: History = field(default_factory=History)
    estimate: Estimate = field(init=False)

    def __post_init__(self) -> None:
        self.estimate = self.rules.estimate(self.views)

    @property
    def used(self) -> list[View]:
        return [view for i, view in enumerate(self.views) if i not in self.estimate.excluded]

    @property
    def is_exhausted(self) -> bool:
        return self.history.is_exhausted(len(self.used))

    def offer(self, target: TargetPose | None, view: View) -> ViewDecision:
        """Judge a view, and keep it if it is accepted or goes into quarantine."""
        decision = self.rules.judge(
            self.views, target, view, self.estimate.excluded, self.quarantined, self.history
        )
        self.history = decision.after(self.history)
        if decision.estimate is not None:
            self.views.append(view)
            self.estimate, self.quarantined = decision.estimate, []
        elif decision.quarantine:
            self.quarantined.append(view)
        return decision


@dataclass
class Session:
    """Course of one capture: per accepted view the errors, the predicted errors, and the fit."""

    mean: list[float] = field(default_factory=list)
    rms: list[float] = field(default_factory=list)
    predicted: list[float] = field(default_factory=list)
    stopped: int | None = None
    attempts: int = 0
    reasons: list[str] = field(default_factory=list)
    targets: list[TargetPose] = field(default_factory=list)
    views: list[View] = field(default_factory=list)
    calibration: Calibration | None = None

    def measure(self, truth: Camera, calibration: Calibration | None, predicted: float | None = None) -> None:
        """Add how far a calibration is from the truth; without one, as far as the image is wide."""
        if calibration is None:
            for errors in (self.mean, self.rms, self.predicted):
                errors.append(float(truth.img_size[0]))
            return
        self.calibration = calibration
        error = projection_error(truth, calibration.camera)
        self.mean.append(float(error.mean()))
        self.rms.append(float(np.sqrt(np.mean(error**2))))
        self.predicted.append(calibration.uncertainty().rms if predicted is None else predicted)


def run(
    camera: Camera,
    rng: np.random.Generator,
    board: Board | None = None,
    noise: float = 0.2,
    wild: float = 0.0,
    user: User | None = None,
    views: int = 6,
    max_views: int = 0,
    capture: Capture | None = None,
    guide: Planned | None = None,
    max_attempts: int = 60,
) -> Session:
    """One guided capture up to `views` accepted views, beyond its end, which is only noted.

    One that has not ended by then continues to `max_views` views. `guide` chooses the poses in place of the
    capture's own.
    """
    board, user = board or Board(), user or User()
    capture = capture or Capture(board, camera.img_size, camera.model)
    chooser = guide or capture.guide
    sitting = Sitting(capture)
    session = Session(views=sitting.views)
    skipped: tuple[TargetPose, ...] = ()
    unreached: tuple[TargetPose, ...] = ()
    target: TargetPose | None = None
    while session.attempts < max_attempts and len(session.views) < max(
        views, max_views if session.stopped is None else 0
    ):
        session.attempts += 1
        calibration = sitting.estimate.calibration
        target = target or chooser.next_pose(sitting.used, calibration, (), unreached)
        session.targets.append(target)
        # A plan that does not adapt is drawn with the camera that it was made for.
        drawn = capture.camera(None if isinstance(chooser, Planned) else sitting.estimate)
        asked = match_picture(board, drawn, camera, target)
        rvec, tvec = user.hold(board, asked, rng)
        view = detect(board, camera, rvec, tvec, rng, noise, wild)
        decision = sitting.offer(target, view)
        if decision.estimate is None:
            session.reasons.append(str(decision.reason))
            if len(session.reasons) % 4 == 0:  # gives up on this one
                skipped = (*skipped, target)
                target = chooser.next_pose(session.views, calibration, skipped, unreached)
            continue
        unreached, skipped, target = (*unreached, *skipped), (), None
        uncertainty = decision.estimate.uncertainty
        session.measure(camera, decision.estimate.calibration, uncertainty and uncertainty.rms)
        if decision.estimate.converged and session.stopped is None:
            session.stopped = len(session.views)
    return session
