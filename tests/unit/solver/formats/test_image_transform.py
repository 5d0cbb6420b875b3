"""Camera of a resized, cut, turned or mirrored picture, against the picture itself."""

from typing import Any

import numpy as np
import pytest

from calibsolver import CalibrationError, image_transform, models
from calibsolver.fitting.resection import reprojection_score
from tests.helpers.solver.export_sources import IMG_SIZE, image_rays, subject

TRANSFORMS = {
    "half": image_transform.resize(IMG_SIZE, (640, 360)),
    "stretched": image_transform.resize(IMG_SIZE, (960, 720)),
    "cut": image_transform.crop(IMG_SIZE, (160, 0), (960, 720)),
    **{f"turned {d}": image_transform.rotate(IMG_SIZE, d) for d in (90, 180, 270)},
    "mirrored": image_transform.mirror(IMG_SIZE),
    "turned and mirrored": image_transform.rotate(IMG_SIZE, 90).then(image_transform.mirror((720, 1280))),
}
TRANSFORMS["cut, stretched, turned and mirrored"] = (
    TRANSFORMS["cut"]
    .then(image_transform.resize((960, 720), (400, 300)))
    .then(image_transform.rotate((400, 300), 270))
    .then(image_transform.mirror((300, 400)))
)


@pytest.mark.parametrize("model", models.NAMES)
@pytest.mark.parametrize("name", TRANSFORMS)
def test_transformed_camera_projects_to_the_moved_pixels(name: str, model: str) -> None:
    turn = TRANSFORMS[name]
    before = subject(model)
    camera, views = image_transform.apply(turn, before.camera, before.views)
    rays, q = image_rays(before.camera)
    # the frame turns with the picture's axes; scales do not touch it
    frame = np.eye(3)
    frame[:2, :2] = np.sign(turn.linear)
    assert np.abs(camera.project(rays @ frame.T) - turn.pixels(q)).max() < 1e-6
    assert camera.img_size == turn.img_size
    upright, rest = turn.split()
    assert (np.diag(upright.linear) > 0).all()
    assert np.allclose(rest.pixels(upright.pixels(q)), turn.pixels(q), rtol=0, atol=1e-9)
    # The measurements went along: they fit as well as before, where no axis is scaled differently.
    if name != "stretched":
        scale = float(np.sqrt(abs(np.linalg.det(turn.linear))))
        was = reprojection_score(before.camera, before.views).rms
        assert reprojection_score(camera, views).rms == pytest.approx(scale * was, rel=1e-6)


def test_resizing_keeps_the_corner_of_the_image() -> None:
    half = image_transform.resize((640, 480), (320, 240))
    corners = np.array([[-0.5, -0.5], [639.5, 479.5]])
    assert half.pixels(corners).tolist() == [[-0.5, -0.5], [319.5, 239.5]]


@pytest.mark.parametrize(
    ("transform", "arguments"),
    [
        (image_transform.crop, ((700, 0), (640, 720))),
        (image_transform.crop, ((-1, 0), (640, 480))),
        (image_transform.rotate, (45,)),
        (image_transform.resize, ((0, 480),)),
        (image_transform.resize, ((100_000, 480),)),
    ],
)
def test_impossible_transforms_are_refused(transform: Any, arguments: tuple[Any, ...]) -> None:
    with pytest.raises(CalibrationError):
        transform(IMG_SIZE, *arguments)
