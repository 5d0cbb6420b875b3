"""`make bench DOCS=accuracy`: every real corner set with every model, ours beside OpenCV's.

Held out: five folds (view i in fold i mod 5) or the split of the set's authors; intrinsics from the training
views, the poses of the views left out fitted by `calibsolver.fitting.resection` for both sides. OpenCV runs
in a process of its own and is stopped after TIMEOUT seconds: training and folds together. Writes
docs/accuracy.md.
"""

import json
import math
import subprocess
import sys
import time
from collections.abc import Callable
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
        """True if there is a result for the whole set and for every fold."""
        return not self.failure and not self.note

    def cells(self) -> list[str]:
        if self.failure:
            return [self.failure, "", ""]
        held_out = self.note or f"{self.held_out:.3f}"
        return [f"{self.train:.3f}", held_out, duration(self.seconds)]


def duration(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds >= 1 else f"{1e3 * seconds:.0f} ms"


def summary(squares: list[float], points: list[int]) -> tuple[float, float]:
    """Rms over all folds of their mean squares, and the largest fold / the next."""
    folds = sorted(np.sqrt(squares))
    worst = folds[-1] / folds[-2] if len(folds) > 1 else 1.0
    return float(np.sqrt(np.average(squares, weights=points))), float(worst)


def ours(data: corners.Corners, model: str) -> Outcome:
    fitted = partial(fit, img_size=data.img_size, model=model, board_shape=False)
    try:
        calibration = fitted(data.training)
        seconds = min(timed(lambda: fitted(data.training)) for _ in range(3))
        squares, points = data.held_out(lambda views: fitted(views).camera)
    except CalibrationError as error:
        return Outcome(failure=error.code)
    held_out, worst = summary(squares, points)
    return Outcome("", calibration.avg_reprojection_error, held_out, worst, seconds)


def timed(action: Callable[[], object]) -> float:
    begin = time.perf_counter()
    action()
    return time.perf_counter() - begin


def opencv(data: corners.Corners, model: str) -> Outcome:
    command = [sys.executable, "-m", "tests.bench.opencv", data.name, model]
    late = False
    try:
        done = subprocess.run(command, capture_output=True, timeout=TIMEOUT, check=False)
        output, crashed = done.stdout, done.returncode
    except subprocess.TimeoutExpired as error:
        output, crashed, late = error.stdout or b"", 0, True
    # The last line may be half a line where it was stopped.
    lines = [json.loads(line) for line in output.decode().splitlines() if line.endswith("}")]
    if not lines:
        return Outcome(failure=f"> {TIMEOUT:.0f} s" if late else f"crashes ({crashed})")
    train, *folds = lines
    if "error" in train:
        return Outcome(failure=train["error"])
    bad = next((fold["error"] for fold in folds if "error" in fold), "")
    if bad or late or crashed:
        note = bad or (f"> {TIMEOUT:.0f} s" if late else "crashes")
        return Outcome("", train["rms"], seconds=train["seconds"], note=note)
    squares = [math.inf if fold["square"] is None else fold["square"] for fold in folds]
    held_out, worst = summary(squares, [fold["points"] for fold in folds])
    return Outcome("", train["rms"], held_out, worst, train["seconds"])


def main() -> None:
    results: dict[tuple[str, str], tuple[Outcome, Outcome]] = {}
    for name in track(corners.NAMES, "corner sets", len(corners.NAMES)):
        data = corners.load(name)
        for model in models.NAMES:
            results[name, model] = ours(data, model), opencv(data, model)
            print(
                name,
                model,
                *results[name, model][0].cells(),
                "|",
                *results[name, model][1].cells(),
                flush=True,
            )
    document.replace("corner sets", render(results))


def render(results: dict[tuple[str, str], tuple[Outcome, Outcome]]) -> str:
    parts = []
    header = ["set", "train", "held out", "time", "OpenCV: train", "held out", "time"]
    for model in models.NAMES:
        rows = [
            [name, *results[name, model][0].cells(), *results[name, model][1].cells()]
            for name in corners.NAMES
        ]
        parts.append(f"**{model}**\n\n{document.table(header, rows)}")
    parts.append(conclusion(results))
    return "\n\n".join(parts)


def conclusion(results: dict[tuple[str, str], tuple[Outcome, Outcome]]) -> str:
    """Summarise the tables in a paragraph."""
    least = {
        name: min(o.held_out for (n, _), pair in results.items() if n == name for o in pair if o.complete)
        for name, _ in results
    }

    def usable(side: int) -> int:
        return sum(
            pair[side].complete and pair[side].held_out < NONSENSE * least[name]
            for (name, _), pair in results.items()
        )

    mine, peers = zip(*results.values(), strict=True)
    both = [a.held_out / b.held_out for a, b in results.values() if a.complete and b.complete]
    return (
        f"Of {len(results)} pairs of set and model, calibDB fits {sum(a.complete for a in mine)} and gives a "
        f"reason for the others; OpenCV returns {sum(b.complete for b in peers)}. The held-out "
        f"error is within {NONSENSE:g} times the least of its set for {usable(0)} results of calibDB and "
        f"{usable(1)} of OpenCV. Where both have a result, calibDB's held-out error is "
        f"{np.median(both):.3f} times OpenCV's (median; at most {max(both):.3f} times). "
        f"Largest fold / next largest: at most "
        f"{max(a.worst_fold for a in mine if a.complete):.2f} for calibDB, "
        f"{max(b.worst_fold for b in peers if b.complete):.2f} for OpenCV."
    )


if __name__ == "__main__":
    main()
