"""Origins of pages: which of them any user may name, and which need a proof.

Source: RFC 6454, 6.2 (serialization of an origin); WHATWG URL, "host parsing": a name whose last label is a
number is an IPv4 address; RFC 6761 and W3C Secure Contexts, 3.1: `localhost` is the device itself.
"""

import ipaddress
import re

MAX_ORIGIN_LENGTH = 270  # characters: https:// and a domain name
_MAX_NAME_LENGTH = 253
_LABEL = r"[a-z0-9](?:[a-z0-9-]{0,61}[a-z0-9])?"
_DOMAIN = re.compile(rf"https://((?:{_LABEL}\.)+[a-z](?:[a-z0-9-]{{0,61}}[a-z0-9])?)", re.ASCII)
_LOOPBACK = re.compile(
    rf"(https?)://((?:{_LABEL}\.)*localhost|[0-9]{{1,3}}(?:\.[0-9]{{1,3}}){{3}}|\[::1\])(?::([1-9][0-9]{{0,4}}))?",
    re.ASCII,
)
_DEFAULT_PORTS = {"http": 80, "https": 443}
_MAX_PORT = 65_535
# Names that are not public (RFC 6761, 6762, 7686, 8375; ICANN resolution 2024.07.29.06).
_PRIVATE_SUFFIXES = (".local", ".internal", ".home.arpa", ".onion", ".arpa", ".localhost")

ORIGIN_PATTERN = (
    r"^(http://(localhost|127\.0\.0\.1|\[::1\])(:[1-9][0-9]{3})?"
    r"|https://([a-z0-9]([a-z0-9-]{0,30}[a-z0-9])?\.){1,4}[a-z]([a-z0-9-]{0,30}[a-z0-9])?)$"
)
"""Plain origins, for documents. `requirement` decides."""

PROOF_PATH = "/.well-known/calibdb.txt"


def is_loopback(origin: str) -> bool:
    """True if pages of `origin` are on the visitor's own machine."""
    match = _LOOPBACK.fullmatch(origin[: MAX_ORIGIN_LENGTH + 1])
    if match is None:
        return False
    host, port = match[2], match[3]
    if port is not None and (int(port) > _MAX_PORT or int(port) == _DEFAULT_PORTS[match[1]]):
        return False  # no browser writes it so
    if host[0].isdigit():
        try:
            return ipaddress.IPv4Address(host).is_loopback
        except ValueError:
            return False
    return True


def proof_host(origin: str) -> str | None:
    """Public domain name of an HTTPS origin without port, which can be proved; None of others."""
    match = _DOMAIN.fullmatch(origin[: MAX_ORIGIN_LENGTH + 1])
    if match is None or len(match[1]) > _MAX_NAME_LENGTH or f".{match[1]}".endswith(_PRIVATE_SUFFIXES):
        return None
    return match[1]


def requirement(origin: str) -> str | None:
    """Requirement that an origin does not meet; None if a token may have it."""
    if is_loopback(origin) or proof_host(origin) is not None:
        return None
    if origin != origin.lower():
        return "must be written in lower case, as a browser writes it"
    if origin.endswith("/"):
        return "must end with the host, without a slash or a path"
    return (
        "must be https:// and a public domain name without port, as https://example.org, "
        "or an origin of this machine, as http://localhost"
    )


def portless(origin: str) -> str:
    """Origin without its port, if the port is as a browser writes it."""
    host, colon, port = origin.rpartition(":")
    is_port = colon and port.isascii() and port.isdigit() and len(port) <= len(str(_MAX_PORT))
    return host if is_port and 1 <= int(port) <= _MAX_PORT and port[0] != "0" else origin


def proof_url(origin: str) -> str:
    """Address of the proof of `origin`."""
    return origin + PROOF_PATH


def proof_content(token_id: str) -> str:
    """Line that the proof must contain."""
    return f"calibdb-site-verification={token_id}"
