"""Import time of the handlers, each in a fresh interpreter with its own layers."""

import statistics
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.bench.table import Row
from tests.service.test_imports import import_time, link_layers

BUDGETS_MS = {"lookup": 400, "submit": 1000}
RUNS = 5


def rows() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder:
        layers = link_layers(Path(folder))
        for function, budget in BUDGETS_MS.items():
            took = statistics.median(import_time(function, layers) for _ in range(RUNS))
            yield Row(f"imports of {function}, time of the processor", 1000 * took, budget, "ms")
