"""Other ways to capture, in the same world as `synthetic.run`: what guidance is measured against."""

import numpy as np

from calibsolver import Board, CalibrationError, Camera, View, fit, rotation
from calibsolver.guidance import IntrinsicsPosterior, PoseSelection, candidates
from calibsolver.guidance.candidates import CornerGrid, PoseLimits
from calibsolver.guidance.pose_selection import estimate_outline, jaccard_index
from calibsolver.guidance.search import fisher_information
from tests.helpers.solver.synthetic import Session, User, detect, match_picture

MAX_ATTEMPTS = 8
COMFORTABLE = PoseLimits(width=(0.30, 0.75), max_tilt_deg=45.0, min_visible=0.9)


def run_published_method(camera: Camera, rng: np.random.Generator, noise: float = 0.2) -> Session:
    """The published method as it is: its poses, plain least squares, its overlap rule, its own end.

    Drawn with a wrong focal length some targets cannot be reached: the best of MAX_ATTEMPTS is taken.
    """
    board, user = Board(), User()
    guide = PoseSelection(board, camera.img_size, camera.model)
    session, tried = Session(), list[tuple[float, View]]()
    while session.attempts < 100 and not guide.is_done(session.views):
        session.attempts += 1
        target = guide.next_pose(session.views, None)
        asked = match_picture(board, guide.camera(session.views), camera, target)
        view = detect(board, camera, *user.hold(board, asked, rng), rng, noise)
        tried.append((jaccard_index(target.outline, estimate_outline(board, view), camera.img_size), view))
        if not guide.is_reached(target, view):
            if len(tried) < MAX_ATTEMPTS:
                continue
            view = max(tried, key=lambda one: one[0])[1]
        tried = []
        session.views.append(view)
        calibration = guide.estimate(session.views) if len(session.views) > 1 else None
        session.measure(camera, calibration)
    session.stopped = len(session.views) if guide.is_done(session.views) else None
    return session


def random_poses(camera: Camera, rng: np.random.Generator, views: int, noise: float = 0.2) -> Session:
    """Someone who shows the board tilted here and there, all of it mostly."""
    return _calibrated(camera, rng.uniform(size=(40 * views, 6)), COMFORTABLE, rng, views, noise)


def waving(camera: Camera, rng: np.random.Generator, views: int, noise: float = 0.2) -> Session:
    """Someone who waves the board before the camera: each view a little from the last."""
    steps = np.cumsum(0.04 * rng.normal(size=(40 * views, 6)), axis=0) + rng.uniform(0.3, 0.7, 6)
    unit = 1 - np.abs(steps % 2 - 1)  # reflected at the ends
    limits = PoseLimits(width=(0.3, 0.75), max_tilt_deg=30.0)
    return _calibrated(camera, unit, limits, rng, views, noise)


def _calibrated(
    camera: Camera, unit: np.ndarray, limits: PoseLimits, rng: np.random.Generator, views: int, noise: float
) -> Session:
    """Fits to the first views, of those of points (n, 6) of the unit cube that respect the limits."""
    board, session = Board(), Session()
    posterior = IntrinsicsPosterior.of(camera.model, camera.img_size, None, camera)
    poses = candidates.poses_from_unit_cube(unit, board, posterior.rays, limits)
    with np.errstate(all="ignore"):
        _, good = fisher_information(posterior, poses, CornerGrid.of(board, 5), limits)
    for i in np.flatnonzero(good)[:views]:
        session.attempts += 1
        rvec = rotation.vector(poses.r[i])
        session.views.append(detect(board, camera, rvec, poses.t[i], rng, noise, whole_markers=False))
        try:
            calibration = fit(session.views, camera.img_size, camera.model)
        except CalibrationError:
            calibration = None
        session.measure(camera, calibration)
    return session
