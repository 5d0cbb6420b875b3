"""Rules of a capture: acceptance and refusal of views, convergence."""

import itertools

import numpy as np
import pytest

from calibsolver import Board, Camera, View, models, rotation
from calibsolver.capture import Capture, History
from tests.helpers.marks import thorough
from tests.helpers.solver import populations, synthetic

BOARD = Board()
CAMERA = synthetic.rectilinear_cameras()[6]
SIZE = CAMERA.img_size


@pytest.fixture(scope="module")
def session() -> synthetic.Session:
    return synthetic.run(CAMERA, np.random.default_rng(0), views=4)


def capture() -> Capture:
    return Capture(BOARD, SIZE)


def pinhole(focal: float) -> Camera:
    return Camera("rectilinear", np.array([[focal, 0, 640], [0, focal, 360], [0, 0, 1]]), np.zeros(5), SIZE)


def centred(rvec: np.ndarray, distance: float) -> np.ndarray:
    """Translation (3,) that puts the middle of the board on the axis."""
    return np.array([0, 0, distance]) - rotation.matrix(rvec) @ BOARD.outline.mean(axis=0)


def test_progress_grows_to_one(session: synthetic.Session) -> None:
    c = capture()
    estimates = [c.estimate(session.views[:n]) for n in range(5)]
    empty, last = estimates[0], estimates[-1]
    assert (empty.calibration, empty.converged, empty.view_errors) == (None, False, ())
    assert c.camera(empty).matrix[0, 0] == pytest.approx(0.8 * 1280)
    progress = [estimate.progress for estimate in estimates]
    assert progress[0] == 0
    assert (np.diff(progress) > 0).all()
    assert progress[4] == 1.0
    assert last.converged
    assert last.uncertainty is not None
    assert last.uncertainty.rms < 0.3
    generous = Capture(BOARD, SIZE, target_error=50.0)
    assert not generous.estimate(session.views[:3]).converged
    assert generous.estimate(session.views).converged


def test_bad_view_is_refused_with_its_reason_and_a_good_one_accepted(session: synthetic.Session) -> None:
    c, views, rng = capture(), session.views[:3], np.random.default_rng(1)
    target, first = c.next_target(views, c.estimate(views)), views[0]
    good = synthetic.detect(BOARD, CAMERA, target.rvec, target.tvec, np.random.default_rng(9))
    p, q = good.object_points, good.image_points
    row = p[:, 1] == p[0, 1]
    tilted, apart = np.array([0.2, -0.1, 0.0]), np.array([-4.5, -3, 14.0])
    other = synthetic.detect(Board(squares=(8, 8)), CAMERA, tilted, apart, rng)
    assert len(other) == 49
    noise = 0.3 * rng.normal(size=first.image_points.shape)
    bad = [
        ("too_few_points", p[:5], q[:5]),
        ("degenerate", p[row], q[row]),
        ("degenerate", p, 400 + 0.005 * q),  # far away
        ("mirrored", p, np.array([1279, 0]) + q * [-1, 1]),
        ("outlier, mirrored", BOARD.points, other.image_points[:40]),  # another board's ids
        ("outlier", p, q + 3 * rng.normal(size=q.shape)),  # shaken
        ("outlier, mirrored", p, q[rng.permutation(len(q))]),
        ("duplicate", first.object_points, first.image_points + noise),
    ]
    for expected, points, pixels in bad:
        decision = c.judge(views, target, View(points, pixels))
        assert decision.reason in expected.split(", ")
        assert not decision.accepted
        assert decision.estimate is None
    decision = c.judge(views, target, good)
    assert decision.accepted
    assert decision.reason is None
    assert decision.estimate is not None
    assert len(decision.estimate.view_errors) == 4


@pytest.mark.parametrize("focal", [500, *thorough(1000, 1600)])
def test_noiseless_copies_do_not_converge(focal: int) -> None:
    # Their residuals are nothing, so by these alone a single pose would seem to tell everything.
    c = capture()
    target = c.next_target([], c.estimate([]))
    rng = np.random.default_rng(0)
    copy = synthetic.detect(BOARD, pinhole(focal), target.rvec, target.tvec, rng, noise=0)
    views: list[View] = []
    while c.judge(views, target, copy).accepted:
        views.append(copy)
        estimate = c.estimate(views)
        assert not estimate.converged
        assert len(views) < 9
        target = c.next_target(views, estimate)
    assert views


@pytest.mark.parametrize("model", models.NAMES)
@pytest.mark.parametrize("tilt", [0, *thorough(2, 5, 10, 20)])
def test_first_view_is_never_an_outlier(model: str, tilt: int) -> None:
    # Facing the camera it tells little, but it is never an outlier for want of a fit.
    c, rng = Capture(BOARD, SIZE, model), np.random.default_rng(tilt)
    rvec = np.radians(tilt) * np.array([0.6, 0.8, 0.0])
    for focal, width in itertools.product((500, 2000), (0.3, 0.9)):
        tvec = centred(rvec, 9 * focal / (width * 1280))
        view = synthetic.detect(BOARD, pinhole(focal), rvec, tvec, rng)
        assert c.judge([], None, view).accepted, (focal, width)


def test_mirrored_first_view_is_refused_in_any_pose() -> None:
    rng = np.random.default_rng(4)
    for _ in range(8):
        rvec = rng.normal(size=3) * [0.6, 0.6, 1.5]
        view = synthetic.detect(BOARD, CAMERA, rvec, centred(rvec, 12.0), rng)
        if len(view) < 30:
            continue
        assert capture().judge([], None, view).reason != "mirrored"
        flipped = View(view.object_points, [1279, 0] + view.image_points * [-1, 1])
        assert capture().judge([], None, flipped).reason == "mirrored"


def test_unknown_guidance_raises_value_error() -> None:
    with pytest.raises(ValueError, match="guidance"):
        Capture(BOARD, SIZE, guidance="random")


def started(seed: Camera | None) -> synthetic.Session:
    """Guided capture that starts from a seed, or from none."""
    rules = Capture(BOARD, SIZE, seed=seed)
    return synthetic.run(CAMERA, np.random.default_rng(3), views=4, max_views=15, capture=rules)


def with_focal_length(factor: float) -> Camera:
    k = CAMERA.intrinsics
    k[:2] *= factor
    return Camera.from_intrinsics(CAMERA.model, k, SIZE)


@pytest.mark.parametrize("factor", [0.6, *thorough(0.3, 1.3, 5.0)])
def test_wrong_seed_harms_no_capture(factor: float) -> None:
    """As many views as without, or one more, none refused; and the seed leaves no trace in the result."""
    seed = with_focal_length(factor)
    plain, misled = started(None), started(seed)
    for run in (plain, misled):
        assert run.rms[-1] < 0.6
        assert "outlier" not in run.reasons
    assert misled.stopped is not None
    assert misled.stopped <= (plain.stopped or 0) + 1
    without = capture().estimate(misled.views)
    assert without.calibration is not None
    assert misled.calibration is not None
    difference = synthetic.projection_error(without.calibration.camera, misled.calibration.camera)
    assert difference.max() < 1e-3
    # Views all over the image, near no target.
    rules = Capture(BOARD, SIZE, seed=seed)
    assert rules.camera(None).focal == seed.focal
    for view in populations.views(CAMERA, np.random.default_rng(0)):
        assert rules.judge([], None, view).accepted


def test_seed_that_poses_the_first_view_is_kept() -> None:
    view = populations.views(CAMERA, np.random.default_rng(0), count=1)[0]
    for factor, rejected in ((1.0, False), (1.01, False), (3.0, True)):
        rules = Capture(BOARD, SIZE, seed=with_focal_length(factor))
        decision = rules.judge([], rules.next_target([], rules.estimate([])), view)
        assert decision.seed_rejected is rejected


def test_seed_that_is_no_believable_camera_is_not_used() -> None:
    """A focal length of 0.1 image widths, though the camera matrix says 0.2; and an infinite one."""
    f = 0.2 * 1280
    wide = [np.array([f, f, 640, 360, xi, 0, 0, 0, 0]) for xi in (1.0, -1.0)]
    seeds = [with_focal_length(factor) for factor in (0.003, 50.0, np.nan)]
    seeds += [Camera.from_intrinsics("omnidirectional", k, SIZE) for k in wide]
    for seed in seeds:
        assert Capture(BOARD, SIZE, seed.model, seed=seed).seed is None


FALLING = (None, 9.0, 5.0, 3.0, 2.0, 1.5, 1.2, 1.0, 0.8, 0.6)
FLAT = (None, 9.0, 5.0, 3.0, 2.0, 1.0, 0.8, 0.78, 0.76, 0.75)


def plateau(stated: tuple[float | None, ...], on_target: tuple[bool, ...] | None = None) -> bool:
    on_target = on_target or (True,) * len(stated)
    last = stated[-1]
    assert last is not None
    return History((*stated[:-1], None), on_target).has_plateau(last, len(stated))


def test_error_that_falls_no_more_is_a_plateau_from_ten_views_on() -> None:
    assert not plateau(FALLING)
    assert plateau(FLAT)
    assert not plateau(FLAT[:9])


def test_views_off_the_target_are_no_plateau() -> None:
    for off in range(6, 10):
        assert plateau(FLAT, tuple(i != off for i in range(10))) == (off == 6)


def test_error_that_jumped_is_no_plateau_and_one_jump_hides_none() -> None:
    """By the running minimum one view that is off is no progress afterwards, nor does it end a capture."""
    assert not plateau((None, 9.0, 5.0, 1.0, 0.8, 0.8, 0.8, 0.8, 0.8, 66.0))
    assert plateau((None, 9.0, 5.0, 1.0, 0.8, 0.8, 66.0, 0.8, 0.8, 0.8))
    assert plateau((None, 9.0, 5.0, 1.0, 0.8, 0.8, None, 0.8, 0.8, 0.8))


@pytest.mark.parametrize(("duplicates", "count", "ends"), [(5, 9, False), (6, 3, False), (6, 4, True)])
def test_six_duplicates_in_a_row_end_a_capture_of_four_views(duplicates: int, count: int, ends: bool) -> None:
    assert History(duplicates=duplicates).is_exhausted(count) is ends
