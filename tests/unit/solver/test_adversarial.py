"""Every input ends in a finite result or in a documented reason."""

import contextlib
import re
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from calibsolver import (
    Board,
    CalibrationError,
    Camera,
    View,
    fit,
    guidance,
    models,
    quality,
    rig,
    rotation,
)
from calibsolver.arrays import Array, symmetric_inverse
from calibsolver.capture import Capture
from calibsolver.consensus import Member, pool
from calibsolver.consensus.agreement import difference
from calibsolver.fitting.levenberg_marquardt import Problem
from calibsolver.fitting.normal_equations import Poses
from calibsolver.fitting.observations import Observations
from calibsolver.fitting.resection import reprojection_score
from calibsolver.formats import ExportSource, write
from calibsolver.quality import report
from calibsolver.quality.systematic import probable_cause
from tests.conftest import THOROUGH
from tests.helpers.solver import populations, rigs, synthetic
from tests.helpers.solver.export_sources import captured

BOARD = Board()
SIZE = synthetic.IMG_SIZE
REASONS = set(re.findall(r"``(\w+)``", fit.__doc__ or ""))
MIN_CORRUPTIBLE_POINTS = 9
Observation = tuple[Array, Array]
"""Points (n, 3) of the board and their pixels (n, 2)."""
Corruption = Callable[[np.random.Generator, Array, Array], Observation]


def select_few(rng: np.random.Generator, p: Array, q: Array) -> Observation:
    chosen = rng.choice(len(p), min(int(rng.integers(4, 9)), len(p)), replace=False)
    return p[chosen], q[chosen]


def squeeze(rng: np.random.Generator, p: Array, q: Array) -> Observation:
    return p * (1, 10 ** rng.uniform(-5, 0), 1), (q - 360) * (1, 10 ** rng.uniform(-5, 0)) + 360


def repeat(rng: np.random.Generator, p: Array, q: Array) -> Observation:
    chosen = rng.integers(0, min(len(p), 6), len(p))
    return p[chosen], q[chosen]


CORRUPTIONS: dict[str, Corruption] = {
    "nothing": lambda _, p, q: (p, q),
    "few points": select_few,
    "on a line": squeeze,
    "again and again": repeat,
    "anywhere": lambda rng, p, _: (p, rng.uniform((0, 0), SIZE, (len(p), 2))),
    "other names": lambda rng, p, q: (p, rng.permutation(q)),
    "one place": lambda rng, p, q: (p, rng.uniform(0, 700, 2) + 2 * rng.normal(size=q.shape)),
    "whole pixels": lambda rng, p, q: (p, np.round(q, -int(rng.integers(0, 3)))),
    "tiny": lambda rng, p, q: (p, q / 100 + rng.uniform((0, 0), SIZE)),
    "far outside": lambda rng, p, q: (p, q + 10 ** rng.uniform(3, 5) * rng.normal(size=2)),
    "parallel": lambda rng, p, _: (p, 640 + p[:, :2] @ rng.normal(size=(2, 2)) * 10 ** rng.uniform(0, 2)),
    "another unit": lambda rng, p, q: (p * 10 ** rng.uniform(-60, 8), q),
    "beyond numbers": lambda rng, p, q: (
        p * 10.0 ** rng.choice([-300, -150, 0, 150, 290]),
        q * 10.0 ** rng.choice([-300, 0, 150, 290]),
    ),
}


def corrupt_views(rng: np.random.Generator, camera: Camera, kind: str) -> list[View]:
    """One to five views of a camera without noise, corrupted: facing it or leaning, near or infinite."""
    middle = BOARD.outline.mean(axis=0)
    views: list[View] = []
    most, infinite, same = rng.choice([0, 50]), rng.uniform() < 0.1, rng.uniform() < 0.1
    for _ in range(int(rng.integers(1, 6))):
        azimuth = rng.uniform(0, 2 * np.pi)
        r = rotation.matrix(
            np.radians(rng.uniform(0, most)) * np.array([np.cos(azimuth), np.sin(azimuth), 0])
        )
        depth = rng.uniform(0.6, 1.4) * BOARD.size[0] * camera.matrix[0, 0] / SIZE[0]
        depth *= 10 ** rng.uniform(1, 12) if infinite else 1
        q = camera.project((BOARD.points - middle) @ r.T + depth * np.array([*rng.uniform(-0.3, 0.3, 2), 1]))
        seen = np.isfinite(q).all(axis=1)
        if seen.sum() >= MIN_CORRUPTIBLE_POINTS:
            views.append(View(*CORRUPTIONS[kind](rng, BOARD.points[seen], q[seen])))
    return [views[0]] * len(views) if same else views


def check_fit(rng: np.random.Generator, model: str, views: list[View]) -> None:
    try:
        c = fit(views, SIZE, model, robust=bool(rng.uniform() < 0.7))
    except CalibrationError as error:
        assert error.code in REASONS  # noqa: PT017
        return
    u = c.uncertainty()
    for numbers in (c.camera.intrinsics, [c.avg_reprojection_error, u.rms, u.max]):
        assert np.isfinite(numbers).all()
    has_pose = np.array([c.cut_views.get(i) != "degenerate" for i in range(len(views))])
    assert (np.isfinite(c.poses) == has_pose[:, None]).all()
    assert (np.isfinite(c.view_errors) == has_pose).all()
    std = np.sqrt(np.diagonal(c.covariance))
    assert np.linalg.eigvalsh(c.covariance / std[:, None] / std).min() > -1e-9
    target = guidance.ProjectionUncertainty(BOARD, SIZE, model).next_pose(views, c)
    assert np.isfinite([*target.rvec, *target.tvec, *target.corners.ravel(), target.gain]).all()
    same = difference(c.camera, c.camera)
    assert same < 1e-3 or (np.isinf(same) and c.camera.domain().covered < 0.6)


def check_capture(rng: np.random.Generator, model: str, views: list[View]) -> None:
    rules = Capture(BOARD, SIZE, model, target_error=float(rng.choice([0.3, 0.001])))
    estimate, taken = rules.estimate([]), list[View]()
    target = rules.next_target([], estimate)
    for view in views:
        decision = rules.judge(taken, target, view, estimate.excluded, taken[:2])
        if decision.estimate is not None:
            estimate, taken = decision.estimate, [*taken, view]
            assert 0 <= estimate.progress <= 1
            target = rules.next_target(taken, estimate)
            assert np.isfinite([*target.rvec, *target.tvec, *target.corners.ravel(), target.gain]).all()
    assert rules.reconcile(taken, {}).progress <= 1


@pytest.mark.parametrize("model", models.NAMES)
@given(kind=st.sampled_from(sorted(CORRUPTIONS)), seed=st.integers(0, 2**32 - 1))
@example("few points", 109)  # none is left of so few points once those that do not fit are cut
@example("tiny", 7179057)  # a rational camera without any ray
@settings(max_examples=500 if THOROUGH else 3, deadline=None)
def test_every_input_ends_in_finite_numbers_or_a_reason(model: str, kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinds = list(populations.POPULATIONS)
    camera = populations.POPULATIONS[kinds[int(rng.integers(len(kinds)))]]()[int(rng.integers(12))]
    views = corrupt_views(rng, camera, kind)
    if not views:
        return
    if rng.uniform() < 0.5:
        check_fit(rng, model, views)
    else:
        check_capture(rng, model, views)
    try:
        score = reprojection_score(camera, views)
    except CalibrationError as error:
        assert error.code in {"too_few_points", "out_of_range"}  # noqa: PT017
    else:
        assert not np.isnan(score.view_errors).any()
        assert (np.isfinite(score.poses).all(axis=1) == np.isfinite(score.view_errors)).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_view_with_nonfinite_points_raises_value_error(bad: float) -> None:
    for i in range(2):
        points = [BOARD.points.copy(), BOARD.points[:, :2] * 50]
        points[i][3, 1] = bad
        with pytest.raises(ValueError, match="finite"):
            View(*points)


def test_views_without_a_start_raise_calibration_error() -> None:
    """Of an omnidirectional camera's starts some have no ray for pixels far beyond the image."""
    views = [View(BOARD.points, BOARD.points[:, :2] * 40 + (9000, off)) for off in (6000, -6000)]
    with pytest.raises(CalibrationError) as caught:
        fit(views, SIZE, "omnidirectional")
    assert caught.value.code in REASONS


@pytest.mark.parametrize("model", models.NAMES)
def test_step_beyond_the_largest_number_is_refused(model: str) -> None:
    """A step of the focal length by a factor of more than e^709."""
    camera = populations.POPULATIONS[model]()[0]
    views = populations.views(camera, np.random.default_rng(0), count=2)
    problem = Problem(models.get(model), Observations.of(views), SIZE)
    state = problem.at(camera.intrinsics, Poses.of_vectors(reprojection_score(camera, views).poses))
    step = np.zeros(len(state.k))
    step[:2] = 800 * state.k[:2]
    with np.errstate(all="ignore"):
        moved = problem._take_step(state, step, np.zeros((len(views), 6)))
    assert moved is None or not moved.square.sum() < state.square.sum()


def test_symmetric_inverse_of_an_indefinite_matrix_is_positive() -> None:
    a = np.array([[1.0, 1.0 + 1e-15, 0.0], [1.0 + 1e-15, 1.0, 0.0], [0.0, 0.0, 4.0]])
    inverse = symmetric_inverse(a)
    assert np.linalg.eigvalsh(inverse).min() > 0
    assert inverse[2, 2] == pytest.approx(0.25, rel=1e-12)
    assert inverse[0, 0] > 1e12
    assert np.isnan(symmetric_inverse(np.stack([np.full((2, 2), np.nan), np.eye(2)]))).all(axis=(1, 2))[0]


def test_pooled_copies_of_one_view_end_in_a_reason() -> None:
    view = View(BOARD.points, BOARD.points[:, :2] * 100 + 200)
    try:
        found = pool([Member(str(i), str(i), (view,)) for i in range(5)], SIZE, "rational")
    except CalibrationError as error:
        assert error.code in REASONS  # noqa: PT017
    else:
        assert np.isfinite(found.calibration.covariance).all()


CAMERA = synthetic.rectilinear_cameras(1)[0]
VIEWS = captured(CAMERA, BOARD, 6)
FITTED = fit(VIEWS, SIZE)
PAIR = rigs.side_by_side(synthetic.rectilinear_cameras(2), 1.0)
MOMENTS = rigs.moments(PAIR, BOARD, 5, 0.2, np.random.default_rng(0))
SPECIFICATIONS = [(camera.img_size, camera.model) for camera in PAIR.cameras]
RIG = rig.fit(MOMENTS, SPECIFICATIONS)
CAPTURE = Capture(BOARD, SIZE)
ESTIMATE = CAPTURE.estimate(VIEWS[:4])
TARGET = CAPTURE.next_target(VIEWS[:4], ESTIMATE)

ENTRIES: dict[str, Callable[[], object]] = {
    "fit": lambda: fit(VIEWS, SIZE),
    "least squares": lambda: fit(VIEWS, SIZE, robust=False),
    "resection": lambda: reprojection_score(CAMERA, VIEWS),
    "assess": lambda: quality.assess(FITTED, VIEWS),
    "held_out": lambda: quality.held_out(VIEWS, SIZE),
    "cause": lambda: probable_cause(FITTED, VIEWS),
    "report": lambda: report.describe(FITTED, VIEWS),
    "consensus": lambda: pool([Member(str(i), str(i), VIEWS[:3]) for i in range(2)], SIZE, "rectilinear"),
    "guidance": lambda: guidance.ProjectionUncertainty(BOARD, SIZE).next_pose(VIEWS, FITTED),
    "published guidance": lambda: guidance.PoseSelection(BOARD, SIZE).next_pose(VIEWS[:3], None),
    "judge": lambda: CAPTURE.judge(VIEWS[:4], TARGET, VIEWS[4]),
    "reconcile": lambda: CAPTURE.reconcile(VIEWS[:4], {}),
    "export": lambda: write(ExportSource(CAMERA, VIEWS, BOARD), "kalibr"),
    "rig": lambda: rig.fit(MOMENTS, SPECIFICATIONS),
    "rig guidance": lambda: rig.next_moment(BOARD, SPECIFICATIONS, MOMENTS, RIG),
}


@pytest.mark.parametrize("name", ["eigh", "svd", "qr", "inv", "lstsq"])
def test_no_failure_of_linear_algebra_leaves_the_solver(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object, **__: object) -> None:
        raise np.linalg.LinAlgError("did not converge")

    monkeypatch.setattr(np.linalg, name, fails)
    for call in ENTRIES.values():
        with contextlib.suppress(CalibrationError):
            call()
