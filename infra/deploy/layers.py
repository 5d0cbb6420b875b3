"""Check of the built layers in `.build/layers` against Lambda's limits and size budgets: `make layers`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILT = ROOT / ".build" / "layers"
# MB unzipped, 10^6 bytes. Lambda takes 250 for a function with all its layers.
MAX_MB = {"functions with the solver": 200.0, "lookup": 30.0}
# What must not be in a layer: another machine's code, and what only building needs.
_FOREIGN = ("x86_64", "win32", "darwin")


@dataclass(frozen=True)
class BuiltLayer:
    """One layer as it lies in its folder.

    `megabytes`: unzipped, 10^6 bytes. `compiled`: share of the modules that are byte-compiled for Python
    3.13. `foreign`: libraries of other machines than Lambda's.
    """

    megabytes: float
    compiled: float
    foreign: tuple[str, ...]

    @classmethod
    def of(cls, folder: Path) -> BuiltLayer:
        """Inspect a layer's folder."""
        files = [path for path in folder.rglob("*") if path.is_file()]
        sources = [path for path in files if path.suffix == ".py"]
        compiled = {path.name.removesuffix(".cpython-313.pyc") for path in files if path.suffix == ".pyc"}
        return cls(
            megabytes=sum(path.stat().st_size for path in files) / 1e6,
            compiled=sum(path.stem in compiled for path in sources) / max(1, len(sources)),
            foreign=tuple(
                path.name
                for path in files
                if path.suffix in (".so", ".dll", ".dylib") and any(name in path.name for name in _FOREIGN)
            ),
        )


def problems(service: BuiltLayer, solver: BuiltLayer, functions: float) -> Iterator[str]:
    """Find what prevents a deployment of the layers; `functions`: MB of the functions' own code."""
    sizes = {
        "functions with the solver": service.megabytes + solver.megabytes + functions,
        "lookup": service.megabytes + functions,
    }
    for name, size in sizes.items():
        if size > MAX_MB[name]:
            yield f"{name}: {size:.1f} MB, more than {MAX_MB[name]:.0f}"
    for name, layer in (("service", service), ("solver", solver)):
        if layer.foreign:
            yield f"{name}: of another machine: {', '.join(layer.foreign)}"
        if layer.compiled < 1:
            yield f"{name}: {100 * layer.compiled:.0f} % of its modules are compiled"


def main() -> int:
    """Print the sizes; return 1 if something is wrong."""
    layers = {name: BuiltLayer.of(BUILT / name) for name in ("service", "solver")}
    functions = BuiltLayer.of(ROOT / "functions").megabytes
    for name, layer in layers.items():
        print(f"{name:8} {layer.megabytes:6.1f} MB, {100 * layer.compiled:.0f} % compiled")
    messages = list(problems(layers["service"], layers["solver"], functions))
    for problem in messages:
        print(f"calibDB: {problem}", file=sys.stderr)
    return 1 if messages else 0


if __name__ == "__main__":
    sys.exit(main())
