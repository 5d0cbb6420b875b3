"""Structure of the repository: contents of lock files, packages in the documents, benchmarks."""

import importlib
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def tracked(*patterns: str) -> list[Path]:
    names = subprocess.run(
        ["git", "ls-files", *patterns], cwd=ROOT, capture_output=True, check=True, text=True
    )
    return [ROOT / name for name in names.stdout.splitlines()]


def test_locks_carry_versions_and_hashes_only() -> None:
    for path in tracked("*.lock", "*package-lock.json", ".npmrc"):
        assert not re.search(r"https?://|--(extra-)?index-url|--find-links", path.read_text()), path


def test_no_path_of_a_machine_in_a_tracked_file() -> None:
    pattern = re.compile(r"(^|[^A-Za-z0-9_.])/(home|root|Users)/")
    for path in tracked():
        if (
            path.suffix in {".png", ".gif", ".jpg", ".ico", ".woff2", ".wasm", ".webp"}
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


def test_benchmarks_and_screenshots_can_be_imported() -> None:
    """Neither pytest nor mypy reads them."""
    files = [*(ROOT / "tests/bench").glob("*.py"), ROOT / "tests/browser/screenshots.py"]
    for name in sorted(f"tests.{path.parent.name}.{path.stem}" for path in files if path.stem[0] != "_"):
        importlib.import_module(name)
