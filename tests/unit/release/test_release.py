"""Releases: one version, a changelog entry, a tag, a clean checkout."""

import json
import re
import subprocess
import tomllib
from pathlib import Path

import pytest

import calibdb
import calibdb_client
import calibsolver
from infra.release import changelog, checkout
from infra.release.changelog import ChangelogError
from infra.release.checkout import VERSION_FILE, WHEEL_FILES, CheckoutError
from infra.web_build import openapi
from tests.helpers.data import ROOT

CHANGELOG = """# Changelog

## Unreleased

### Added

* Something.

## 0.1.0 - 2026-01-02

* The first.
"""


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout of version 0.1.0, clean and tagged."""
    for file in (tmp_path / each for each in (VERSION_FILE, *WHEEL_FILES)):
        file.parent.mkdir(parents=True)
        file.write_text('__version__ = "0.1.0"\nFIT_VERSION = "0.1.0"\n')
    (tmp_path / ".gitignore").write_text(".build/\n")
    for command in (
        ("init", "--quiet"),
        ("add", "--all"),
        ("-c", "user.name=a", "-c", "user.email=a@example.org", "commit", "--quiet", "--message", "Begin"),
        ("tag", "v0.1.0"),
        ("tag", "v0.2.0"),
    ):
        subprocess.run(["git", "-C", tmp_path, *command], check=True, capture_output=True)
    monkeypatch.setattr(checkout, "ROOT", tmp_path)
    return tmp_path


def test_version_stands_in_one_place() -> None:
    assert checkout.version() == calibdb.__version__
    assert calibdb_client.__version__ == calibsolver.__version__ == calibdb.__version__
    assert "version" not in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert "version" not in json.loads((ROOT / "package.json").read_text())
    # The packed SDK is given the release's version.
    assert json.loads((ROOT / "web/sdk/package.json").read_text())["version"] == "0.0.0"
    assert openapi.document()["info"]["version"] == calibdb.__version__


def test_wheels_take_the_version_of_a_release_and_fits_keep_theirs(repository: Path) -> None:
    checkout.set_version("0.2.0")
    for file in (VERSION_FILE, *WHEEL_FILES):
        assert (repository / file).read_text() == '__version__ = "0.2.0"\nFIT_VERSION = "0.1.0"\n'


def test_clean_tagged_checkout_is_released(repository: Path) -> None:
    (repository / ".build").mkdir()
    (repository / ".build" / "anything").touch()
    checkout.check_clean()
    checkout.check_tag("v0.1.0")


@pytest.mark.parametrize("name", ["new.py", str(VERSION_FILE)])
def test_changed_or_new_file_is_no_clean_checkout(name: str, repository: Path) -> None:
    with (repository / name).open("a") as file:
        file.write("# changed\n")
    with pytest.raises(CheckoutError, match=f"differs from its commit: {re.escape(name)}"):
        checkout.check_clean()


def test_tag_must_be_of_the_version_and_of_the_commit(repository: Path) -> None:
    with pytest.raises(CheckoutError, match=r"is not v0\.1\.0"):
        checkout.check_tag("v0.2.0")
    checkout.set_version("0.2.0")
    commit = ("-c", "user.name=a", "-c", "user.email=a@example.org", "commit", "--quiet", "-am", "Go on")
    subprocess.run(["git", "-C", repository, *commit], check=True)
    with pytest.raises(CheckoutError, match=r"v0\.2\.0 is not a tag of the commit"):
        checkout.check_tag("v0.2.0")


@pytest.mark.usefixtures("repository")
@pytest.mark.parametrize("fresh", ["0.1.0", "v1.0.0"])
def test_version_must_be_higher_and_of_three_numbers(fresh: str) -> None:
    with pytest.raises(CheckoutError):
        checkout.set_version(fresh)
    assert checkout.version() == "0.1.0"


def test_unreleased_entries_become_those_of_the_version() -> None:
    fresh = changelog.with_release(CHANGELOG, "0.2.0", "2026-03-04")
    assert changelog.notes(fresh, "0.2.0") == "### Added\n\n* Something.\n"
    assert changelog.notes(fresh, "0.1.0") == "* The first.\n"
    assert "## Unreleased\n\n## 0.2.0 - 2026-03-04\n" in fresh
    for version in ("0.1.0", "0.2.0"):
        with pytest.raises(ChangelogError, match=r"already|no entries"):
            changelog.with_release(fresh, version, "2026-03-05")


def test_release_without_entries_is_refused() -> None:
    with pytest.raises(ChangelogError, match=r"no entries under `## 0\.2\.0"):
        changelog.notes(CHANGELOG, "0.2.0")
    with pytest.raises(ChangelogError, match="no entries under `## Unreleased`"):
        changelog.with_release("# Changelog\n\n## Unreleased\n", "0.2.0", "2026-03-04")
