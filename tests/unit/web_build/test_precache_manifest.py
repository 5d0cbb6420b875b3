"""The list of files that the pages' service worker goes by."""

import hashlib
from pathlib import Path

from infra.web_build.precache_manifest import shell
from infra.web_build.site import made_files


def test_every_file_of_the_pages_is_listed_with_its_hash() -> None:
    found = shell()
    assert {"index.html", "style.css", "calibrate/main.js", "lib/result/view.js"} <= set(found["files"])
    style = hashlib.sha256(made_files()["style.css"]).hexdigest()
    assert found["files"]["style.css"] == style
    assert not any("messages/" in name for name in found["files"]), "pages contain their texts"
    assert set(found["late"]) <= set(found["files"])
    assert not any(
        name.endswith((".d.ts", "config.json", "sw.js", "openapi.json")) for name in found["files"]
    )


def test_the_version_is_that_of_the_contents(tmp_path: Path) -> None:
    page = tmp_path / "index.html"
    page.write_text("one")
    first = shell(tmp_path)
    page.write_text("other")
    second = shell(tmp_path)
    page.write_text("one")
    assert first["version"] != second["version"]
    assert shell(tmp_path) == first
