"""What the light functions import, in an interpreter of their own."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

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
