"""Straightening and distorting on the GPU: right for every model, quick enough, and nothing left behind."""

import base64
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from playwright.sync_api import Page

from calibsolver import Camera
from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.photographs import textured_board

from .conftest import CHROMIUM, chromium_path

LENSES = {
    "rectilinear": (900.0, [-0.28, 0.09, 0.001, -0.0005, -0.01]),
    "fisheye": (480.0, [-0.03, 0.01, -0.004, 0.001]),
    "rational": (800.0, [1.2, 0.3, 0.0005, -0.0004, 0.02, 1.5, 0.6, 0.06]),
    "omnidirectional": (900.0, [1.2, -0.1, 0.02, 0.0006, -0.0003]),
}
SIZE = (1280, 720)
WINDOWS, COUNT = 3, 60  # rectifiers that are made and disposed of
LARGEST = (2564, 1444)  # of a scene's picture
BALANCED = {"balance": 0.3, "zoom": 1.1, "scale": 0.5}
WARPED = """async ([asked, png]) => {
  const { Calibration } = await import("/sdk/calibdb.js");
  const { widePinhole } = await import("/sdk/rectification.js");
  const bytes = Uint8Array.from(atob(png), (letter) => letter.charCodeAt(0));
  const blob = new Blob([bytes], { type: "image/png" });
  const made = [];
  for (const [kind, calibration, options] of asked) {
    const warp = await new Calibration(calibration)[kind](options);
    const { img_size: size } = kind === "distorter" ? widePinhole(calibration) : calibration;
    warp.draw(await createImageBitmap(blob, 0, 0, ...size));
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [warp.canvas.width, warp.canvas.height];
    canvas.getContext("2d").drawImage(warp.canvas, 0, 0);
    made.push({ matrix: warp.camera_matrix, size: warp.img_size, png: canvas.toDataURL("image/png") });
    warp.dispose();
  }
  return made;
}"""
MADE_AND_GONE = """async ([calibration, scale, count]) => {
  const { Rectifier } = await import("/sdk/rectifier.js");
  const picture = new OffscreenCanvas(1280, 720);
  picture.getContext("2d").fillRect(0, 0, 1280, 720);
  for (let each = 0; each < count; each++) {
    const rectifier = new Rectifier(calibration, { balance: 0.5, scale });
    rectifier.draw(picture);
    rectifier.dispose();
    await new Promise((done) => setTimeout(done));
  }
}"""


def calibration(model: str) -> dict[str, Any]:
    focal, coefficients = LENSES[model]
    matrix = [[focal, 0, 650.0], [0, 1.01 * focal, 352.0], [0, 0, 1]]
    return {
        "img_size": SIZE,
        "camera_matrix": matrix,
        "distortion_coefficients": coefficients,
        "distortion_model": model,
    }


def camera(model: str) -> Camera:
    known = calibration(model)
    matrix, distortion = np.array(known["camera_matrix"]), np.array(known["distortion_coefficients"])
    return Camera(model=model, matrix=matrix, distortion=distortion, img_size=SIZE)


@pytest.fixture(scope="module")
def picture() -> npt.NDArray[np.uint8]:
    """A picture so soft that OpenCV's fractions, whole 1/32 px, do not show."""
    soft = cv2.GaussianBlur(textured_board(LARGEST), (0, 0), 3.0)
    gradient = sum(np.abs(np.gradient(soft.astype(float), axis=axis)) for axis in (0, 1))
    # Grey levels/px at one pixel in ten and in a thousand of a photograph of a board that is blurred as much.
    assert (np.percentile(gradient[: SIZE[1], : SIZE[0]], (90, 99.9)) > (16, 26)).all()
    return np.asarray(soft, dtype=np.uint8)


def asking(asked: list[tuple[str, str]], picture: npt.NDArray[np.uint8]) -> list[Any]:
    """Arguments of WARPED: warps to draw of the picture's upper left part, and the picture as PNG."""
    options: dict[str, dict[str, float]] = {"rectifier": BALANCED, "distorter": {}}
    png = base64.b64encode(cv2.imencode(".png", picture)[1].tobytes()).decode()
    return [[(kind, calibration(model), options[kind]) for kind, model in asked], png]


def decoded(made: dict[str, Any]) -> npt.NDArray[np.uint8]:
    data = np.frombuffer(base64.b64decode(made["png"].split(",")[1]), np.uint8)
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_UNCHANGED), dtype=np.uint8)


def compare(ours: Any, picture: npt.NDArray[np.uint8], q: npt.NDArray[np.float64]) -> float:
    """Largest difference in grey levels where the map is inside the picture."""
    x, y = np.float32(q[:, 0]).reshape(ours.shape[:2]), np.float32(q[:, 1]).reshape(ours.shape[:2])
    theirs = cv2.remap(picture, x, y, cv2.INTER_LINEAR).astype(int)
    h, w = picture.shape
    inside = (x > 1) & (y > 1) & (x < w - 2) & (y < h - 2)
    assert inside.mean() > 0.6
    return float(np.abs(ours[..., 0].astype(int) - theirs)[inside].max())


def check_straightened(made: dict[str, Any], model: str, picture: npt.NDArray[np.uint8]) -> None:
    ours = decoded(made)
    assert made["size"] == [640, 360] == [ours.shape[1], ours.shape[0]]
    u, v = np.meshgrid(np.arange(640.0), np.arange(360.0))
    rays = np.stack([u.ravel(), v.ravel(), np.ones(u.size)], axis=1) @ np.linalg.inv(made["matrix"]).T
    assert compare(ours, picture[: SIZE[1], : SIZE[0]], camera(model).project(rays)) <= 1


def check_distorted(made: dict[str, Any], model: str, picture: npt.NDArray[np.uint8]) -> None:
    ours = decoded(made)
    width, height = made["size"]
    assert width <= picture.shape[1]
    assert height <= picture.shape[0]
    u, v = np.meshgrid(np.arange(1280.0), np.arange(720.0))
    rays = camera(model).unproject(np.stack([u.ravel(), v.ravel()], axis=1))
    seen = (rays[:, 2:] > 0) & np.isfinite(rays).all(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        q = np.where(seen, (rays / rays[:, 2:]) @ np.array(made["matrix"]).T, -1e6)[:, :2]
    assert compare(ours, picture[:height, :width], q) <= 1
    outside = (q[:, 0] < -1) | (q[:, 1] < -1)
    assert (ours[..., 3].ravel()[outside] == 0).all(), "the video is seen there"


CHECKS = {"rectifier": check_straightened, "distorter": check_distorted}


@pytest.mark.parametrize("kind", CHECKS)
@pytest.mark.parametrize("model", LENSES)
def test_every_model_is_warped_as_opencv_would(
    page: Page, picture: npt.NDArray[np.uint8], model: str, kind: str
) -> None:
    page.goto("/board/")
    [made] = page.evaluate(WARPED, asking([(kind, model)], picture))
    CHECKS[kind](made, model, picture)


def test_every_model_is_warped_as_opencv_would_in_firefox(
    stack: str, picture: npt.NDArray[np.uint8], in_firefox: InFirefox
) -> None:
    asked = [(kind, model) for kind in CHECKS for model in LENSES]
    made = in_firefox(f"{stack}/board/", f"() => ({WARPED})({json.dumps(asking(asked, picture))})")
    assert len(made) == 8
    for (kind, model), each in zip(asked, made, strict=True):
        CHECKS[kind](each, model, picture)


def memory(pid: int) -> int:
    """Resident bytes of a process and all below it."""
    children = Path(f"/proc/{pid}/task/{pid}/children")
    below = sum(memory(int(child)) for child in children.read_text().split()) if children.exists() else 0
    pages = Path(f"/proc/{pid}/statm")
    return below + (4096 * int(pages.read_text().split()[1]) if pages.exists() else 0)


@pytest.mark.parametrize("scale", [0.25, pytest.param(1, marks=pytest.mark.thorough)])
def test_two_hundred_leave_nothing_behind(playwright: Any, stack: str, tmp_path: Path, scale: float) -> None:
    if not Path("/proc/self/statm").exists():
        pytest.skip("memory is read from /proc, which this system lacks")
    context = playwright.chromium.launch_persistent_context(
        tmp_path, executable_path=chromium_path(), args=CHROMIUM
    )
    page = context.pages[0]
    warnings: list[str] = []
    page.on("console", lambda message: warnings.append(message.text))
    page.goto(f"{stack}/board/")
    browser = min(  # the script that starts it is its parent
        int(path.parent.name)
        for path in Path("/proc").glob("[0-9]*/cmdline")
        if f"--user-data-dir={tmp_path}".encode() in (line := read(path)) and b"--type=" not in line
    )
    page.evaluate(MADE_AND_GONE, [calibration("rectilinear"), scale, 20])
    most = COUNT * 1280 * 720 * (8 * scale**2 + 4) / 10  # a tenth of their maps and pictures
    grown = []  # bytes a window; a leak grows in each, the browser's own processes come and go in some
    for _ in range(WINDOWS):
        before = memory(browser)
        page.evaluate(MADE_AND_GONE, [calibration("rectilinear"), scale, COUNT])
        grown.append(memory(browser) - before)
    print([f"{each / 1e6:+.0f} MB" for each in grown])
    assert sorted(grown)[WINDOWS // 2] < most
    assert not [text for text in warnings if "Too many active WebGL contexts" in text]
    context.close()


def read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""  # it has ended
