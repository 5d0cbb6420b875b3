"""Files at the root of the site that programs look for, such as robots.txt and config.json."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from infra.web_build.precache_manifest import shell
from infra.web_build.site import LANGUAGES, Options, made_files

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


def root_file(key: str, web: Path, options: Options, settings: Mapping[str, Any]) -> bytes | None:
    """Make a file of a site that is served from its sources; None if it has no such file at its root."""
    contact = settings.get("operator", {}).get("contact", "")
    match key:
        case "config.json":
            return json.dumps(settings).encode()
        case "shell.json":
            return json.dumps(shell(web, options)).encode()
        case "robots.txt":
            return robots_text(options.origin)
        case "sitemap.xml":
            return sitemap(options.origin, made_files(web, options))
        case ".well-known/security.txt" if contact:
            return security_text(contact, datetime.now(UTC), options.origin)
    return None


def public_settings(api: str, token: str, parameters: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Content of `/config.json`, which a deployment writes; `parameters`: of the deployment."""
    settings: dict[str, Any] = {"api": api, "token": token}
    contact = operator(parameters or {})
    return settings | ({"operator": contact} if contact else {})


def operator(parameters: Mapping[str, str]) -> dict[str, str]:
    """Name the operator of the service as far as the deployment does: `name`, `contact`, `imprint`."""
    names = {"name": "OperatorName", "contact": "OperatorContact", "imprint": "Imprint"}
    return {key: parameters[name] for key, name in names.items() if parameters.get(name)}


def contacts(parameters: Mapping[str, str]) -> dict[str, str]:
    """Return the addresses that every page's footer names: `contact`, `imprint`."""
    contact = operator(parameters)
    imprint = contact.get("imprint", "")
    addresses = {"contact": contact.get("contact", "")}
    addresses["imprint"] = (
        imprint if imprint.startswith("https://") else "/privacy/#imprint" if contact else ""
    )
    return {name: address for name, address in addresses.items() if address}
