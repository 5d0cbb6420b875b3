"""Wheels: the solver's, the client's, and the server's, which has the built site inside."""

import os
import shutil
import tempfile
import tomllib
from pathlib import Path

from flit_core.wheel import make_wheel_in  # type: ignore[import-untyped]

from infra.release.checkout import ROOT, git, version
from infra.web_build import site
from infra.web_build.site_headers import compress

PROJECTS = (ROOT / "clients" / "python", ROOT / "layers" / "solver")
_FOLDERS = ("functions", "infra/ops", "infra/server", "infra/web_build")
_FILES = ("infra/console.py", "infra/release/__init__.py", "infra/release/changelog.py")
_GROUPS = ("service", "solver", "server", "ops")
_NOT_NEEDED = ("boto", "jinja2", "mangum", "markdown-it-py", "pygments")  # on AWS, and to build the site
_PROJECT = """
[build-system]
requires = ["flit_core>=3.12,<4"]
build-backend = "flit_core.buildapi"

[project]
name = "calibdb-server"
dynamic = ["version", "description"]
license = "Apache-2.0"
license-files = ["LICENSE"]
requires-python = "{python}"
dependencies = {dependencies}

[project.scripts]
calibdb-server = "calibdb_server:serve"
calibdb-ops = "calibdb_server:operate"
"""


def build(target: Path) -> list[Path]:
    """Build all wheels into a folder; return their paths. Raises SiteError if the site cannot be built."""
    # flit gives all files of a wheel this time: the same commit makes the same bytes.
    os.environ.setdefault("SOURCE_DATE_EPOCH", git("log", "-1", "--format=%ct").strip())
    built = [make_wheel_in(project / "pyproject.toml", target).file for project in PROJECTS]
    return [*built, build_server(target)]


def build_server(target: Path) -> Path:
    """Build the server's wheel into a folder; return its path."""
    with tempfile.TemporaryDirectory() as place:
        package = Path(place, "calibdb_server")
        library = package / "library"
        ignored = shutil.ignore_patterns("__pycache__", "*.mjs", "examples.json", "node_modules")
        for folder in _FOLDERS:
            shutil.copytree(ROOT / folder, library / folder, ignore=ignored)
        for name in ("service/calibdb", "solver/calibsolver"):
            shutil.copytree(ROOT / "layers" / name, library / Path(name).name, ignore=ignored)
        for name in _FILES:
            (library / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, library / name)
        unserved = shutil.ignore_patterns("node_modules", *site.SOURCE_FOLDERS)
        shutil.copytree(site.WEB, library / "web", ignore=unserved)
        site.build_for_wheel(library / site.MADE_FILES.name)
        _precompress(library / "web", library / site.MADE_FILES.name)
        program = (ROOT / "infra" / "release" / "server_program.py").read_text(encoding="utf-8")
        stamped = f'{program}\n__version__ = "{version()}"\n'
        (package / "__init__.py").write_text(stamped, encoding="utf-8")
        shutil.copy2(ROOT / "LICENSE", place)
        project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
        listed = {each for group in _GROUPS for each in project["dependency-groups"][group]}
        described = _PROJECT.format(
            python=project["project"]["requires-python"],
            dependencies=sorted(each for each in listed if not each.startswith(_NOT_NEEDED)),
        )
        Path(place, "pyproject.toml").write_text(described, encoding="utf-8")
        built: Path = make_wheel_in(Path(place, "pyproject.toml"), target).file
    return built


def _precompress(*folders: Path) -> None:
    """Write `NAME.gz` next to each file that is served compressed; pages get their origin on the server."""
    files = [path for folder in folders for path in folder.rglob("*") if path.is_file()]
    for path in [path for path in files if path.suffix != ".html"]:
        compressed = compress(path.name, path.read_bytes(), level=9)
        if compressed is not None:
            path.with_name(f"{path.name}.gz").write_bytes(compressed)
