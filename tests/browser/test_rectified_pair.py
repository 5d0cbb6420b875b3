"""Rectified pairs of the SDK against OpenCV."""

import base64

import cv2
import numpy as np
import numpy.typing as npt
from playwright.sync_api import Page

from calibsolver import Camera
from calibsolver.rig.rectification import rectify
from calibsolver.rig.start import RigidMotion
from tests.helpers.browser.photographs import textured_board
from tests.helpers.browser.scripts import PLAIN, page_function
from tests.helpers.vectors import recorded

from ..conftest import THOROUGH
from .test_rectifier import camera, decoded

SIZE = (1280, 720)
HALF = np.array([[0.5, 0, -0.25], [0, 0.5, -0.25], [0, 0, 1]])  # px of a picture to those of its half
PACKINGS = (None, "beside")
MIXED = ("fisheye", "rational")
DRAWN = page_function("draw_pair")


def expected(
    one: Camera, r: npt.NDArray[np.float64], k: npt.NDArray[np.float64], picture: npt.NDArray[np.uint8]
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.bool_]]:
    """Rectified picture of matrix `k` by cv2.remap, and where the camera's picture is in it."""
    u, v = np.meshgrid(np.arange(SIZE[0] / 2), np.arange(SIZE[1] / 2))
    rays = np.stack([u.ravel(), v.ravel(), np.ones(u.size)], axis=1) @ np.linalg.inv(k).T @ r
    q = np.nan_to_num(one.project(rays), nan=-1e6).astype(np.float32).reshape(*u.shape, 2)
    x, y = np.ascontiguousarray(q[..., 0]), np.ascontiguousarray(q[..., 1])
    inside = (x > 1) & (y > 1) & (x < SIZE[0] - 2) & (y < SIZE[1] - 2)
    return np.asarray(cv2.remap(picture, x, y, cv2.INTER_LINEAR), dtype=np.uint8), inside


def test_a_pair_of_two_models_is_drawn_as_opencv_would(page: Page) -> None:
    (pair,) = [
        each
        for each in recorded("pairs")
        if tuple(each[side]["distortion_model"] for side in ("left", "right")) == MIXED
    ]
    left, right = camera(pair["left"]), camera(pair["right"])
    motion = RigidMotion.of_vector(np.array([*pair["pose"]["rvec"], *pair["pose"]["tvec"]]))
    found = rectify(left, right, motion)
    k = HALF @ found.p1[:, :3]
    # So soft that OpenCV's fractions, whole 1/32 px, do not show.
    both = np.asarray(cv2.GaussianBlur(textured_board((2 * SIZE[0], SIZE[1])), (0, 0), 3.0), dtype=np.uint8)
    png = base64.b64encode(cv2.imencode(".png", both)[1].tobytes()).decode()
    page.goto(PLAIN)
    for packing in PACKINGS if THOROUGH else PACKINGS[1:]:
        made = page.evaluate(DRAWN, [pair, png, packing])
        sides = (
            (left, found.r1, both[:, : SIZE[0]]),
            (right, found.r2, both[:, SIZE[0] :]),
        )
        for shown, (one, r, picture) in zip(made["shown"], sides, strict=True):
            ours = decoded(shown)[..., 0].astype(int)
            theirs, inside = expected(one, r, k, np.ascontiguousarray(picture))
            assert inside.mean() > 0.4
            assert np.abs(ours - theirs)[inside].max() <= 1, packing
        assert np.abs(np.array(made["matrix"]) - k).max() < 1e-6
        x = found.q @ (700.5, 300.5, 12, 1)
        assert np.abs(np.array(made["point"]) - found.r1.T @ (x[:3] / x[3])).max() < 1e-6
        assert made["eye"] == "left"
        assert made["early"] is False
