"""What the light functions import, in an interpreter of their own."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from infra.local.intrinsics import parse

ROOT = Path(__file__).parents[2]
SCRIPT = """
import json, sys, time
sys.path[:0] = {paths}
start = time.process_time()
import app
took = time.process_time() - start
print(json.dumps([took, sorted(name for name in sys.modules if "." not in name)]))
"""


def imported(function: str, layers: tuple[str, ...]) -> tuple[float, set[str]]:
    """Return CPU seconds that the handler's import took, best of three, and the top-level modules it left."""
    paths = [str(ROOT / "functions" / function), *(str(ROOT / "layers" / layer) for layer in layers)]
    best, modules = 1e9, set()
    for _ in range(3):
        run = subprocess.run(
            [sys.executable, "-c", SCRIPT.format(paths=paths)], capture_output=True, check=True, text=True
        )
        took, names = json.loads(run.stdout)
        best, modules = min(best, took), set(names)
    return best, modules


@pytest.mark.parametrize("function", ["auth", "lookup", "session", "export", "cameras"])
def test_light_functions_know_no_geometry(function: str) -> None:
    _, modules = imported(function, ("service",))
    assert not modules & {"numpy", "cv2", "calibsolver"}


def test_lookup_is_imported_in_less_than_400_ms() -> None:
    took, _ = imported("lookup", ("service",))
    assert took < 0.4


@pytest.mark.parametrize("function", ["next_pose", "submit", "refit"])
def test_the_solver_is_there_where_it_is_needed(function: str) -> None:
    _, modules = imported(function, ("service", "solver"))
    assert {"numpy", "calibsolver"} <= modules
    assert not modules & {"moto", "infra", "tests"}


def test_submit_is_imported_in_less_than_a_second() -> None:
    took, _ = imported("submit", ("service", "solver"))
    assert took < 1.0


def deployed() -> dict[str, tuple[str, ...]]:
    """Each function's folder, and the layers that the template gives it."""
    document = parse(ROOT / "template.yaml")
    resources, common = document["Resources"], document["Globals"]["Function"]["Layers"]
    return {
        Path(r["Properties"]["CodeUri"]).name: tuple(
            Path(resources[layer["Ref"]]["Properties"]["ContentUri"]).name
            for layer in [*common, *r["Properties"].get("Layers", [])]
        )
        for r in resources.values()
        if r["Type"] == "AWS::Serverless::Function"
    }


def test_every_function_finds_what_it_needs_in_its_own_layers() -> None:
    for function, layers in deployed().items():
        paths = [str(ROOT / "functions" / function), *(str(ROOT / "layers" / layer) for layer in layers)]
        script = f"import sys; sys.path[:0] = {paths}; import app; assert callable(app.handler)"
        run = subprocess.run(
            [sys.executable, "-I", "-c", script], capture_output=True, text=True, check=False
        )
        assert run.returncode == 0, (function, run.stderr)
