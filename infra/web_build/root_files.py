"""Files at the root of the site that programs look for: robots.txt, sitemap.xml, security.txt."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import datetime, timedelta
from xml.sax.saxutils import escape

from infra.web_build.site import LANGUAGES

_SECURITY_TEXT_DAYS = 364  # less than the year that the RFC recommends at most
#: answers to programs, and single results of people
_NOT_INDEXED = ("/v1/", "/known/", *(f"{folder}/result/" for folder in ("", *map("/{}".format, LANGUAGES))))


def robots_text(site: str) -> bytes:
    """Write `robots.txt` of a site, whose address has no slash at its end.

    Source: RFC 9309.
    """
    disallowed = "".join(f"Disallow: {path}\n" for path in _NOT_INDEXED)
    return f"User-agent: *\n{disallowed}\nSitemap: {site}/sitemap.xml\n".encode()


def sitemap(site: str, files: Iterable[str]) -> bytes:
    """Write `sitemap.xml` with every page among the files of a site.

    Source: sitemaps.org, protocol 0.9.
    """
    folders = sorted({name.removesuffix("index.html") for name in files if is_page(name)})
    urls = "".join(
        f"  <url><loc>{escape(f'{site}/{folder}')}</loc></url>\n"
        for folder in folders
        if not f"/{folder}".endswith(_NOT_INDEXED)
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<urlset xmlns="http://www.sitemaps.org/schemas/sitemap/0.9">\n{urls}</urlset>\n'
    ).encode()


def is_page(name: str) -> bool:
    """True if a file of the site is a page."""
    return (name == "index.html" or name.endswith("/index.html")) and not name.startswith("vendor")


def security_text(contact: str, now: datetime, site: str | None = None) -> bytes:
    """Write `security.txt`, which every deployment renews.

    Source: RFC 9116, sections 2.5.3 and 2.5.5.
    """
    expires = now + timedelta(days=_SECURITY_TEXT_DAYS)
    lines = [f"Contact: {contact}", f"Expires: {expires:%Y-%m-%dT%H:%M:%SZ}"]
    if site:
        lines += ["Preferred-Languages: en, de, uk", f"Canonical: {site}/.well-known/security.txt"]
    return "".join(f"{line}\n" for line in lines).encode()
