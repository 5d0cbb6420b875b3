"""Naming rules: first lines of docstrings, constants with one meaning, and the terms of the field."""

import ast
import importlib
import re
import subprocess
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
#: opening words that leave out the noun that a docstring describes
RIDDLE = re.compile(
    r"(What|Who|Whose|Whom|Where|Which|How|Why|Whoever|Whatever|From|In which|Asking)\b"
    r"|(Returns?|Says?|Gives?) (what|who|which|how|where)\b"
)
CONSTANT = re.compile(r"_?[A-Z][A-Z0-9]*(_[A-Z0-9]+)*")
JS_CONSTANT = re.compile(
    r"^(?:export )?const ([A-Z][A-Z0-9]*(?:_[A-Z0-9]+)*) = (.*?);[ \t]*(?://[^\n]*)?$", re.M | re.S
)
SOLVER, SERVICE = "layers/solver/calibsolver", "layers/service/calibdb"
CLIENT = "clients/python/calibdb_client"

#: terms of the literature and of AWS, and the module that implements each
TERMS = {
    "Schur complement": f"{SOLVER}/fitting/normal_equations.py",
    "Fisher information": f"{SOLVER}/fitting/normal_equations.py",
    "inlier": f"{SOLVER}/fitting/outliers.py",
    "geodesic acceleration": f"{SOLVER}/fitting/levenberg_marquardt.py",
    "gain ratio": f"{SOLVER}/fitting/levenberg_marquardt.py",
    "iteratively reweighted": f"{SOLVER}/fitting/levenberg_marquardt.py",
    "LMedS": f"{SOLVER}/fitting/robust_homography.py",
    "resection": f"{SOLVER}/fitting/resection.py",
    "homography": f"{SOLVER}/fitting/robust_homography.py",
    "Kabsch": f"{SOLVER}/consensus/agreement.py",
    "cross-validation": f"{SOLVER}/quality/cross_validation.py",
    "Kronecker sequence": f"{SOLVER}/guidance/candidates.py",
    "idempotent": "functions/submit/app.py",
    "optimistic concurrency": f"{SERVICE}/store/sessions.py",
    "single-flight": f"{SERVICE}/store/leases.py",
    "TTL cache": f"{SERVICE}/access/token_cache.py",
    "dead-letter queue": "template.yaml",
    "content negotiation": f"{SERVICE}/http/content_negotiation.py",
}


def tracked(*patterns: str) -> list[Path]:
    names = subprocess.run(
        ["git", "ls-files", *patterns], cwd=ROOT, capture_output=True, check=True, text=True
    )
    return [ROOT / name for name in names.stdout.splitlines() if (ROOT / name).exists()]


def docstrings(path: Path) -> Iterator[tuple[int, str]]:
    """Line and first line of a module's docstring, and of its public classes', functions' and methods'."""
    tree = ast.parse(path.read_text())
    nodes: list[ast.AST] = [tree]
    while nodes:
        node = nodes.pop()
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            text = ast.get_docstring(node)
            if text:
                yield getattr(node, "lineno", 1), text.splitlines()[0]
        if isinstance(node, (ast.Module, ast.ClassDef)):
            nodes += [n for n in node.body if not getattr(n, "name", "").startswith("_")]


def comments(path: Path) -> Iterator[tuple[int, str]]:
    """Line and first line of a JavaScript module's first comment, and of each JSDoc block."""
    text = path.read_text()
    if first := re.match(r"\s*(?://|/\*+)\s*\**\s*([^\n]*)", text):
        yield 1, first[1]
    for block in re.finditer(r"/\*\*\s*\**\s*([^\n]*)", text):
        yield text.count("\n", 0, block.start()) + 1, block[1]


def riddles(paths: list[Path], lines: Any) -> list[str]:
    return [
        f"{path.relative_to(ROOT)}:{line}: {text}"
        for path in paths
        for line, text in lines(path)
        if RIDDLE.match(text)
    ]


@pytest.mark.parametrize("folder", ["layers", "clients", "functions", "infra", "tests"])
def test_python_docstrings_open_with_the_noun_or_verb(folder: str) -> None:
    assert riddles(tracked(f"{folder}/**.py"), docstrings) == []


def test_javascript_comments_open_with_the_noun_or_verb() -> None:
    assert riddles(tracked("web/**.js", "tests/web/**.mjs", "infra/**.mjs"), comments) == []


def python_constants(path: Path) -> Iterator[tuple[str, str]]:
    for node in ast.parse(path.read_text()).body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) and node.value else targets
        for target in targets:
            if isinstance(target, ast.Name) and CONSTANT.fullmatch(target.id):
                yield target.id, ast.unparse(node.value)


def evaluated(path: Path, name: str, source: str) -> str:
    """Value of a constant, by its source where the module cannot be imported under a name."""
    for base in ("layers/solver", "layers/service", "clients/python", "."):
        below = ROOT / base
        if path.is_relative_to(below):
            parts = path.relative_to(below).with_suffix("").parts
            if parts[0] == "functions":
                return source
            module = ".".join(parts).removesuffix(".__init__")
            return repr(getattr(importlib.import_module(module), name))
    return source


@pytest.mark.parametrize("package", [SOLVER, SERVICE, CLIENT, "functions", "infra"])
def test_python_constants_have_one_meaning_in_a_package(package: str) -> None:
    places: dict[str, dict[Path, str]] = defaultdict(dict)
    for path in tracked(f"{package}/**.py", f"{package}/*.py"):
        for name, source in python_constants(path):
            places[name][path] = source
    wrong = {}
    for name, sources in places.items():
        if len(set(sources.values())) > 1:
            values = {path: evaluated(path, name, source) for path, source in sources.items()}
            if len(set(values.values())) > 1:
                wrong[name] = {str(path.relative_to(ROOT)): source for path, source in sources.items()}
    assert wrong == {}


def test_javascript_constants_have_one_meaning_in_a_folder() -> None:
    places: dict[tuple[str, str], dict[str, str]] = defaultdict(dict)
    for path in tracked("web/**.js"):
        for name, source in JS_CONSTANT.findall(path.read_text()):
            folder = str(path.parent.relative_to(ROOT))
            places[folder, name][path.name] = " ".join(source.split())
    wrong = {
        " ".join(where): {path: source[:100] for path, source in sources.items()}
        for where, sources in places.items()
        if len(set(sources.values())) > 1
    }
    assert wrong == {}


@pytest.mark.parametrize("term", TERMS)
def test_term_of_the_field_is_found_in_its_module(term: str) -> None:
    text = re.sub(r"\s+(#|//)?\s*", " ", (ROOT / TERMS[term]).read_text())
    assert term.lower() in text.lower(), f"{TERMS[term]} implements {term}"
