"""`make bench DOCS=hand`: guided captures by a simulated hand before drawn pictures, in simulated time.

12 cameras, ten captures each (`SEEDS=10`), with the pictures of `tests.helpers.real_hand`. The hand follows
the outline, 5 degrees and 5 % off.
"""

import os
from dataclasses import dataclass

import numpy as np

from calibdb_client.board import Board as ClientBoard
from calibdb_client.detection import Detector
from calibsolver import Board, Camera, rotation
from calibsolver.capture import Capture
from calibsolver.guidance import TargetPose
from calibsolver.guidance.pose_selection import estimate_outline, jaccard_index
from infra.console import track
from tests.bench import document
from tests.helpers.real_hand import Pose, RealCamera
from tests.helpers.solver import synthetic

BOARD = Board()
USER = synthetic.User(degrees=5.0, share=0.05)
FRAME_S = 1 / 15
REACTION_S = (0.5, 1.0)
TRAVEL_S, ANSWER_S, READ_S = 1.2, 0.4, 2.0
"""From pose to pose, until the service's answer, and to read why a view was refused."""
HOLD_S, LONG_HOLD_S, MIN_OVERLAP = 0.7, 1.5, 0.6
"""For which the page wants the board to be held still: at the target, and elsewhere."""
SKIP_S, IDLE_S, MAX_S = 15.0, 30.0, 180.0
"""On one target; without a new view; the longest capture."""
FINISHED_S = 90.0


def camera_of(truth: Camera, seed: int) -> RealCamera:
    """Make a source of pictures with the intrinsics of `truth`."""
    camera = RealCamera(size=truth.img_size, fx=truth.intrinsics[0], seed=seed)
    camera.matrix, camera.distortion = truth.matrix, truth.distortion
    return camera


def picture(camera: RealCamera, rvec: np.ndarray, tvec: np.ndarray) -> np.ndarray:
    """Picture (h, w), 8 bits, of the board held in a pose."""
    turn = rotation.matrix(rvec)
    camera.begin = camera.goal = Pose(turn, turn @ camera.middle + tvec)
    return camera.read()[1]


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
    rng, detector, source = np.random.default_rng(seed), Detector(ClientBoard()), camera_of(camera, seed)
    rules = Capture(BOARD, camera.img_size, camera.model)
    sitting = synthetic.Sitting(rules)
    target = rules.next_target([], sitting.estimate)
    skipped, unreached = list[TargetPose](), list[TargetPose]()
    time = posed = newest = 0.0
    refused, end = 0, "never"
    while time < MAX_S and end == "never":
        asked = synthetic.match_picture(BOARD, rules.camera(sitting.estimate), camera, target)
        found = detector.find(picture(source, *USER.hold(BOARD, asked, rng)))
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
    seeds = int(os.environ.get("SEEDS", "10"))
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
