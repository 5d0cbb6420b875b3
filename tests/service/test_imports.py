"""Every handler is imported as Lambda would: its folder and its own layers on the path, nothing else.

A layer here is a folder of links, to what its lock file names and to our own package, and the interpreter
starts without site-packages.
"""

import functools
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

import pytest

from infra.deploy.package import complete_template

ROOT = Path(__file__).parents[2]
#: The modules of each function in a fork of its own, made when what they share is loaded. `groups`: layers
#: besides the first one, shared modules, and the folders of the functions that have them.
FORKING = """
import importlib, json, os, sys

def fork(work, *arguments):
    sys.stdout.flush()
    child = os.fork()
    if not child:
        work(*arguments)
        sys.stdout.flush()
        os._exit(0)
    if os.waitpid(child, 0)[1]:
        sys.exit(str(arguments))

def load(folder):
    sys.path.insert(0, folder)
    import app
    print(json.dumps([folder, callable(app.handler), sorted(sys.modules), sorted(sys.path)]))

def load_group(layers, shared, folders):
    sys.path[1:1] = layers
    for name in shared:
        importlib.import_module(name)
    for folder in folders:
        fork(load, folder)

sys.path.insert(0, {layer!r})
for name in {shared}:
    importlib.import_module(name)
for group in {groups}:
    fork(load_group, *group)
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


@dataclass(frozen=True)
class Imported:
    """State that an import left: all modules that are loaded after it, and the path."""

    callable: bool
    modules: frozenset[str]
    path: tuple[str, ...]

    @property
    def foreign(self) -> set[str]:
        """The packages that are not Python's own."""
        own = sys.stdlib_module_names | {"app", "__main__"}
        names = {m.partition(".")[0] for m in self.modules} - own
        return {name for name in names if not name.startswith("_sysconfigdata")}


@functools.cache
def deployed() -> dict[str, tuple[str, ...]]:
    """Each function's folder, and the layers that the template gives it."""
    document = complete_template()
    resources, common = document["Resources"], document["Globals"]["Function"]["Layers"]
    return {
        Path(r["Properties"]["CodeUri"]).name: tuple(
            Path(resources[layer["Ref"]]["Properties"]["ContentUri"]).name
            for layer in [*common, *r["Properties"].get("Layers", [])]
        )
        for r in resources.values()
        if r["Type"] == "AWS::Serverless::Function"
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
    """A folder of links for each layer."""
    folder = tmp_path_factory.mktemp("layers")
    places = {layer: folder / layer for layer in ("service", "solver")}
    for layer, place in places.items():
        place.mkdir()
        for there in set(contents(layer)):
            (place / there.name).symlink_to(there)
    return places


def run(script: str) -> list[Any]:
    """Run a script by an interpreter without site-packages; return what its lines of JSON say."""
    command = [sys.executable, "-I", "-S", *COMPILED, "-c", script]
    done = subprocess.run(command, capture_output=True, check=False, text=True)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.fixture(scope="module")
def all_imported(layers: dict[str, Path]) -> dict[str, Imported]:
    alike: dict[tuple[tuple[str, ...], bool], list[str]] = {}
    for function, needed in deployed().items():
        assert needed[0] == "service"
        alike.setdefault((needed[1:], function in ELSEWHERE), []).append(str(ROOT / "functions" / function))
    groups = [
        ([str(layers[layer]) for layer in others], SHARED_COMPUTED if computing else (), folders)
        for (others, computing), folders in alike.items()
    ]
    lines = run(FORKING.format(layer=str(layers["service"]), shared=SHARED, groups=groups))
    return {
        Path(folder).name: Imported(is_callable, frozenset(modules), tuple(path))
        for folder, is_callable, modules, path in lines
    }


def test_every_handler_loads_with_its_own_layers_alone(all_imported: dict[str, Imported]) -> None:
    assert len(all_imported) == len(list(ROOT.glob("functions/*/app.py")))
    for function, found in all_imported.items():
        assert found.callable, function
        assert not [p for p in found.path if "site-packages" in p or p == str(ROOT)], function


def test_handlers_import_only_used_libraries(all_imported: dict[str, Imported]) -> None:
    for function, found in all_imported.items():
        assert found.foreign <= (COMPUTED if function in ELSEWHERE else SERVED), function
        unused = [m for m in found.modules if m in UNUSED or m.startswith(tuple(f"{u}." for u in UNUSED))]
        assert unused == [], function


def test_solver_functions_import_only_their_packages(all_imported: dict[str, Imported]) -> None:
    for function, without in ELSEWHERE.items():
        found = all_imported[function]
        assert {"numpy", "calibsolver"} <= found.foreign, function
        parts = [m.removeprefix("calibsolver.") for m in found.modules if m.startswith("calibsolver.")]
        assert [m for m in parts if m.startswith(without)] == [], function
