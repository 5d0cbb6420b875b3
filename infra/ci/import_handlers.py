"""Import of every handler from only the built layers, on Lambda's processor and Python.

`python3.13 infra/ci/import_handlers.py FOLDER` needs only the standard library and `.build/layers` in FOLDER,
so that it runs in Lambda's own image.
"""

import platform
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

_FUNCTION_BLOCK = re.compile(
    r"^  \w+:\n    Type: AWS::Serverless::Function\n(?:(?:    .*)?\n)+", re.MULTILINE
)
_PROGRAM = "import sys; sys.path[:0] = {paths!r}; import app; assert callable(app.handler)"


def functions(template: str) -> Iterator[tuple[str, bool]]:
    """Yield the folder of each function of a template, and whether it has the solver's layer."""
    for block in _FUNCTION_BLOCK.findall(template):
        if folder := re.search(r"CodeUri: (functions/\w+)/", block):
            yield folder[1], "SolverLayer" in block


def sources(root: Path) -> str:
    """Return the template of a checkout with the files that the packaged one includes."""
    paths = (root / "template.yaml", *sorted((root / "infra").glob("*/*.yaml")))
    return "\n".join(path.read_text(encoding="utf-8") for path in paths)


def _problem(root: Path, folder: str, *, solver: bool) -> str | None:
    """Import one handler in a process of its own; return what went wrong.

    Only the function's folder, its layers and the standard library are on the path.
    """
    layers = ["service", "solver"] if solver else ["service"]
    paths = [str(root / folder), *(str(root / ".build" / "layers" / name / "python") for name in layers)]
    command = [sys.executable, "-I", "-S", "-B", "-c", _PROGRAM.format(paths=paths)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stderr.strip().rpartition("\n")[2] if done.returncode else None


def main(root: Path) -> int:
    """Import all handlers; return 1 if one cannot be imported, or if there is none."""
    handlers = list(functions(sources(root)))
    print(f"{platform.machine()}, Python {platform.python_version()}: {len(handlers)} handlers")
    failed = 0
    for folder, solver in handlers:
        what = _problem(root, folder, solver=solver)
        failed += what is not None
        print(f"{folder}: {what or 'imported'}")
    return 1 if failed or not handlers else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
