"""Documents that the site shows under `/docs/`, and where each lies."""

import posixpath
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

ROOT = Path(__file__).resolve().parents[3]
FOLDER = "docs/"


@dataclass(frozen=True)
class Entry:
    """One document.

    `source`: path in the repository, None if the page is made otherwise. `slug`: folder under `/docs/`.
    `uses_service`: the page fills the site's address and the visitor's token into its code.
    """

    source: str | None
    slug: str
    name: str
    summary: str
    uses_service: bool = False

    @property
    def key(self) -> str:
        """Path of its page in the site."""
        return f"{FOLDER}{self.slug}/index.html"


GROUPS: dict[str, tuple[Entry, ...]] = {
    "start": (
        Entry(
            "docs/quickstart.md",
            "quickstart",
            "Quickstart",
            "A running page, in five minutes: token, lookup, and the way to the calibration and back.",
            uses_service=True,
        ),
        Entry(
            "web/sdk/README.md",
            "sdk",
            "JavaScript SDK",
            "Lookups, projection matrices, straightened video, adapters for engines.",
            uses_service=True,
        ),
        Entry(
            "docs/two-cameras.md",
            "two-cameras",
            "Two cameras",
            "A stereo pair from its capture to depth in metres, in a page and in other tools.",
            uses_service=True,
        ),
        Entry(
            "docs/python.md",
            "python",
            "Python client",
            "Lookups, rectified pictures and other tools’ files in a program or on a robot.",
            uses_service=True,
        ),
        Entry("docs/frc.md", "frc", "FRC teams", "Results in PhotonVision and WPIcal, and held-out errors."),
        Entry(
            "docs/api.md", "api", "HTTP API", "All calls explained: tokens, lookups, captures, checks.", True
        ),
        Entry(None, "reference", "API reference", "Every call and field, with code to copy and to try."),
        Entry(None, "problems", "Problems", "Every error of the API, and what to do."),
        Entry("docs/limits.md", "limits", "Limits", "Calls an hour by plan, sizes, times.", True),
    ),
    "understand": (
        Entry("docs/concepts.md", "concepts", "Concepts", "Camera key, view, session, consensus, reliable."),
        Entry(
            "docs/conventions.md",
            "conventions",
            "Conventions",
            "Pixels, frames, distortion models, symbols, terms.",
        ),
        Entry("docs/formats.md", "formats", "Formats", "Files of other tools: export and import."),
        Entry("docs/camera-keys.md", "camera-keys", "Camera keys", "Which label finds which camera."),
        Entry(
            "docs/estimates.md",
            "estimates",
            "Estimates",
            "Likely field of view of a camera without calibration.",
        ),
        Entry("docs/accuracy.md", "accuracy", "Accuracy and speed", "Every figure, with its command."),
        Entry("docs/webxr.md", "webxr", "WebXR", "Intrinsics and distortion for WebXR views."),
        Entry(
            "layers/solver/README.md",
            "solver",
            "Solver",
            "Calibration in Python, without a service.",
        ),
        Entry(
            "clients/python/README.md", "python-package", "Python package", "The client on one page.", True
        ),
    ),
    "project": (
        Entry(
            "docs/security.md", "security", "Security", "What is protected, against whom, and what is not."
        ),
        Entry("SECURITY.md", "vulnerabilities", "Vulnerabilities", "How to report one."),
        Entry(
            "docs/self-hosting.md",
            "self-hosting",
            "Self-hosting",
            "The service in one process over one SQLite file: systemd, TLS, backup, upgrade.",
        ),
        Entry(
            "docs/operations.md", "operations", "Operations", "Deploying, watching, restoring the service."
        ),
        Entry("docs/architecture.md", "architecture", "Architecture", "Parts, data at rest, flows."),
        Entry("CONTRIBUTING.md", "contributing", "Contributing", "Commands, rules, names."),
        Entry("CHANGELOG.md", "changelog", "Changelog", "What changed in which version."),
    ),
}
"""Documents by group, in the order of the navigation."""

FOR_CONTRIBUTORS = (
    Entry("docs/development.md", "development", "Development", "Tests, rules, and how to extend calibDB."),
    Entry("docs/decisions.md", "decisions", "Decisions", "What was decided, and why."),
)
"""Documents that the navigation omits; the page *Contributing* links to them."""

ENTRIES = tuple(entry for group in (*GROUPS.values(), FOR_CONTRIBUTORS) for entry in group)
_BY_SOURCE = {entry.source: entry for entry in ENTRIES if entry.source}


def address(from_key: str, to_key: str) -> str:
    """Return the relative address of a page, or another file of the site, on the page `from_key`."""
    folder, name = posixpath.split(to_key)
    there = posixpath.relpath(folder or ".", posixpath.dirname(from_key) or ".")
    return f"{there}/" if name == "index.html" else f"{there}/{name}"


def target_key(source: str, target: str) -> tuple[str, str] | None:
    """Find the target on the site of a link in the document `source`, a path relative to that.

    Returns the key of a file, and the anchor; None if the site does not have it.
    """
    parts = urlsplit(target)
    path = posixpath.normpath(posixpath.join(posixpath.dirname(source), parts.path)) if parts.path else source
    if path in _BY_SOURCE:
        return _BY_SOURCE[path].key, parts.fragment
    if path == "README.md":
        return f"{FOLDER}index.html", ""
    if path.startswith("docs/images/"):
        return path, ""
    if path.startswith("web/") and (ROOT / path).is_dir():
        return f"{path.removeprefix('web/')}/index.html", parts.fragment
    if path.startswith("web/") and (ROOT / path).exists():
        return path.removeprefix("web/"), parts.fragment
    return None
