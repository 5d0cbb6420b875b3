"""Files at the root of the site: for crawlers, and for who finds a vulnerability."""

import hashlib
from datetime import UTC, datetime
from pathlib import Path
from urllib.robotparser import RobotFileParser
from xml.etree import ElementTree

from infra.web_build.root_files import robots_text, security_text, shell, sitemap
from infra.web_build.site import made_files
from infra.web_build.site_headers import media_type

SITE = "https://calibdb.example"


def test_crawlers_find_pages_and_leave_the_api_alone() -> None:
    robots = RobotFileParser()
    robots.parse(robots_text(SITE).decode().splitlines())
    assert robots.site_maps() == [f"{SITE}/sitemap.xml"]
    for path, allowed in (
        ("/", True),
        ("/v1/cameras", False),
        ("/known/a.json", False),
        ("/de/result/?id=1", False),
    ):
        assert robots.can_fetch("any", SITE + path) is allowed, path


def test_sitemap_lists_pages_and_nothing_else() -> None:
    files = ["index.html", "de/data/index.html", "data/index.html", "lib/x.js", "vendor-1/index.html"]
    files += ["result/index.html", "de/result/index.html", "a&b/index.html", "404.html"]
    places = ElementTree.fromstring(sitemap(SITE, files)).findall("{*}url/{*}loc")
    assert [place.text for place in places] == [
        f"{SITE}/",
        f"{SITE}/a&b/",
        f"{SITE}/data/",
        f"{SITE}/de/data/",
    ]


def test_security_text_expires_within_a_year() -> None:
    now = datetime(2026, 11, 22, tzinfo=UTC)
    lines = security_text("mailto:a@b.example", now, SITE).decode().splitlines()
    fields = dict(line.split(": ", 1) for line in lines)
    assert fields["Contact"] == "mailto:a@b.example"
    assert fields["Canonical"] == f"{SITE}/.well-known/security.txt"
    assert 0 < (datetime.fromisoformat(fields["Expires"]) - now).days < 365


def test_every_file_of_the_pages_is_listed_with_its_hash() -> None:
    found = shell()
    assert {"index.html", "style.css", "calibrate/main.js", "lib/result/view.js"} <= set(found["files"])
    style = hashlib.sha256(made_files()["style.css"]).hexdigest()
    assert found["files"]["style.css"] == style
    sources = [name for name in found["files"] if name.startswith(("messages/", "templates/"))]
    assert sources == [], "pages contain their texts"
    assert set(found["late"]) <= set(found["files"])
    assert not any(
        name.endswith((".d.ts", "config.json", "sw.js", "openapi.json")) for name in found["files"]
    )


def test_the_version_is_that_of_the_contents(tmp_path: Path) -> None:
    listed = []
    for text in ("one", "other", "one"):
        (tmp_path / "index.html").write_text(text)
        listed.append(shell(tmp_path))
    assert listed[0]["version"] != listed[1]["version"]
    assert listed[0] == listed[2]


def test_browsers_get_strict_media_types() -> None:
    assert media_type("sdk.mjs") == "text/javascript; charset=utf-8"
    assert media_type("opencv.wasm") == "application/wasm"
    assert media_type("app.webmanifest") == "application/manifest+json"
    assert media_type("font.woff2") == "font/woff2"
