"""Rectifier, distorter and rectified pairs of the SDK against OpenCV, and after the loss of the GPU."""

import base64
import functools
import json
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from playwright.sync_api import BrowserContext, Page

from calibsolver import Camera
from calibsolver.rig.rectification import rectify
from calibsolver.rig.start import RigidMotion
from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.photographs import textured_board
from tests.helpers.browser.scripts import FOLDER, PLAIN, page_function
from tests.helpers.marks import thorough
from tests.helpers.vectors import recorded

Size = tuple[int, int]

#: focal length for a picture of 1280 px, and distortion
LENSES = {
    "rectilinear": (900.0, [-0.28, 0.09, 0.001, -0.0005, -0.01]),
    "fisheye": (480.0, [-0.03, 0.01, -0.004, 0.001]),
    "rational": (800.0, [1.2, 0.3, 0.0005, -0.0004, 0.02, 1.5, 0.6, 0.06]),
    "omnidirectional": (900.0, [1.2, -0.1, 0.02, 0.0006, -0.0003]),
}
FULL, HALF = (1280, 720), (640, 360)
SIZES = [pytest.param(HALF, id="640"), pytest.param(FULL, id="1280", marks=pytest.mark.thorough)]
BALANCED = {"balance": 0.3, "zoom": 1.1, "scale": 0.5}
WARPED = page_function("warp")
DRAWN = page_function("draw_pair")
MIXED = ("fisheye", "rational")
SMALLER = np.array([[0.5, 0, -0.25], [0, 0.5, -0.25], [0, 0, 1]])  # px of a picture to those of its half
LOST_GPU = (FOLDER / "lost_gpu.js").read_text()
WARPS_WITHOUT_GPU = f"async (calibration) => {{ {LOST_GPU} return sumsOfWarps(calibration); }}"
MADE_AND_GONE = """async ([calibration, count]) => {
  const { Rectifier } = await import("/sdk/rectifier.js");
  const picture = new OffscreenCanvas(1280, 720);
  picture.getContext("2d").fillRect(0, 0, 1280, 720);
  for (let each = 0; each < count; each++) {
    const rectifier = new Rectifier(calibration, { balance: 0.5, scale: 0.25 });
    rectifier.draw(picture);
    rectifier.dispose();
    await new Promise((done) => setTimeout(done));
  }
}"""


def calibration(model: str, size: Size = FULL) -> dict[str, Any]:
    focal, coefficients = LENSES[model]
    scale = size[0] / FULL[0]
    cx, cy = scale * 650.5 - 0.5, scale * 352.5 - 0.5
    matrix = [[scale * focal, 0, cx], [0, scale * 1.01 * focal, cy], [0, 0, 1]]
    return {
        "img_size": size,
        "camera_matrix": matrix,
        "distortion_coefficients": coefficients,
        "distortion_model": model,
    }


def camera(record: dict[str, Any]) -> Camera:
    matrix, distortion = np.array(record["camera_matrix"]), np.array(record["distortion_coefficients"])
    w, h = record["img_size"]
    return Camera(model=record["distortion_model"], matrix=matrix, distortion=distortion, img_size=(w, h))


@functools.cache
def soft_picture(size: Size) -> npt.NDArray[np.uint8]:
    """A picture twice as large, so soft that OpenCV's fractions of 1/32 px do not show."""
    width, height = size
    soft = cv2.GaussianBlur(textured_board((2 * width + 4, 2 * height + 4)), (0, 0), 3.0)
    gradient = sum(np.abs(np.gradient(soft[:height, :width].astype(float), axis=axis)) for axis in (0, 1))
    # Grey levels/px, as of a photo of a board with the same blur
    assert (np.percentile(gradient, (90, 99.9)) > (16, 26)).all()
    return np.asarray(soft, dtype=np.uint8)


def asking(asked: list[tuple[str, str]], size: Size) -> list[Any]:
    """Arguments of WARPED: warps of the picture's upper left part, and the picture as PNG."""
    options: dict[str, dict[str, float]] = {"rectifier": BALANCED, "distorter": {}}
    png = base64.b64encode(cv2.imencode(".png", soft_picture(size))[1].tobytes()).decode()
    return [[(kind, calibration(model, size), options[kind]) for kind, model in asked], png]


def decoded(made: dict[str, Any]) -> npt.NDArray[np.uint8]:
    data = np.frombuffer(base64.b64decode(made["png"].split(",")[1]), np.uint8)
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_UNCHANGED), dtype=np.uint8)


def compare(ours: Any, picture: npt.NDArray[np.uint8], q: npt.NDArray[np.float64], least: float) -> float:
    """Largest difference in grey levels inside the picture, which is at least a part of what is drawn."""
    x, y = np.float32(q[:, 0]).reshape(ours.shape[:2]), np.float32(q[:, 1]).reshape(ours.shape[:2])
    theirs = cv2.remap(picture, x, y, cv2.INTER_LINEAR).astype(int)
    h, w = picture.shape
    inside = (x > 1) & (y > 1) & (x < w - 2) & (y < h - 2)
    assert inside.mean() > least
    return float(np.abs(ours[..., 0].astype(int) - theirs)[inside].max())


def rays_of(picture: npt.NDArray[np.uint8], matrix: Any) -> npt.NDArray[np.float64]:
    """Directions (n, 3) of the pixels of a pinhole's picture, row by row."""
    h, w = picture.shape[:2]
    u, v = np.meshgrid(np.arange(float(w)), np.arange(float(h)))
    rays: npt.NDArray[np.float64] = (
        np.stack([u.ravel(), v.ravel(), np.ones(u.size)], axis=1) @ np.linalg.inv(matrix).T
    )
    return rays


def check_straightened(made: dict[str, Any], model: str, size: Size) -> None:
    ours = decoded(made)
    w, h = size
    assert made["size"] == [w // 2, h // 2] == [ours.shape[1], ours.shape[0]]
    q = camera(calibration(model, size)).project(rays_of(ours, made["matrix"]))
    assert compare(ours, soft_picture(size)[:h, :w], q, 0.6) <= 1


def check_distorted(made: dict[str, Any], model: str, size: Size) -> None:
    ours = decoded(made)
    picture = soft_picture(size)
    width, height = made["size"]
    assert width <= picture.shape[1]
    assert height <= picture.shape[0]
    u, v = np.meshgrid(np.arange(float(size[0])), np.arange(float(size[1])))
    rays = camera(calibration(model, size)).unproject(np.stack([u.ravel(), v.ravel()], axis=1))
    seen = (rays[:, 2:] > 0) & np.isfinite(rays).all(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        q = np.where(seen, (rays / rays[:, 2:]) @ np.array(made["matrix"]).T, -1e6)[:, :2]
    assert compare(ours, picture[:height, :width], q, 0.6) <= 1
    outside = (q[:, 0] < -1) | (q[:, 1] < -1)
    assert (ours[..., 3].ravel()[outside] == 0).all(), "the video is seen there"


CHECKS = {"rectifier": check_straightened, "distorter": check_distorted}


ASKED = [(kind, model) for kind in CHECKS for model in LENSES]


def check_all(asked: list[tuple[str, str]], made: list[Any], size: Size) -> None:
    for (kind, model), each in zip(asked, made, strict=True):
        CHECKS[kind](each, model, size)


@pytest.mark.parametrize("size", SIZES)
def test_every_model_is_warped_as_opencv_would(page: Page, size: Size) -> None:
    page.goto(PLAIN)
    check_all(ASKED, page.evaluate(WARPED, asking(ASKED, size)), size)


@pytest.mark.parametrize(
    ("asked", "size"),
    [
        pytest.param([("rectifier", "fisheye"), ("distorter", "rational")], HALF, id="two"),
        pytest.param(ASKED, FULL, id="all", marks=pytest.mark.thorough),
    ],
)
def test_models_are_warped_as_opencv_would_in_firefox(
    stack: str, in_firefox: InFirefox, asked: list[tuple[str, str]], size: Size
) -> None:
    made = in_firefox(f"{stack}{PLAIN}", f"() => ({WARPED})({json.dumps(asking(asked, size))})")
    check_all(asked, made, size)


def test_disposed_rectifiers_leave_no_context_behind(page: Page) -> None:
    """A browser drops the oldest of more than 16 contexts, with a warning, which fails the test."""
    page.goto(PLAIN)
    page.evaluate(MADE_AND_GONE, [calibration("rectilinear"), 20])


@pytest.mark.parametrize("packing", ["beside", *thorough(None)])
def test_a_pair_of_two_models_is_drawn_as_opencv_would(page: Page, packing: str | None) -> None:
    pairs = recorded("pairs")
    (pair,) = [
        each for each in pairs if tuple(each[side]["distortion_model"] for side in ("left", "right")) == MIXED
    ]
    left, right = camera(pair["left"]), camera(pair["right"])
    found = rectify(
        left, right, RigidMotion.of_vector(np.array([*pair["pose"]["rvec"], *pair["pose"]["tvec"]]))
    )
    k = SMALLER @ found.p1[:, :3]
    w, h = FULL
    both = soft_picture(FULL)[:h, : 2 * w]
    png = base64.b64encode(cv2.imencode(".png", both)[1].tobytes()).decode()
    page.goto(PLAIN)
    made = page.evaluate(DRAWN, [pair, png, packing])
    sides = ((left, found.r1, both[:, :w]), (right, found.r2, both[:, w:]))
    for shown, (one, r, picture) in zip(made["shown"], sides, strict=True):
        ours = decoded(shown)
        q = np.nan_to_num(one.project(rays_of(ours, k) @ r), nan=-1e6)
        assert compare(ours, np.ascontiguousarray(picture), q, 0.4) <= 1
    assert np.abs(np.array(made["matrix"]) - k).max() < 1e-6
    x = found.q @ (700.5, 300.5, 12, 1)
    assert np.abs(np.array(made["point"]) - found.r1.T @ (x[:3] / x[3])).max() < 1e-6
    assert made["eye"] == "left"
    assert made["early"] is False


def check_warps(sums: list[dict[str, Any]]) -> None:
    assert len(sums) == 2
    for each in sums:
        assert each["before"] > 1e6
        assert each["after"] == each["before"]
        assert each["meanwhile"] < each["before"]


def test_what_was_on_the_gpu_is_made_anew(context: BrowserContext) -> None:
    page = context.new_page()
    page.goto(PLAIN)
    check_warps(page.evaluate(WARPS_WITHOUT_GPU, calibration("rectilinear", HALF)))


@pytest.mark.thorough
def test_what_was_on_the_gpu_is_made_anew_in_firefox(stack: str, in_firefox: InFirefox) -> None:
    function = f"() => ({WARPS_WITHOUT_GPU})({json.dumps(calibration('rectilinear'))})"
    check_warps(in_firefox(f"{stack}{PLAIN}", function))


@pytest.mark.thorough
def test_overlays_return_with_the_gpu_and_report_its_loss(context: BrowserContext) -> None:
    overlays = context.new_page()
    overlays.goto("/ar/?virtual=1&k1=-0.3&error=0&rate=10&hand=quick")
    overlays.locator("#rms:not(:empty)").wait_for()
    counts = overlays.evaluate(f"async () => {{ {LOST_GPU} return countsOfOverlays(); }}")
    assert [each["mode"] for each in counts] == ["matrix", "rectified", "distorted", "estimate"]
    for each in counts:
        assert each["before"] > 10_000, each
        assert each["after"] > 0.9 * each["before"], each
    overlays.evaluate(f"async () => {{ {LOST_GPU} await lose(layer()); }}")
    overlays.locator("#failure", has_text="The graphics processor stopped responding.").wait_for()
    overlays.locator("#again").click()
    overlays.locator("#rms:not(:empty)").wait_for()
