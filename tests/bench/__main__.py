"""`make bench`: the budgets as a table. `make bench ONLY=solver,lookup` runs a part."""

import functools
import importlib
import pkgutil
import sys
from collections.abc import Callable, Iterable

from infra.console import announce
from tests import bench
from tests.bench.document import is_chosen
from tests.bench.table import Row, render


def main() -> None:
    """Run every tests/bench/bench_*.py's rows() and print one table."""
    names = [m.name for m in pkgutil.iter_modules(bench.__path__) if m.name.startswith("bench_")]
    wanted = [name for name in names if is_chosen(name.removeprefix("bench_"))]
    rows: list[Row] = []
    say = functools.partial(print, file=sys.stderr, flush=True)
    for name in announce("bench", wanted, lambda name: name.removeprefix("bench_"), say=say):
        measure: Callable[[], Iterable[Row]] = importlib.import_module(f"tests.bench.{name}").rows
        rows += measure()
    print(render(rows))


if __name__ == "__main__":
    main()
