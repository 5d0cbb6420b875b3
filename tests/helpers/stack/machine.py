"""How fast this machine is now, so that a budget holds for the program and not for the machine."""

import time

import cv2
import numpy as np

#: CPU seconds that the work below takes on the machine that the budgets are for
USUAL = 0.017


def slowness() -> float:
    """How many times as long as usual this process takes for some work now; 1 at least."""
    picture = np.tile(np.arange(256, dtype=np.uint8), (512, 2))
    matrix = np.eye(24) + np.outer(np.arange(24), np.arange(24)) / 1000
    times = []
    for _ in range(5):
        begin = time.process_time()
        for _ in range(40):
            cv2.GaussianBlur(picture, (0, 0), 2.0)
            np.linalg.solve(matrix, matrix)
            sum(number * number for number in range(2_000))
        times.append(time.process_time() - begin)
    return max(1.0, sorted(times)[2] / USUAL)
