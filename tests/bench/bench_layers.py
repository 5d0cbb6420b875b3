"""Size of what is deployed: both layers built for arm64 from their lock files, and the functions."""

import os
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.bench.table import Row

ROOT = Path(__file__).parents[2]
UV = ROOT / ".build/uv/bin/uv"


def megabytes(folder: Path) -> float:
    return sum(f.stat().st_size for f in folder.rglob("*") if f.is_file()) / 1e6


def rows() -> Iterator[Row]:
    subprocess.run(["make", "--silent", str(UV.relative_to(ROOT))], cwd=ROOT, check=True)
    with tempfile.TemporaryDirectory() as place:
        sizes = {}
        for layer in ("service", "solver"):
            target = Path(place, layer)
            subprocess.run(
                ["make", "--silent", f"build-{layer.title()}Layer", f"ARTIFACTS_DIR={target}"],
                cwd=ROOT / "layers" / layer,
                env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | {"UV": str(UV)},
                stderr=subprocess.DEVNULL,
                check=True,
            )
            sizes[layer] = megabytes(target)
    code = megabytes(ROOT / "functions")
    yield Row("solver layer, unzipped, arm64", sizes["solver"], 170, "MB")
    yield Row("largest function with all layers", sizes["service"] + sizes["solver"] + code, 200, "MB")
    yield Row("lookup with its layer", sizes["service"] + code, 30, "MB")
