"""`make bench`: the budgets as a table. `make bench ONLY=solver,lookup` runs a part."""

import importlib
import os
import pkgutil
import sys
from collections.abc import Callable, Iterable

from tests import bench
from tests.bench.table import Row, render


def main() -> int:
    """Run every tests/bench/bench_*.py's rows() and print one table."""
    only = set(filter(None, os.environ.get("ONLY", "").split(",")))
    names = [m.name for m in pkgutil.iter_modules(bench.__path__) if m.name.startswith("bench_")]
    rows: list[Row] = []
    for name in names:
        if only and name.removeprefix("bench_") not in only:
            continue
        print(f"{name.removeprefix('bench_')} …", file=sys.stderr, flush=True)
        measure: Callable[[], Iterable[Row]] = importlib.import_module(f"tests.bench.{name}").rows
        rows += measure()
    print(render(rows))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
