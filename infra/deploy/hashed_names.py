"""Names of our own scripts and styles that change with their contents.

During an upload edges have files of two releases. A page names the files that it was made with, so it gets
all of them of one release. All names have one digest of all files, since modules import each other in
circles. The folder stays, so that addresses relative to a module mean the same.
"""

import posixpath
import re
from collections.abc import Mapping

# Also there under their plain names: what pages of other origins load, and the style of the edge's 404 page
_PUBLIC = re.compile(r"(sdk|webxr)/|style\.css$")
_AS_THEY_ARE = re.compile(r"vendor[^/]*/|sdk/\d|sw\.js$")
_NAMED = re.compile(
    rb"""(\bfrom\s*|\bimport\s*\(?\s*|\bnew URL\(\s*)(["'])(\.{1,2}/[^"'\s]+\.(?:js|css|json))\2"""
)
_IN_TAG = re.compile(rb"""(<(?:script|link)\b[^>]*?\s(?:src|href)=)(["'])([^"'\s]+\.(?:js|css))\2""")
_SUFFIXES = (".js", ".css")
_JSON_ADDRESS = re.compile(rb"""new URL\(\s*["']([^"'\s]+\.json)["']\s*,\s*import\.meta\.url""")
_NOT_OURS = {"config.json", "openapi.json"}  # another with each deployment, or a public address


def rename(files: Mapping[str, bytes], digest: str) -> dict[str, bytes]:
    """Give scripts and styles their names with `digest`, that of `hashed(files)`, wherever they are named."""
    own = hashed(files)
    names = {key: _name(key, digest) for key in own}
    result = {}
    for key, content in files.items():
        if key in own:
            result[names[key]] = _refer(key, content, names)
        if key not in own or _PUBLIC.match(key):
            result[key] = _refer(key, content, names) if key.endswith(".html") else content
    return result


def hashed(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Select the scripts and styles of our pages, and the JSON files that a script names next to itself."""
    own = {
        key: content
        for key, content in files.items()
        if key.endswith(_SUFFIXES) and not _AS_THEY_ARE.match(key)
    }
    for key, content in list(own.items()):
        for match in _JSON_ADDRESS.finditer(content):
            there = _resolve(key, match[1].decode())
            if there in files and there not in _NOT_OURS:
                own[there] = files[there]
    return own


def _refer(key: str, content: bytes, names: Mapping[str, str]) -> bytes:
    def renamed(match: re.Match[bytes]) -> bytes:
        written = match[3].decode()
        there = _resolve(key, written)
        if there not in names:
            return match[0]
        address = posixpath.join(posixpath.dirname(written), posixpath.basename(names[there]))
        if written.startswith("./"):
            address = f"./{address.removeprefix('./')}"
        return match[1] + match[2] + address.encode() + match[2]

    # Code that people read in a page or a string is as they will write it.
    return (_IN_TAG if key.endswith(".html") else _NAMED).sub(renamed, content)


def _resolve(key: str, written: str) -> str:
    return posixpath.normpath(posixpath.join("/", posixpath.dirname(key), written)).lstrip("/")


def _name(key: str, digest: str) -> str:
    """Put the digest before the suffixes: CloudFront gives `*.worker.js` headers of its own."""
    folder, file = posixpath.split(key)
    stem, dot, suffixes = file.partition(".")
    return posixpath.join(folder, f"{stem}-{digest}{dot}{suffixes}")
