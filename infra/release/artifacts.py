"""Artifacts of a release: source, SDK, layers, wheels, notes, checksums."""

import hashlib
import os
import shutil
import subprocess
import zipfile
from pathlib import Path

from infra.console import announce
from infra.release import changelog, wheels
from infra.release.checkout import ROOT, version
from infra.web_build.sdk import sdk_package
from infra.web_build.site import WEB

RELEASE = ROOT / ".build" / "release"
_EPOCH = (1980, 1, 1, 0, 0, 0)  # of every entry, so that equal layers make equal archives


def build() -> list[Path]:
    """Build every artifact of the checkout, whose cleanness the caller has checked; return their paths.

    Raises CalledProcessError if a command fails.
    """
    shutil.rmtree(RELEASE, ignore_errors=True)
    RELEASE.mkdir(parents=True)
    name = f"calibdb-{version()}"
    parts = {
        "archive the source": lambda: _source(name),
        "pack the SDK": lambda: (RELEASE / f"{name}.tgz").write_bytes(sdk_package(WEB, version())),
        "build the layers": lambda: _layers(name),
        "build the wheels": lambda: wheels.build(RELEASE),
        "write notes and checksums": _summaries,
    }
    for _, part in announce("release", list(parts.items()), lambda step: step[0]):
        part()
    return sorted(RELEASE.iterdir())


def _source(name: str) -> None:
    archive = RELEASE / f"{name}-source.tar.gz"
    _run("git", "archive", "--format=tar.gz", f"--prefix={name}/", f"--output={archive}", "HEAD")


def _layers(name: str) -> None:
    _run("make", "--silent", "layers")
    for layer in ("service", "solver"):
        folder = ROOT / ".build" / "layers" / layer
        with zipfile.ZipFile(
            RELEASE / f"{name}-{layer}-layer-arm64.zip", "w", zipfile.ZIP_DEFLATED
        ) as archive:
            for path in sorted(folder.rglob("*")):
                if path.is_file():
                    entry = zipfile.ZipInfo(path.relative_to(folder).as_posix(), _EPOCH)
                    entry.compress_type = zipfile.ZIP_DEFLATED
                    entry.external_attr = (0o755 if os.access(path, os.X_OK) else 0o644) << 16
                    archive.writestr(entry, path.read_bytes())


def _summaries() -> None:
    text = changelog.notes((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), version())
    sums = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n"
        for path in sorted(RELEASE.iterdir())
    ]
    (RELEASE / "NOTES.md").write_text(text, encoding="utf-8")
    (RELEASE / "SHA256SUMS").write_text("".join(sums), encoding="utf-8")


def _run(*command: str) -> None:
    subprocess.run(command, cwd=ROOT, check=True)
