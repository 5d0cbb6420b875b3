"""Structure of the repository: imports of layers, lengths of modules, contents of lock files."""

import ast
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

#: what computes with the solver for the service
COMPUTE = ROOT / "layers/service/calibdb/compute"
#: packages that a folder must not import
FORBIDDEN = {
    "layers/service/calibdb": {"calibsolver", "functions", "infra", "tests", "numpy", "cv2", "moto"},
    "layers/solver/calibsolver": {
        *("calibdb", "functions", "infra", "tests", "boto3", "botocore", "pydantic", "starlette", "time"),
        *("datetime", "requests", "httpx"),
    },
    "clients/python/calibdb_client": {
        *("calibdb", "functions", "infra", "tests", "boto3", "botocore", "pydantic", "starlette", "typer"),
    },
    "functions": {"infra", "tests", "moto", "boto3", "botocore", "calibsolver", "numpy", "cv2"},
    "infra": {"tests"},
}


def imported(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found.add(node.module.split(".")[0])
    return found


def tracked(*patterns: str) -> list[Path]:
    names = subprocess.run(
        ["git", "ls-files", *patterns], cwd=ROOT, capture_output=True, check=True, text=True
    )
    return [ROOT / name for name in names.stdout.splitlines()]


@pytest.mark.parametrize("folder", FORBIDDEN)
def test_layers_do_not_import_upwards(folder: str) -> None:
    modules = [m for m in (ROOT / folder).rglob("*.py") if not m.is_relative_to(COMPUTE)]
    assert modules
    wrong = {str(m.relative_to(ROOT)): imported(m) & FORBIDDEN[folder] for m in modules}
    assert {module: names for module, names in wrong.items() if names} == {}


def test_boto3_lives_in_the_store_alone() -> None:
    service = ROOT / "layers/service/calibdb"
    users = {
        str(module.relative_to(service)).split("/")[0].removesuffix(".py")
        for module in service.rglob("*.py")
        if imported(module) & {"boto3", "botocore"}
    }
    assert users == {"store"}


def test_template_has_fewer_than_900_lines() -> None:
    """Resources that are added go into files of their own, the `FRAGMENTS` of `infra/deploy/package.py`."""
    assert len((ROOT / "template.yaml").read_text().splitlines()) < 900


def test_locks_carry_versions_and_hashes_only() -> None:
    for path in tracked("*.lock", "*package-lock.json", ".npmrc"):
        assert not re.search(r"https?://|--(extra-)?index-url|--find-links", path.read_text()), path


def test_no_path_of_a_machine_in_a_tracked_file() -> None:
    pattern = re.compile(r"(^|[^A-Za-z0-9_.])/(home|root|Users)/")
    for path in tracked():
        if (
            path.suffix in {".png", ".jpg", ".ico", ".woff2", ".wasm", ".webp"}
            or path.name == Path(__file__).name
            or path == ROOT / "infra/web_build/detector/opencv.js"  # emscripten's file system has /home
        ):
            continue
        assert not pattern.search(path.read_text()), path


def folders(below: str) -> set[str]:
    """Names of the folders with tracked files directly below a folder."""
    paths = (path.relative_to(ROOT / below) for path in tracked(below))
    return {path.parts[0] for path in paths if len(path.parts) > 1}


@pytest.mark.parametrize(
    ("below", "mark"),
    [
        ("functions", "| `{}` |"),
        ("layers/solver/calibsolver", "| `{}` |"),
        ("layers/service/calibdb", "`{}`"),
        ("infra", "  {}/ "),
        ("web", "`web/{}`"),
    ],
)
def test_architecture_names_every_package(below: str, mark: str) -> None:
    text = (ROOT / "docs/architecture.md").read_text()
    packages = folders(below) - {"images"}
    assert packages
    assert {name for name in packages if mark.format(name) not in text} == set()
