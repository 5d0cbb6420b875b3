"""`make bench DOCS=hand`: guided captures by a simulated hand before drawn pictures, in simulated time.

12 cameras, five captures each (`SEEDS=5`). The board is printed on A4, and its paper bends by 1 mm. The hand
follows the outline, 5 degrees and 5 % off. Pictures have noise, motion blur, rolling shutter and JPEG.
"""

import os
from dataclasses import dataclass

import cv2
import numpy as np

from calibdb_client.board import Board as ClientBoard
from calibdb_client.detection import Detector
from calibsolver import Board, Camera, rotation
from calibsolver.capture import Capture
from calibsolver.guidance import TargetPose
from calibsolver.guidance.overlap import estimate_outline, jaccard_index
from calibsolver.guidance.overlay import draw_board, texture_coordinates
from infra.console import track
from tests.bench import document
from tests.helpers.solver import hands, synthetic

BOARD = Board()
CENTER = BOARD.outline.mean(axis=0)
BEND_MM = 1.0
USER = synthetic.User(degrees=5.0, share=0.05)
HAND = hands.Hand(readout_s=0.02, speed_cm_s=1.0, turn_deg_s=2.0)
"""Tremor and drift of a hand that holds the board still."""
EXPOSURE_S, EXPOSURES = 0.015, 3
FRAME_S = 1 / 15
REACTION_S = (0.5, 1.0)
TRAVEL_S, ANSWER_S, READ_S = 1.2, 0.4, 2.0
"""From pose to pose, until the service's answer, and to read why a view was refused."""
HOLD_S, LONG_HOLD_S, MIN_OVERLAP = 0.7, 1.5, 0.6
"""For which the page wants the board to be held still: at the target, and elsewhere."""
SKIP_S, IDLE_S, MAX_S = 15.0, 30.0, 180.0
"""On one target; without a new view; the longest capture."""
SQUARE_PX = 48
NOISE, JPEG_QUALITY = 2.0, 85
FINISHED_S = 90.0


def bend_of(rng: np.random.Generator) -> np.ndarray:
    """Coefficients (3,) of x x, x y and y y, from the centre: the height of the paper, squares."""
    drawn = rng.normal(size=3)
    height = heights((BOARD.points - CENTER)[:, :2], drawn)
    coefficients: np.ndarray = drawn * (BEND_MM / 10 / hands.SQUARE_CM / np.abs(height).max())
    return coefficients


def picture(
    camera: Camera, rvec: np.ndarray, tvec: np.ndarray, bend: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Picture (h, w), 8 bits, of the board in a hand that trembles."""
    w, h = camera.img_size
    shift = HAND.speed_cm_s / hands.SQUARE_CM * rng.normal(size=3)
    turn = np.radians(HAND.turn_deg_s) * rng.normal(size=3)
    edge = (SQUARE_PX,) * 4
    sheet = cv2.copyMakeBorder(
        draw_board(BOARD, SQUARE_PX), *edge, cv2.BORDER_CONSTANT, value=(255, 255, 255)
    )

    def coordinates(late: float) -> np.ndarray:
        r = rotation.matrix(late * turn) @ rotation.matrix(rvec)
        place = rotation.matrix(rvec) @ CENTER + tvec + late * shift
        t = place - r @ CENTER
        pose = TargetPose(rotation.vector(r), t, (), np.empty((0, 2)), np.empty((0, 2)), "", "", "first", 0)
        flat = texture_coordinates(camera, pose, (0, 0, w, h), SQUARE_PX, np.ones(2), np.zeros(3))
        eye = -r.T @ t
        xy = (flat + 0.5) / SQUARE_PX
        bent = xy + (eye[:2] - xy) * (heights(xy - CENTER[:2], bend) / eye[2])[..., None]
        return (bent + 1) * SQUARE_PX - 0.5

    row = np.linspace(-0.5, 0.5, h)[:, None, None] * HAND.readout_s
    start, end = coordinates(-0.5), coordinates(0.5)
    light = np.zeros((h, w))
    for exposed in np.linspace(-0.5, 0.5, EXPOSURES) * EXPOSURE_S:
        seen = (start + (row + exposed + 0.5) * (end - start)).astype(np.float32)
        place, part = cv2.convertMaps(seen, np.empty(0), cv2.CV_16SC2)
        light += cv2.remap(
            sheet, place, part, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=140
        )
    grey = 30 + 0.75 * cv2.GaussianBlur(light / EXPOSURES, (0, 0), 0.7)
    noisy = np.clip(grey + rng.normal(0, NOISE, grey.shape), 0, 255).astype(np.uint8)
    _, coded = cv2.imencode(".jpg", noisy, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return np.asarray(cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE), dtype=np.uint8)


def heights(xy: np.ndarray, bend: np.ndarray) -> np.ndarray:
    """Height of bent paper at places (..., 2), squares, from the board's centre."""
    x, y = np.clip(xy[..., 0], -6, 6), np.clip(xy[..., 1], -6, 6)
    height: np.ndarray = bend[0] * x * x + bend[1] * x * y + bend[2] * y * y
    return height


@dataclass(frozen=True)
class Outcome:
    """End of one capture: why, after how long, with how many views; stated and actual error, px rms."""

    end: str
    seconds: float
    views: int
    refused: int
    stated: float
    actual: float


def capture(camera: Camera, seed: int) -> Outcome:
    """Run one capture until it ends by itself, or for MAX_S."""
    rng, detector = np.random.default_rng(seed), Detector(ClientBoard())
    bend = bend_of(rng)
    rules = Capture(BOARD, camera.img_size, camera.model)
    sitting = synthetic.Sitting(rules)
    target = rules.next_target([], sitting.estimate)
    skipped, unreached = list[TargetPose](), list[TargetPose]()
    time = posed = newest = 0.0
    refused, end = 0, "never"
    while time < MAX_S and end == "never":
        asked = synthetic.match_picture(BOARD, rules.camera(sitting.estimate), camera, target)
        found = detector.find(picture(camera, *USER.hold(BOARD, asked, rng), bend, rng))
        time += rng.uniform(*REACTION_S) + TRAVEL_S + rng.uniform(0, FRAME_S)
        if found is not None:
            view = BOARD.view(found.ids, found.points)
            outline = estimate_outline(BOARD, view)
            there = jaccard_index(target.outline, outline, camera.img_size) > MIN_OVERLAP
            time += (HOLD_S if there else LONG_HOLD_S) + ANSWER_S
            if sitting.offer(target, view).estimate is not None:
                unreached, skipped = [*unreached, *skipped], []
                newest = posed = time
                end = sitting.estimate.end or end
                target = rules.next_target(sitting.views, sitting.estimate, (), unreached)
                continue
        refused += 1
        time += READ_S
        if sitting.is_exhausted or (len(sitting.used) >= 4 and time - newest > IDLE_S):
            end = "nothing_new"
        elif time - posed > SKIP_S:
            skipped, posed = [*skipped, target], time
            target = rules.next_target(sitting.views, sitting.estimate, skipped, unreached)
    calibration, uncertainty = sitting.estimate.calibration, sitting.estimate.uncertainty
    views = len(sitting.views)
    if calibration is None or uncertainty is None:
        return Outcome(end, time, views, refused, np.inf, np.inf)
    actual = synthetic.rms_error(camera, calibration.camera)
    return Outcome(end, time, views, refused, uncertainty.rms, actual)


def row(name: str, outcomes: list[Outcome]) -> list[str]:
    seconds = np.array([o.seconds if o.end != "never" else np.inf for o in outcomes])
    return [
        name,
        str(len(outcomes)),
        str(int((seconds <= FINISHED_S).sum())),
        f"{np.median(seconds):.0f} s",
        f"{np.percentile(seconds, 95):.0f} s",
        f"{np.median([o.views for o in outcomes]):.0f}",
        f"{np.mean([o.refused for o in outcomes]):.1f}",
        f"{np.median([o.stated for o in outcomes]):.2f}",
        f"{np.median([o.actual for o in outcomes]):.2f}",
        str(sum(o.actual <= 2 * o.stated for o in outcomes)),
    ]


def main() -> None:
    seeds = int(os.environ.get("SEEDS", "5"))
    cameras = synthetic.rectilinear_cameras()
    runs = [(camera, 100 * i + seed) for i, camera in enumerate(cameras) for seed in range(seeds)]
    outcomes = [capture(*run) for run in track(runs, "hand", len(runs))]
    for reason in sorted({o.end for o in outcomes}):
        print(reason, sum(o.end == reason for o in outcomes))
    header = ["hand", "captures", f"ended within {FINISHED_S:.0f} s", "median", "95 %", "views", "refused"]
    header += ["stated, px", "actual, px", "actual within twice the stated"]
    table = document.table(header, [row("5 degrees and 5 % off, paper bent by 1 mm", outcomes)])
    document.replace("hand", table)


if __name__ == "__main__":
    main()
