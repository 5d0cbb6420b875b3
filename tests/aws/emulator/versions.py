"""The versions of objects, of which local buckets keep the newest only.

moto would copy the whole bucket for each listing; and what it copies it does not close.
"""

from __future__ import annotations

from collections.abc import Iterable
from urllib.parse import parse_qs, quote, urlsplit

_VERSION_XML = "<Version><Key>{}</Key><VersionId>null</VersionId><IsLatest>true</IsLatest></Version>"
_LISTING = (
    '<?xml version="1.0" encoding="UTF-8"?><ListVersionsResult><EncodingType>url</EncodingType>'
    "<IsTruncated>false</IsTruncated>{}</ListVersionsResult>"
)


def prefix_of(url: str) -> str:
    """Return the prefix that a ListObjectVersions asks for."""
    return parse_qs(urlsplit(url).query).get("prefix", [""])[0]


def listing(names: Iterable[str]) -> bytes:
    """Return the answer to a ListObjectVersions: one version of each, in one page."""
    return _LISTING.format("".join(_VERSION_XML.format(quote(name)) for name in sorted(names))).encode()
