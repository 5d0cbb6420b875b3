"""Changelog in the form of keepachangelog.com."""

import re

_UNRELEASED = "## Unreleased\n"
_SECTION = re.compile(r"^## (?P<version>\d+\.\d+\.\d+) - (?P<day>\d{4}-\d\d-\d\d)\n", re.MULTILINE)


class ChangelogError(ValueError):
    """The changelog lacks what a release needs."""


def notes(changelog: str, version: str) -> str:
    """Extract the entries of a version; raises ChangelogError if there are none."""
    match = _find(changelog, version)
    entries = _entries(changelog[match.end() :]) if match else ""
    if not entries:
        raise ChangelogError(f"CHANGELOG.md has no entries under `## {version} - YYYY-MM-DD`")
    return entries + "\n"


def is_released(changelog: str, version: str) -> bool:
    """True if this is the version as released: it has entries, and nothing has changed since."""
    return not _entries(changelog.partition(_UNRELEASED)[2]) and _find(changelog, version) is not None


def with_release(changelog: str, version: str, day: str) -> str:
    """Move the unreleased entries under the version; raises ChangelogError if there are none."""
    if _find(changelog, version):
        raise ChangelogError(f"CHANGELOG.md has {version} already")
    before, heading, after = changelog.partition(_UNRELEASED)
    if not heading or not _entries(after):
        raise ChangelogError("CHANGELOG.md has no entries under `## Unreleased`")
    return f"{before}{_UNRELEASED}\n## {version} - {day}\n{after}"


def _find(changelog: str, version: str) -> re.Match[str] | None:
    return next((match for match in _SECTION.finditer(changelog) if match["version"] == version), None)


def _entries(text: str) -> str:
    """Return the text up to the next heading."""
    return re.split(r"^## ", text, maxsplit=1, flags=re.MULTILINE)[0].strip()
