"""Location of contributors: equal weights whatever their boards, bounded influence, liars among specimens."""

from dataclasses import replace

import numpy as np
import pytest

from calibsolver import Camera, fit
from calibsolver.consensus import Member, Rule, difference, pool
from calibsolver.consensus.agreement import Projections
from calibsolver.consensus.location import ContributorFields, field_distance
from calibsolver.fitting.calibration import Calibration
from tests.helpers.solver import populations, synthetic, worlds

CAMERA = synthetic.rectilinear_cameras()[6]
SIZE = CAMERA.img_size
RULE = Rule(min_contributors=3)
MOVED = 1.0
"""px over the image, by which no two contributors may move a reliable answer."""


def scaled(factor: float, distortion: float = 0.0) -> Camera:
    """The camera with another focal length, and another k1."""
    k = CAMERA.intrinsics
    k[:2] *= factor
    k[4] += distortion
    return Camera.from_intrinsics(CAMERA.model, k, SIZE)


@pytest.fixture(scope="module")
def calibrated() -> Calibration:
    return fit(populations.views(CAMERA, np.random.default_rng(0)), SIZE)


def fields(calibrated: Calibration, cameras: list[Camera], names: str | None = None) -> ContributorFields:
    """Contributors, by the letters of `names`, whose calibrations have these cameras."""
    projections = Projections.of([replace(calibrated, camera=camera) for camera in cameras])
    return ContributorFields(projections, list(names or map(str, range(len(cameras)))), 0)


def test_location_of_specimens_is_their_mean(calibrated: Calibration) -> None:
    """Three of one contributor are one; the camera fitted to the location is their mean, too."""
    made = fields(calibrated, [scaled(f) for f in (0.999, 1.001, 1.0, 1.002, 1.001)], "abccc")
    location = made.locate(range(5))
    assert location.weights == pytest.approx([location.weights[0]] * 3, rel=1e-3)
    camera, distance = made.fit(location)
    assert distance < 0.01
    assert difference(camera, scaled(1 + (-0.001 + 0.001 + 0.001) / 3)) < 0.01


@pytest.mark.parametrize("lie", [1.005, 1.02, 1.05, 1.3])
def test_liar_however_far_pulls_no_harder(calibrated: Calibration, lie: float) -> None:
    """Five alike and one or two liars: the answer moves by a share of HUBER_WIDTHS."""
    cameras = [scaled(1.0)] * 5 + [scaled(lie)] * 2
    made = fields(calibrated, cameras)
    alone = made.locate(range(5))
    assert field_distance(alone.field, made.locate(range(6)).field) < 0.21
    assert field_distance(alone.field, made.locate(range(7)).field) < 0.41
    one, two = made.leave_out_influence(range(7), lambda rest: rest)
    assert (one, two) == (pytest.approx(0.2, abs=0.05), pytest.approx(0.4, abs=0.05))


def test_liar_without_rays_at_the_rim_hides_nothing(calibrated: Calibration) -> None:
    """A camera that folds within the image says nothing of its rim; the others do."""
    folded = scaled(1.0, distortion=-1.2)
    assert (
        0.3 < np.isfinite(folded.unproject(np.array([[1270.0, 5.0], [640.0, 360.0]]))).all(axis=1).mean() < 1
    )
    made = fields(calibrated, [scaled(1.0)] * 5 + [folded])
    camera, _ = made.fit(made.locate(range(6)))
    assert difference(camera, scaled(1.0)) < 0.5


def test_dense_board_moves_the_answer_no_more_than_others() -> None:
    """Specimens 0.3 % apart, five of them, and a liar with 2,401 corners a view."""
    product = worlds.World(CAMERA, 0.003)
    rng = np.random.default_rng(4)
    honest = [worlds.member(f"h{i}", worlds.specimen(product, rng), rng, corners=40) for i in range(5)]
    before = pool(honest, SIZE, "rectilinear", RULE)
    assert before.reliable
    for lie in (1.008, 0.985):
        liar = worlds.member("liar", scaled(lie), rng, corners=2401)
        after = pool([*honest, liar], SIZE, "rectilinear", RULE)
        moved = difference(before.calibration.camera, after.calibration.camera)
        assert moved < MOVED
        assert after.calibration.uncertainty().rms > 0.8 * before.calibration.uncertainty().rms


@pytest.mark.parametrize("number", range(4))
def test_liars_in_honest_worlds_move_no_reliable_answer(number: int) -> None:
    """`make bench DOCS=consensus` has a thousand."""
    rng = np.random.default_rng((19, number))
    product = worlds.world(rng)
    honest = [worlds.member(f"h{i}", worlds.specimen(product, rng), rng) for i in range(5)]
    before = pool(honest, SIZE, "rectilinear", RULE)
    false = worlds.lie(product.camera, ("focal", "distortion")[number % 2], rng)
    liars = [worlds.member(f"l{i}", false, rng) for i in range(2)]
    for count in (1, 2):
        after = pool([*honest, *liars[:count]], SIZE, "rectilinear", RULE)
        moved = difference(before.calibration.camera, after.calibration.camera)
        assert moved < MOVED or not after.reliable


def test_contributors_of_two_families_count_by_the_larger() -> None:
    """Three lines of the network, each with two addresses."""
    rng = np.random.default_rng(2)
    families = ("ipv4", "ipv4", "ipv4", "ipv6", "ipv6")
    members = [
        Member(str(i), str(i), tuple(populations.views(CAMERA, rng)), family)
        for i, family in enumerate(families)
    ]
    found = pool(members, SIZE, "rectilinear", RULE)
    assert (found.contributors, found.reliable) == (3, True)
    assert pool(members, SIZE, "rectilinear", Rule(min_contributors=4)).reason == "few_contributors"
