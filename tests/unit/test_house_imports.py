"""Import rules: packages of both layers point one way, and no modules import in a circle."""

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

from infra.ci.import_handlers import functions, sources

ROOT = Path(__file__).parents[2]
SOLVER = ROOT / "layers/solver/calibsolver"
SERVICE = ROOT / "layers/service/calibdb"

#: modules of the solver that belong to no package: the public values, of which these know the models
CAMERA = {"camera", "image_transform", "undistortion"}
#: modules that use a fit
USES = {"circles", "locate", "plots"}
VALUES = {"arrays", "board", "deadline", "errors", "phrasing", "rotation", "view"}
_FITTED = {"values", "models", "camera", "fitting"}
#: what each package of the solver may import, itself aside
SOLVER_ARROWS: dict[str, set[str]] = {
    "values": set(),
    "models": {"values"},
    "camera": {"values", "models"},
    "fitting": {"values", "models", "camera"},
    "uses": _FITTED,
    "quality": _FITTED,
    "guidance": _FITTED,
    "consensus": _FITTED,
    "formats": _FITTED,
    "capture": _FITTED | {"guidance", "quality"},
    "rig": _FITTED | {"guidance", "formats"},
}
_RULED = {"errors", "settings", "camera_key", "schema"}
#: what each package or module of the service may import, itself aside
SERVICE_ARROWS: dict[str, set[str]] = {
    "errors": set(),
    "settings": {"errors"},
    "camera_key": {"errors", "settings"},
    "schema": {"errors", "settings", "camera_key"},
    "access": _RULED,
    "rules": _RULED,
    "proof": _RULED,
    "store": _RULED | {"access", "rules"},
    "estimate": {"camera_key", "schema"},
    "lookup": _RULED | {"access", "rules", "store", "estimate"},
    "dump": _RULED | {"access", "rules", "store", "lookup"},
    "service": _RULED | {"access", "rules", "store", "lookup"},
    "http": _RULED | {"access", "rules", "store", "lookup", "service"},
    "compute": _RULED | {"access", "rules", "store", "lookup", "service"},
}


def modules() -> dict[str, Path]:
    """Every module of the layers, functions and infra by its full name."""
    found = {}
    for base, root in (
        (SERVICE.parent, SERVICE),
        (SOLVER.parent, SOLVER),
        (ROOT, ROOT / "functions"),
        (ROOT, ROOT / "infra"),
    ):
        for path in root.rglob("*.py"):
            name = ".".join(path.relative_to(base).with_suffix("").parts)
            found[name.removesuffix(".__init__")] = path
    return found


MODULES = modules()


def statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements that run when a module is imported, and those under `if TYPE_CHECKING`."""
    for node in body:
        yield node
        if isinstance(node, (ast.If, ast.Try, ast.With)):
            yield from statements(node.body)
            yield from statements(getattr(node, "orelse", []))


def imports(name: str, *, everywhere: bool = False) -> set[str]:
    """Modules of this repository that a module imports at module level, or `everywhere` in it."""
    path = MODULES[name]
    tree = ast.parse(path.read_text())
    nodes = ast.walk(tree) if everywhere else statements(tree.body)
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    found = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            origin = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                inner = f"{origin}.{alias.name}"
                found.add(inner if inner in MODULES else origin)
    return {each for each in found if each in MODULES} - {name}


def cycles() -> list[list[str]]:
    """Groups of modules that import each other (strongly connected components, Tarjan)."""
    graph = {name: imports(name) for name in MODULES}
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    groups: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in graph[node]:
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            at = stack.index(node)
            group = sorted(stack[at:])
            del stack[at:]
            if len(group) > 1:
                groups.append(group)

    for node in graph:
        if node not in index:
            visit(node)
    return groups


def test_python_modules_have_no_import_cycle() -> None:
    assert cycles() == []


def part(name: str, top: str) -> str | None:
    """Package, or module beside the packages, that a module of `top` belongs to; None: the root itself."""
    if name == top:
        return None
    first = name.split(".")[1]
    if top == "calibsolver" and first in VALUES | CAMERA:
        return "values" if first in VALUES else "camera"
    if top == "calibsolver" and first in USES:
        return "uses"
    return first


def violations(top: str, arrows: dict[str, set[str]]) -> list[str]:
    found = []
    for name in sorted(MODULES):
        if name.split(".")[0] != top or (own := part(name, top)) is None:
            continue
        for other in sorted(imports(name, everywhere=True)):
            if other.split(".")[0] == top:
                used = part(other, top)
                if used != own and used not in arrows.get(own, set()):
                    found.append(f"{name} imports {other}")
    return found


def test_solver_packages_import_one_way() -> None:
    assert violations("calibsolver", SOLVER_ARROWS) == []


def test_service_packages_import_one_way() -> None:
    assert violations("calibdb", SERVICE_ARROWS) == []


@pytest.mark.parametrize(
    ("root", "packages", "values"),
    [
        (SOLVER, set(SOLVER_ARROWS) - {"values", "camera", "uses"}, VALUES | CAMERA | USES),
        (SERVICE, set(SERVICE_ARROWS) - {"errors", "settings", "service"}, {"errors", "settings", "service"}),
    ],
    ids=["solver", "service"],
)
def test_layer_has_its_packages_and_values_alone(root: Path, packages: set[str], values: set[str]) -> None:
    assert {path.parent.name for path in root.glob("*/__init__.py")} == packages
    assert {path.stem for path in root.glob("*.py")} - {"__init__"} == values


def test_functions_without_the_solver_compute_nothing() -> None:
    without = [folder for folder, solver in functions(sources(ROOT)) if not solver]
    assert "functions/lookup" in without
    for folder in without:
        used = imports(f"{folder.replace('/', '.')}.app", everywhere=True)
        assert not [name for name in used if name.startswith("calibdb.compute")], folder


def test_benchmarks_and_scripts_beside_the_tests_can_be_imported() -> None:
    """Neither pytest nor mypy looks at them, and nobody runs them often."""
    files = [*(ROOT / "tests/bench").glob("*.py"), ROOT / "tests/browser/screenshots.py"]
    for name in sorted(f"tests.{path.parent.name}.{path.stem}" for path in files if path.stem[0] != "_"):
        importlib.import_module(name)
