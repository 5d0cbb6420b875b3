"""`make bench DOCS=accuracy`: every real corner set with every model, ours and OpenCV's.

Held out: folds of `corners`, intrinsics from the training views, poses of the views left out fitted for both.
OpenCV runs in a process of its own, which is stopped after TIMEOUT seconds: training and folds together.
"""

import json
import math
import subprocess
import sys
import time
from dataclasses import dataclass
from functools import partial

import numpy as np

from calibsolver import CalibrationError, fit, models
from infra.console import track
from tests.bench import corners, document

TIMEOUT = 25.0
NONSENSE = 3.0
"""Times the least held-out error of a set beyond which a result is none."""


@dataclass(frozen=True)
class Outcome:
    """Px rms on the training views and on those left out, time of the training; or why there is none."""

    failure: str = ""
    train: float = math.nan
    held_out: float = math.nan
    worst_fold: float = math.nan
    """Largest fold / largest of the others."""
    seconds: float = math.nan
    note: str = ""

    @property
    def complete(self) -> bool:
        return not self.failure and not self.note

    def cells(self) -> list[str]:
        if self.failure:
            return [self.failure, "", ""]
        time = f"{self.seconds:.1f} s" if self.seconds >= 1 else f"{1e3 * self.seconds:.0f} ms"
        return [f"{self.train:.3f}", self.note or f"{self.held_out:.3f}", time]


def outcome(train: float, squares: list[float], points: list[int], seconds: float) -> Outcome:
    folds = sorted(np.sqrt(squares))
    worst = float(folds[-1] / folds[-2]) if len(folds) > 1 else 1.0
    return Outcome("", train, corners.rms(squares, points), worst, seconds)


def ours(data: corners.Corners, model: str) -> Outcome:
    fitted = partial(fit, img_size=data.img_size, model=model, board_shape=False)
    times = []
    try:
        for _ in range(3):
            begin = time.perf_counter()
            calibration = fitted(data.training)
            times.append(time.perf_counter() - begin)
        squares, points = data.held_out(lambda views: fitted(views).camera)
    except CalibrationError as error:
        return Outcome(failure=error.code)
    return outcome(calibration.avg_reprojection_error, squares, points, min(times))


def opencv(data: corners.Corners, model: str) -> Outcome:
    command = [sys.executable, "-m", "tests.bench.opencv", data.name, model]
    failure = ""
    try:
        done = subprocess.run(command, capture_output=True, timeout=TIMEOUT, check=False)
        output = done.stdout
        if done.returncode:
            failure = f"crashes ({done.returncode})"
    except subprocess.TimeoutExpired as error:
        output = error.stdout or b""
        failure = f"> {TIMEOUT:.0f} s"
    # The last line may be half a line where it was stopped.
    lines = [json.loads(line) for line in output.decode().splitlines() if line.endswith("}")]
    if not lines:
        return Outcome(failure=failure)
    train, *folds = lines
    if "error" in train:
        return Outcome(failure=train["error"])
    note = next((fold["error"] for fold in folds if "error" in fold), failure)
    if note:
        return Outcome("", train["rms"], seconds=train["seconds"], note=note)
    squares = [math.inf if fold["square"] is None else fold["square"] for fold in folds]
    return outcome(train["rms"], squares, [fold["points"] for fold in folds], train["seconds"])


def main() -> None:
    results: dict[tuple[str, str], tuple[Outcome, Outcome]] = {}
    for name in track(corners.NAMES, "corner sets", len(corners.NAMES)):
        data = corners.load(name)
        for model in models.NAMES:
            results[name, model] = ours(data, model), opencv(data, model)
            print(name, model, cells(results[name, model]), flush=True)
    header = ["set", "train", "held out", "time", "OpenCV: train", "held out", "time"]
    parts = []
    for model in models.NAMES:
        rows = [[name, *cells(results[name, model])] for name in corners.NAMES]
        parts.append(f"**{model}**\n\n{document.table(header, rows)}")
    document.replace("corner sets", "\n\n".join([*parts, conclusion(results)]))


def cells(pair: tuple[Outcome, Outcome]) -> list[str]:
    return [cell for side in pair for cell in side.cells()]


def conclusion(results: dict[tuple[str, str], tuple[Outcome, Outcome]]) -> str:
    least = {
        name: min(o.held_out for (n, _), pair in results.items() if n == name for o in pair if o.complete)
        for name, _ in results
    }

    def usable(side: int) -> int:
        return sum(
            pair[side].complete and pair[side].held_out < NONSENSE * least[name]
            for (name, _), pair in results.items()
        )

    mine, peers = ([o for o in side if o.complete] for side in zip(*results.values(), strict=True))
    both = [a.held_out / b.held_out for a, b in results.values() if a.complete and b.complete]
    return (
        f"Of {len(results)} pairs of set and model, calibDB fits {len(mine)} and gives a "
        f"reason for the others; OpenCV returns {len(peers)}. The held-out "
        f"error is within {NONSENSE:g} times the least of its set for {usable(0)} results of calibDB and "
        f"{usable(1)} of OpenCV. Where both have a result, calibDB's held-out error is "
        f"{np.median(both):.3f} times OpenCV's (median; at most {max(both):.3f} times). "
        f"Largest fold / next largest: at most {max(o.worst_fold for o in mine):.2f} for calibDB, "
        f"{max(o.worst_fold for o in peers):.2f} for OpenCV."
    )


if __name__ == "__main__":
    main()
