"""Size of what is deployed: both layers built for arm64 from their lock files, and the functions."""

import subprocess
from collections.abc import Iterator

from infra.deploy.layers import BUILT, ROOT, BuiltLayer
from tests.bench.table import Row


def rows() -> Iterator[Row]:
    subprocess.run(["make", "--silent", "layers"], cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
    service, solver = (BuiltLayer.of(BUILT / name).megabytes for name in ("service", "solver"))
    code = BuiltLayer.of(ROOT / "functions").megabytes
    yield Row("solver layer, unzipped, arm64", solver, 170, "MB")
    yield Row("largest function with all layers", service + solver + code, 200, "MB")
    yield Row("lookup with its layer", service + code, 30, "MB")
