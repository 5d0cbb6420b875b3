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

    `slug`: folder under `/docs/`. `uses_service`: the page fills the site's address and the visitor's token
    into its code. `path`: in the repository, None if the page is made otherwise.
    """

    slug: str
    name: str
    summary: str
    uses_service: bool = False
    path: str | None = "docs/{slug}.md"

    @property
    def source(self) -> str | None:
        """Path in the repository."""
        return self.path and self.path.format(slug=self.slug)

    @property
    def key(self) -> str:
        """Path of its page in the site."""
        return f"{FOLDER}{self.slug}/index.html"


GROUPS: dict[str, tuple[Entry, ...]] = {
    "start": (
        Entry(
            "quickstart",
            "Quickstart",
            "A running page, in five minutes: token, lookup, and the way to the calibration and back.",
            uses_service=True,
        ),
        Entry(
            "sdk",
            "JavaScript SDK",
            "Lookups, projection matrices, straightened video, adapters for engines.",
            uses_service=True,
            path="web/sdk/README.md",
        ),
        Entry(
            "two-cameras",
            "Two cameras",
            "A stereo pair from its capture to depth in metres, in a page and in other tools.",
            uses_service=True,
        ),
        Entry(
            "python",
            "Python client",
            "Lookups, rectified pictures and other tools’ files in a program or on a robot.",
            uses_service=True,
        ),
        Entry("frc", "FRC teams", "Results in PhotonVision and WPIcal, and held-out errors."),
        Entry(
            "api", "HTTP API", "All calls explained: tokens, lookups, captures, checks.", uses_service=True
        ),
        Entry("reference", "API reference", "Every call and field, with code to copy and to try.", path=None),
        Entry("problems", "Problems", "Every error of the API, and what to do.", path=None),
        Entry("limits", "Limits", "Calls an hour by plan, sizes, times.", uses_service=True),
    ),
    "understand": (
        Entry("concepts", "Concepts", "Camera key, view, session, consensus, reliable."),
        Entry("conventions", "Conventions", "Pixels, frames, distortion models, symbols, terms."),
        Entry("formats", "Formats", "Files of other tools: export and import."),
        Entry("camera-keys", "Camera keys", "Which label finds which camera."),
        Entry("estimates", "Estimates", "Likely field of view of a camera without calibration."),
        Entry("accuracy", "Accuracy and speed", "Every figure, with its command."),
        Entry("webxr", "WebXR", "Intrinsics and distortion for WebXR views."),
        Entry(
            "solver", "Solver", "Calibration in Python, without a service.", path="layers/solver/README.md"
        ),
        Entry(
            "python-package",
            "Python package",
            "The client on one page.",
            uses_service=True,
            path="clients/python/README.md",
        ),
    ),
    "project": (
        Entry("security", "Security", "What is protected, against whom, and what is not."),
        Entry("vulnerabilities", "Vulnerabilities", "How to report one.", path="SECURITY.md"),
        Entry(
            "self-hosting",
            "Self-hosting",
            "The service in one process over one SQLite file: systemd, TLS, backup, upgrade.",
        ),
        Entry("operations", "Operations", "Deploying, watching, restoring the service."),
        Entry("architecture", "Architecture", "Parts, data at rest, flows."),
        Entry("contributing", "Contributing", "Commands, rules, names.", path="CONTRIBUTING.md"),
        Entry("changelog", "Changelog", "What changed in which version.", path="CHANGELOG.md"),
    ),
}
"""Documents by group, in the order of the navigation."""

FOR_CONTRIBUTORS = (
    Entry("development", "Development", "Tests, rules, and how to extend calibDB."),
    Entry("decisions", "Decisions", "What was decided, and why."),
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
