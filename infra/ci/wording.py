"""Check the words of documents and sources, the first words of docstrings, and the subjects of commits.

python -m infra.ci.wording
"""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MAX_SUBJECT = 72  # characters
MAX_CELL = 200  # characters of a table cell
MAX_FINDINGS = 3  # per document
BASE = "origin/main"
SOURCES = ("*.py", "web/*.js", "web/*.css", "tests/web/*.mjs", "infra/*.js", "infra/*.mjs")

DISCOURAGED = re.compile(
    r"\b(?:nobody|somebody|anybody|everybody|whoever|anew|told|tells|alone|holds|beside|mend(?:s|ed)?|liars?|honest"
    r"|strangers?|(?<!there )(?:is|are) no|by (?:itself|themselves)|go(?:es)? on|in words|the very|former)\b"
    r"|, too(?=[.;:,)])",
    re.IGNORECASE,
)
"""Words of literal translations; docs/development.md says how to write instead."""
_NOT_PROSE = re.compile(r"^ *```.*?^ *```|<!--.*?-->|`[^`\n]*`|\]\([^)]*\)", re.DOTALL | re.MULTILINE)

RIDDLE = re.compile(
    r"(What|Who|Whether|Whose|Whom|Where|Which|How|Why|Whoever|Whatever|From|In which|Asking)\b"
    r"|(Returns?|Says?|Gives?) (what|who|which|how|where)\b"
)
"""Opening words that leave out the noun that a docstring describes."""
ACTORLESS = re.compile(r"\b(?:nobody|somebody|anybody|everybody|whoever|anew|told)\b", re.IGNORECASE)
"""Words that no source outside tests may contain, in comments or in names."""
_THIS_FILE = Path(__file__).resolve().relative_to(ROOT).as_posix()
_FIRST_COMMENT = re.compile(r"\s*(?://|/\*+)\s*\**\s*([^\n]*)")
_JSDOC = re.compile(r"/\*\*\s*\**\s*([^\n]*)")


def findings(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of discouraged words outside code, and of table cells that are too long."""
    plain = _NOT_PROSE.sub(lambda match: "\n" * match[0].count("\n") or "-", text)
    for number, line in enumerate(plain.splitlines(), 1):
        for match in DISCOURAGED.finditer(line):
            yield number, match[0].strip(", ")
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("|"):
            for cell in re.split(r"(?<!\\)\|", line):
                if len(cell.strip()) > MAX_CELL:
                    yield number, f"cell of {len(cell.strip())} characters"


def document_problems(path: str, text: str) -> list[str]:
    """Describe the findings of a document that has more than it may have."""
    hits = list(findings(text))
    if len(hits) <= MAX_FINDINGS:
        return []
    where = "".join(f"\n  {path}:{number}: {words}" for number, words in hits)
    return [f"{path}: {len(hits)} discouraged words or long cells, at most {MAX_FINDINGS} allowed{where}"]


def docstrings(tree: ast.Module) -> Iterator[str]:
    """Yield the docstrings of a module and of its public classes, functions and methods."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    for node in ast.walk(tree):
        if isinstance(node, documented) and not getattr(node, "name", "").startswith("_"):
            yield ast.get_docstring(node) or ""


def opening_problems(path: str, text: str) -> list[str]:
    """Describe docstrings, or comments of JavaScript, whose first words leave out the noun."""
    if path.endswith(".py"):
        openings = list(docstrings(ast.parse(text)))
    else:
        first = _FIRST_COMMENT.match(text)
        openings = [*([first[1]] if first else []), *_JSDOC.findall(text)]
    return [f"{path}: {each.splitlines()[0]!r} names no noun" for each in openings if RIDDLE.match(each)]


def actor_problems(path: str, text: str) -> list[str]:
    """Describe words without an actor in a source."""
    hits = [
        (number, word) for number, line in enumerate(text.splitlines(), 1) for word in ACTORLESS.findall(line)
    ]
    return [f"{path}:{number}: {word!r} names no actor" for number, word in hits]


def subject_problems(subject: str) -> list[str]:
    """Describe what is wrong with the subject of a commit."""
    wrong = []
    if len(subject) > MAX_SUBJECT:
        wrong.append(f"{len(subject)} characters, at most {MAX_SUBJECT}")
    if subject.endswith("."):
        wrong.append("ends with a full stop")
    if not subject[:1].isupper():
        wrong.append("does not start with a capital letter")
    return [f"commit {subject!r}: {each}" for each in wrong]


def git_lines(*arguments: str) -> Sequence[str]:
    """Lines of git's output; none if it fails, for example because there is no such ref."""
    command = ["git", "-C", str(ROOT), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.splitlines()


def main() -> int:
    """Print all problems; 1 if there are any."""
    problems = []
    for path in git_lines("ls-files", "*.md"):
        problems += document_problems(path, (ROOT / path).read_text(encoding="utf-8"))
    for path in git_lines("ls-files", *SOURCES):
        text = (ROOT / path).read_text(encoding="utf-8")
        problems += opening_problems(path, text)
        if not path.startswith("tests/") and path != _THIS_FILE:
            problems += actor_problems(path, text)
    for subject in git_lines("log", "--no-merges", "--format=%s", f"{BASE}..HEAD"):
        problems += subject_problems(subject)
    print("\n".join(problems) or "wording: no problems")
    return min(1, len(problems))


if __name__ == "__main__":
    sys.exit(main())
