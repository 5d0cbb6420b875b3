"""Commands for a release: `make release ARGS="bump 0.2.0"`, then commit, tag, `ARGS="build --tag v0.2.0"`."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

from infra.release import artifacts, changelog, checkout
from infra.release.changelog import ChangelogError
from infra.release.checkout import ROOT, CheckoutError

application = typer.Typer(
    help="Release calibDB.", no_args_is_help=True, pretty_exceptions_enable=False, add_completion=False
)
Tag = Annotated[str, typer.Option(help="Tag of the release, v1.2.3.")]


@application.command("bump")
def bump(version: Annotated[str, typer.Argument(help="Next version, 1.2.3.")]) -> None:
    """Set the version, and move the unreleased changelog entries under it."""
    with _failures():
        path = ROOT / "CHANGELOG.md"
        day = time.strftime("%Y-%m-%d", time.gmtime())
        text = changelog.with_release(path.read_text(encoding="utf-8"), version, day)
        checkout.set_version(version)
        path.write_text(text, encoding="utf-8")
        print(f"now: git commit --all --message 'Release {version}' && git tag v{version} && git push --tags")


@application.command("check")
def check(tag: Tag) -> None:
    """Check that the checkout is clean and is the tag's, and that the changelog has its entries."""
    with _failures():
        _check(tag)


@application.command("build")
def build(tag: Tag) -> None:
    """Check, and write the artifacts to .build/release."""
    with _failures():
        _check(tag)
        for path in artifacts.build():
            print(f"{path.stat().st_size:12,}  {path.relative_to(ROOT)}")


def _check(tag: str) -> None:
    checkout.check_clean()
    checkout.check_tag(tag)
    changelog.notes((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), checkout.version())


@contextmanager
def _failures() -> Iterator[None]:
    try:
        yield
    except (ChangelogError, CheckoutError, OSError, subprocess.CalledProcessError) as error:
        print(f"calibDB: {error}", file=sys.stderr)
        raise typer.Exit(1) from error


if __name__ == "__main__":
    application()
