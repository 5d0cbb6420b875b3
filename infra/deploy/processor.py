"""Processor time of a computation here, relative to the machine on which the limits of requests were set.

`python -m infra.deploy.processor` prints the factor for the parameter `ProcessorFactor`, and compares it with
the template's default. A virtual processor of Lambda is slower than a core of a machine of the same
kind: `SHARE_OF_A_CORE` is an assumption, which no run on AWS confirms.
"""

import sys
import time

import numpy as np

from calibsolver import Board, View, fit
from infra.deploy.package import ROOT
from infra.deploy.smoke_capture import observe_board
from infra.deploy.template import parse

REFERENCE_S = 0.066
"""Processor time of `workload` on the machine on which `calibdb.http.call.MAX_COMPUTE_S` was set, s."""
SHARE_OF_A_CORE = 0.8
_RUNS = 15
_IMG_SIZE = (1280, 720)


def workload() -> None:
    """Fit the views of twenty captures, of boards as drawn."""
    board = Board()
    for seed in range(20):
        views = [View(board.points[ids], np.array(points)) for ids, points in observe_board(seed)]
        fit(views, _IMG_SIZE, board_shape=False)


def measure() -> float:
    """Measure the least processor time of several runs, s."""
    times = []
    for _ in range(_RUNS):
        begun = time.process_time()
        workload()
        times.append(time.process_time() - begun)
    return min(times)


def factor(seconds: float) -> float:
    """Compute the factor of Lambda from the processor time of the workload on a core like its own."""
    return seconds / REFERENCE_S / SHARE_OF_A_CORE


def main() -> int:
    """Print the factor; return 1 if the template's default is less."""
    seconds = measure()
    default = float(parse(ROOT / "template.yaml")["Parameters"]["ProcessorFactor"]["Default"])
    print(
        f"{seconds:.4f} s of processor time, {seconds / REFERENCE_S:.2f} of the reference's {REFERENCE_S} s"
    )
    print(f"ProcessorFactor {factor(seconds):.2f}, by default {default}")
    if factor(seconds) > default:
        print("calibDB: raise ProcessorFactor in template.yaml", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
