"""Changelog in the form of keepachangelog.com."""

import re

_UNRELEASED = "## Unreleased\n"
_SECTION = re.compile(r"^## (?P<version>\d+\.\d+\.\d+) - (?P<day>\d{4}-\d\d-\d\d)\n", re.MULTILINE)


class ChangelogError(ValueError):
    """The changelog lacks what a release needs."""


def notes(changelog: str, version: str) -> str:
    """Extract the entries of a version; raises ChangelogError if there are none."""
    for match in _SECTION.finditer(changelog):
        if match["version"] == version:
            text = re.split(r"^## ", changelog[match.end() :], maxsplit=1, flags=re.MULTILINE)[0].strip()
            if text:
                return text + "\n"
    raise ChangelogError(f"CHANGELOG.md has no entries under `## {version} - YYYY-MM-DD`")


def is_released(changelog: str, version: str) -> bool:
    """True if this is the version as released: it has entries, and nothing has changed since."""
    unreleased = re.split(r"^## ", changelog.partition(_UNRELEASED)[2], maxsplit=1, flags=re.MULTILINE)[0]
    return not unreleased.strip() and any(
        match["version"] == version for match in _SECTION.finditer(changelog)
    )


def with_release(changelog: str, version: str, day: str) -> str:
    """Move the unreleased entries under the version; raises ChangelogError if there are none."""
    if any(match["version"] == version for match in _SECTION.finditer(changelog)):
        raise ChangelogError(f"CHANGELOG.md has {version} already")
    before, heading, after = changelog.partition(_UNRELEASED)
    entries = re.split(r"^## ", after, maxsplit=1, flags=re.MULTILINE)[0].strip()
    if not heading or not entries:
        raise ChangelogError("CHANGELOG.md has no entries under `## Unreleased`")
    return f"{before}{_UNRELEASED}\n## {version} - {day}\n{after}"
