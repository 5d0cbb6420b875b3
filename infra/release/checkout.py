"""The checkout that a release or a deployment is made of."""

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
#: the one place of the version; the OpenAPI document and the packed SDK follow it
VERSION_FILE = Path("layers/service/calibdb/__init__.py")
#: modules whose wheels also carry it; a wheel is built only of its own folder
WHEEL_FILES = (
    Path("clients/python/calibdb_client/__init__.py"),
    Path("layers/solver/calibsolver/__init__.py"),
)
_VERSION = re.compile(r'^__version__ = "(\d+\.\d+\.\d+)"$', re.MULTILINE)
_MAX_NAMED = 5  # files that a message names


class CheckoutError(ValueError):
    """The checkout is not one to release or deploy."""


def version() -> str:
    """Read the version of the checkout."""
    match = _VERSION.search((ROOT / VERSION_FILE).read_text(encoding="utf-8"))
    if match is None:
        raise CheckoutError(f"{VERSION_FILE} contains no version such as 1.2.3")
    return match[1]


def set_version(fresh: str) -> None:
    """Write another version; raises CheckoutError if it is not higher than the present one."""
    if not re.fullmatch(r"\d+\.\d+\.\d+", fresh):
        raise CheckoutError(f"{fresh} is not a version such as 1.2.3")
    if _parts(fresh) <= _parts(version()):
        raise CheckoutError(f"{fresh} is not higher than {version()}")
    for path in (ROOT / file for file in (VERSION_FILE, *WHEEL_FILES)):
        path.write_text(_VERSION.sub(f'__version__ = "{fresh}"', path.read_text(encoding="utf-8")), "utf-8")


def check_clean() -> None:
    """Raise CheckoutError if a file that git does not ignore differs from the commit, or is not in it."""
    changed = git("status", "--porcelain", "--untracked-files=all").splitlines()
    if changed:
        names = ", ".join(line[3:] for line in changed[:_MAX_NAMED])
        more = f" and {len(changed) - _MAX_NAMED} more" if len(changed) > _MAX_NAMED else ""
        raise CheckoutError(f"the checkout differs from its commit: {names}{more}; commit or stash it")


def check_tag(tag: str) -> None:
    """Raise CheckoutError if the tag is not of this version or not on this commit."""
    if tag != f"v{version()}":
        raise CheckoutError(f"the tag {tag} is not v{version()}, the version in {VERSION_FILE}")
    if tag not in git("tag", "--points-at", "HEAD").split():
        raise CheckoutError(f"{tag} is not a tag of the commit that is checked out")


def _parts(text: str) -> tuple[int, ...]:
    return tuple(map(int, text.split(".")))


def git(*arguments: str) -> str:
    """Run git in the checkout and return its output; raises CheckoutError if it fails."""
    done = subprocess.run(
        ["git", "-C", str(ROOT), *arguments],  # noqa: S607
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise CheckoutError(f"git {' '.join(arguments)} failed: {done.stderr.strip()}")
    return done.stdout
