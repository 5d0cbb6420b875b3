"""Files at the root of the site that programs look for: robots.txt, config.json, the list of all files."""

import hashlib
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime, timedelta
from functools import lru_cache
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from infra.web_build.site import LANGUAGES, WEB, Options, made_files

_SECURITY_TEXT_DAYS = 364  # less than the year that the RFC recommends at most
#: answers to programs, and single results of people
_NOT_INDEXED = ("/v1/", "/known/", *(f"{folder}/result/" for folder in ("", *map("/{}".format, LANGUAGES))))
# Fetched when a page needs them, not with the first visit: 3 MB, or a rarely used script.
LAZY = re.compile(r"vendor(-[0-9a-f]+)?/(opencv/|font/geologica-cyrillic)")
SUFFIXES = (".html", ".js", ".css", ".svg", ".json", ".woff2", ".wasm")
# Sources of texts that pages contain, and what is for developers: of no use without a network, 3 MB.
EXCLUDED = re.compile(
    r"(messages|templates)/|((de|uk)/)?(examples|docs)/|sdk/(\d|integrity)|vendor(-[0-9a-f]+)?/(engines|minisearch)/"
)
# Not for pages, or another with every server.
EXCLUDED_FILES = {"openapi.json", "tsconfig.json", "config.json", "shell.json", "sw.js"}


def robots_text(site: str) -> bytes:
    """Write `robots.txt` (RFC 9309) of a site, whose address has no slash at its end."""
    disallowed = "".join(f"Disallow: {path}\n" for path in _NOT_INDEXED)
    return f"User-agent: *\n{disallowed}\nSitemap: {site}/sitemap.xml\n".encode()


def sitemap(site: str, files: Iterable[str]) -> bytes:
    """Write `sitemap.xml` (sitemaps.org, protocol 0.9) with every page among the files of a site."""
    folders = sorted({name.removesuffix("index.html") for name in files if _is_page(name)})
    urls = "".join(
        f"  <url><loc>{escape(f'{site}/{folder}')}</loc></url>\n"
        for folder in folders
        if not f"/{folder}".endswith(_NOT_INDEXED)
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<urlset xmlns="http://www.sitemaps.org/schemas/sitemap/0.9">\n{urls}</urlset>\n'
    ).encode()


def _is_page(name: str) -> bool:
    return (name == "index.html" or name.endswith("/index.html")) and not name.startswith("vendor")


def security_text(contact: str, now: datetime, site: str | None = None) -> bytes:
    """Write `security.txt` (RFC 9116, sections 2.5.3 and 2.5.5), which every deployment renews."""
    expires = now + timedelta(days=_SECURITY_TEXT_DAYS)
    lines = [f"Contact: {contact}", f"Expires: {expires:%Y-%m-%dT%H:%M:%SZ}"]
    if site:
        lines += ["Preferred-Languages: en, de, uk", f"Canonical: {site}/.well-known/security.txt"]
    return "".join(f"{line}\n" for line in lines).encode()


def root_file(key: str, web: Path, options: Options, settings: Mapping[str, Any]) -> bytes | None:
    """Make a file at the root of a site that is served from its sources; None if it has no such file."""
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


def public_settings(token: str, parameters: Mapping[str, str]) -> dict[str, Any]:
    """Content of `/config.json`; `parameters`: of the deployment."""
    settings: dict[str, Any] = {"api": "/v1", "token": token}
    contact = _operator(parameters)
    return settings | ({"operator": contact} if contact else {})


def _operator(parameters: Mapping[str, str]) -> dict[str, str]:
    names = {"name": "OperatorName", "contact": "OperatorContact", "imprint": "Imprint"}
    return {key: parameters[name] for key, name in names.items() if parameters.get(name)}


def contacts(parameters: Mapping[str, str]) -> dict[str, str]:
    """Return the addresses in every page's footer: `contact`, `imprint`."""
    operator = _operator(parameters)
    addresses = {"contact": operator.get("contact", ""), "imprint": operator.get("imprint", "")}
    if operator and not addresses["imprint"].startswith("https://"):
        addresses["imprint"] = "/privacy/#imprint"
    return {name: address for name, address in addresses.items() if address}


def shell(folder: Path = WEB, options: Options | None = None) -> dict[str, Any]:
    """Return the list of the pages' files: path → SHA-256, hexadecimal."""
    digests = {}
    for path in _files(folder):
        status = Path(path).stat()
        digests[path.removeprefix(f"{folder}/")] = _hash(path, status.st_mtime_ns, status.st_size)
    served = made_files(folder, options)
    made = {key: hashlib.sha256(content).hexdigest() for key, content in served.items()}
    return shell_of(dict(sorted((digests | made).items())))


def shell_of(digests: Mapping[str, str]) -> dict[str, Any]:
    """Select those among files, by path with their SHA-256, that belong to pages.

    `version` changes with any content, `late` are kept when they are used. The folder `vendor/` may have the
    hash in its name that an upload gives it.
    """
    files = {
        name: digest
        for name, digest in digests.items()
        if Path(name).suffix in SUFFIXES and name not in EXCLUDED_FILES and not EXCLUDED.match(name)
    }
    version = hashlib.sha256(json.dumps(files).encode()).hexdigest()[:16]
    return {"version": version, "files": files, "late": [name for name in files if LAZY.match(name)]}


def _files(folder: Path) -> Iterator[str]:
    """Paths as texts: they are walked for every visitor."""
    for place, _, names in os.walk(folder):
        yield from (f"{place}/{name}" for name in names if name.endswith(SUFFIXES))


@lru_cache(maxsize=1024)
def _hash(path: str, changed: int, size: int) -> str:  # noqa: ARG001 - the key of what is remembered
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()
