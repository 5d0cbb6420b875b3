"""Every handler is imported as Lambda would: its folder and its own layers on the path, nothing else.

A layer here is a folder of links, to what its lock file names and to our own package.
"""

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

import pytest

from infra.ci.import_handlers import functions, sources
from tests.helpers.data import ROOT

#: Imports each of some functions in a fork of its own, made when what it shares with the others is loaded
FORKING = """
import importlib, json, os, sys

layers, shared, folders = json.loads(sys.argv[1])
sys.path[:0] = layers
for name in shared:
    importlib.import_module(name)
for folder in folders:
    if not os.fork():
        sys.path.insert(0, folder)
        import app
        assert callable(app.handler)
        print(json.dumps([folder, sorted(sys.modules), sorted(sys.path)]), flush=True)
        os._exit(0)
    if os.wait()[1]:
        sys.exit(folder)
"""
#: where compiled modules are kept: isolated, an interpreter does not hear of it from the environment
COMPILED = ("-X", f"pycache_prefix={sys.pycache_prefix}") if sys.pycache_prefix else ()
#: what answers anything needs: requests, schemas, storage; idna where an address is written in Unicode
SERVED = {
    *("annotated_types", "anyio", "botocore", "calibdb", "dateutil", "idna", "itsdangerous", "jmespath"),
    *("mangum", "pydantic", "pydantic_core", "six", "starlette", "typing_extensions", "typing_inspection"),
    "urllib3",
}
COMPUTED = SERVED | {"calibsolver", "cv2", "numpy"}
#: of our own code, with what it needs: what takes long to load and nearly all functions use
SHARED = ("calibdb.http.application", "calibdb.service")
SHARED_COMPUTED = ("calibsolver.fitting",)
#: parts of what is used that only tests, pages, other protocols or other functions have a use for
UNUSED = (
    *("boto3", "numpy.f2py", "numpy.testing", "pydantic.v1", "starlette.staticfiles"),
    *("starlette.templating", "starlette.testclient", "sqlite3", "unittest", "xmlrpc"),
)
#: what these functions have no use for of the geometry
ELSEWHERE = {
    "submit": ("consensus", "formats", "guidance.overlay", "image_transform"),
    "next_pose": ("consensus", "formats", "image_transform", "quality.report"),
    "rig": ("consensus", "guidance.overlay"),
    "checks": ("capture.rules", "formats", "guidance", "image_transform", "quality"),
    "refit": ("capture", "formats", "guidance", "image_transform", "quality"),
}


def contents(layer: str) -> Iterator[Path]:
    """Files that `make layers` puts into a layer, as they are installed here."""
    yield from (p for p in (ROOT / "layers" / layer).iterdir() if (p / "__init__.py").exists())
    lock = (ROOT / "layers" / layer / "requirements.lock").read_text()
    for name in re.findall(r"(?m)^([\w.-]+)==", lock):
        try:
            of = distribution(name)
        except PackageNotFoundError:
            continue  # of another machine
        for top in {Path(file).parts[0] for file in of.files or ()} - {"..", "__pycache__"}:
            yield Path(str(of.locate_file(top)))


@pytest.fixture(scope="module")
def layers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("layers")
    places = {layer: folder / layer for layer in ("service", "solver")}
    for layer, place in places.items():
        place.mkdir()
        for there in set(contents(layer)):
            (place / there.name).symlink_to(there)
    return places


@pytest.fixture(scope="module")
def imported(layers: dict[str, Path]) -> dict[str, tuple[set[str], list[str]]]:
    alike = {}
    for folder, solver in functions(sources(ROOT)):
        alike.setdefault((solver, Path(folder).name in ELSEWHERE), []).append(str(ROOT / folder))
    lines = []
    for (solver, computing), folders in alike.items():
        places = [str(layers[name]) for name in ("service", "solver")[: 1 + solver]]
        shared = (*SHARED, *(SHARED_COMPUTED if computing else ()))
        script = [*COMPILED, "-c", FORKING, json.dumps([places, shared, folders])]
        command = [sys.executable, "-I", "-S", *script]  # without site-packages
        done = subprocess.run(command, capture_output=True, check=False, text=True)
        assert done.returncode == 0, done.stderr
        lines += map(json.loads, done.stdout.splitlines())
    return {Path(folder).name: (set(modules), path) for folder, modules, path in lines}


def foreign(modules: set[str]) -> set[str]:
    names = {name.partition(".")[0] for name in modules} - sys.stdlib_module_names - {"app", "__main__"}
    return {name for name in names if not name.startswith("_sysconfigdata")}


def test_every_handler_loads_with_its_own_layers_alone(imported: dict[str, Any]) -> None:
    assert len(imported) == len(list(ROOT.glob("functions/*/app.py")))
    for function, (_, path) in imported.items():
        assert not [p for p in path if "site-packages" in p or p == str(ROOT)], function


def test_handlers_import_only_used_libraries(imported: dict[str, Any]) -> None:
    for function, (modules, _) in imported.items():
        assert foreign(modules) <= (COMPUTED if function in ELSEWHERE else SERVED), function
        unused = [m for m in modules if m in UNUSED or m.startswith(tuple(f"{u}." for u in UNUSED))]
        assert unused == [], function


def test_solver_functions_import_only_their_packages(imported: dict[str, Any]) -> None:
    for function, without in ELSEWHERE.items():
        modules = imported[function][0]
        assert {"numpy", "calibsolver"} <= foreign(modules), function
        parts = [m.removeprefix("calibsolver.") for m in modules if m.startswith("calibsolver.")]
        assert [m for m in parts if m.startswith(without)] == [], function
