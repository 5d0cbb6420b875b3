"""Proof of an origin: a file on it, fetched by one GET over HTTPS, within bounds of time and size.

The name is resolved once. Each of its addresses must be public, the connection goes to one of them, and the
peer's address is checked again, so that a name that resolves to something else a moment later changes
nothing. TLS verifies the name. No redirect is followed and no cookie is kept.
"""

import http.client
import io
import ipaddress
import socket
import ssl
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any, cast

from calibdb.schema.managed_token import ProofFailure
from calibdb.schema.origins import PROOF_PATH

MAX_FETCH_S = 3.0  # for name, connection, handshake and response
MAX_PROOF_BYTES = 1024
_MAX_ANSWER_BYTES = 16_384  # with its headers
_MAX_ADDRESSES = 2
_HTTPS_PORT = 443

# IANA IPv4 and IPv6 Special-Purpose Address Registries (RFC 6890). Python's `ipaddress` differs by version.
_SPECIAL_IPV4 = [
    ipaddress.IPv4Network(network)
    for network in (
        *("0.0.0.0/8", "10.0.0.0/8", "100.64.0.0/10", "127.0.0.0/8", "169.254.0.0/16", "172.16.0.0/12"),
        *("192.0.0.0/24", "192.0.2.0/24", "192.31.196.0/24", "192.52.193.0/24", "192.88.99.0/24"),
        *("192.168.0.0/16", "192.175.48.0/24", "198.18.0.0/15", "198.51.100.0/24", "203.0.113.0/24"),
        *("224.0.0.0/4", "240.0.0.0/4"),
    )
]
_GLOBAL_UNICAST = ipaddress.IPv6Network("2000::/3")
# Within it: protocol assignments with Teredo, benchmarking and ORCHID; documentation; 6to4, which holds an
# IPv4 address. IPv4-mapped addresses and NAT64 lie outside.
_SPECIAL_IPV6 = [
    ipaddress.IPv6Network(network)
    for network in ("2001::/23", "2001:db8::/32", "2002::/16", "2620:4f:8000::/48", "3fff::/20")
]

Resolve = Callable[[str], Sequence[str]]
Connect = Callable[[str, float], socket.socket]


class ProofError(Exception):
    """No proof could be read."""

    def __init__(self, reason: ProofFailure) -> None:
        super().__init__(reason)
        self.reason: ProofFailure = reason


def resolve(host: str) -> list[str]:
    """Addresses of a name, in the resolver's order."""
    addresses = socket.getaddrinfo(host, _HTTPS_PORT, type=socket.SOCK_STREAM)
    return list(dict.fromkeys(str(entry[4][0]) for entry in addresses))


def connect(address: str, timeout_s: float) -> socket.socket:
    """Connect to an address, never a name."""
    return socket.create_connection((address, _HTTPS_PORT), timeout=timeout_s)


def read_proof(
    host: str,
    *,
    context: ssl.SSLContext | None = None,
    resolve: Resolve = resolve,
    connect: Connect = connect,
    max_s: float = MAX_FETCH_S,
) -> str:
    """Text of `https://<host>/.well-known/calibdb.txt`; raises ProofError."""
    deadline = time.monotonic() + max_s
    addresses = _public_addresses(host, resolve, deadline - time.monotonic())
    connection = _connect_to_any(addresses, connect, deadline)
    trusted = context or ssl.create_default_context()
    try:
        with connection:
            if not is_public(str(connection.getpeername()[0])):
                raise ProofError("address")
            connection.settimeout(_seconds_left(deadline))
            # Applies to the handshake as a whole, however many bytes arrive one by one.
            with trusted.wrap_socket(connection, server_hostname=host) as secured:
                secured.settimeout(_seconds_left(deadline))
                secured.sendall(_request(host))
                return _text(_receive(secured, deadline))
    except TimeoutError as error:
        raise ProofError("timeout") from error
    except ssl.SSLError as error:
        raise ProofError("tls") from error
    except OSError as error:
        raise ProofError("connection") from error


def _public_addresses(host: str, resolve: Resolve, timeout_s: float) -> Sequence[str]:
    # The resolver has no time limit. A thread that is still waiting ends with the instance.
    worker = ThreadPoolExecutor(1)
    try:
        addresses = worker.submit(resolve, host).result(timeout_s)
    except FutureTimeoutError as error:
        raise ProofError("timeout") from error
    except (OSError, UnicodeError) as error:
        raise ProofError("name") from error
    finally:
        worker.shutdown(wait=False, cancel_futures=True)
    if not addresses:
        raise ProofError("name")
    if not all(map(is_public, addresses)):
        raise ProofError("address")
    return addresses


def is_public(text: str) -> bool:
    """True if `text` is an address of the public internet."""
    try:
        address = ipaddress.ip_address(text)
    except ValueError:
        return False
    if isinstance(address, ipaddress.IPv4Address):
        return not any(address in network for network in _SPECIAL_IPV4)
    return (
        address.scope_id is None
        and address in _GLOBAL_UNICAST
        and not any(address in network for network in _SPECIAL_IPV6)
    )


def _connect_to_any(addresses: Sequence[str], connect: Connect, deadline: float) -> socket.socket:
    # IPv4 first: functions outside of a VPC have no IPv6.
    tried = sorted(addresses, key=lambda address: ":" in address)[:_MAX_ADDRESSES]
    for left, address in zip(range(len(tried), 0, -1), tried, strict=True):
        try:
            return connect(address, _seconds_left(deadline) / left)
        except TimeoutError:
            failed: ProofFailure = "timeout"
        except OSError:
            failed = "connection"
    raise ProofError(failed)


def _seconds_left(deadline: float) -> float:
    left = deadline - time.monotonic()
    if left <= 0:
        raise ProofError("timeout")
    return left


def _request(host: str) -> bytes:
    lines = (
        f"GET {PROOF_PATH} HTTP/1.1",
        f"Host: {host}",
        "User-Agent: calibDB origin verification",
        "Accept: text/plain, */*",
        "Accept-Encoding: identity",
        "Connection: close",
    )
    return "\r\n".join((*lines, "", "")).encode("ascii")


def _receive(secured: ssl.SSLSocket, deadline: float) -> bytes:
    received = bytearray()
    while True:
        secured.settimeout(_seconds_left(deadline))
        try:
            part = secured.recv(4096)
        except ssl.SSLEOFError:
            part = b""
        if not part:
            return bytes(received)
        received += part
        if len(received) > _MAX_ANSWER_BYTES:
            raise ProofError("size")


class _ReceivedBytes:
    """Response in place of the socket of `http.client`."""

    def __init__(self, content: bytes) -> None:
        self._content = content

    def makefile(self, *_: Any, **__: Any) -> io.BytesIO:
        return io.BytesIO(self._content)


def _text(received: bytes) -> str:
    answer = http.client.HTTPResponse(cast("socket.socket", _ReceivedBytes(received)), method="GET")
    try:
        answer.begin()
        content = answer.read(MAX_PROOF_BYTES + 1)
    except (http.client.HTTPException, ValueError, OSError) as error:
        raise ProofError("answer") from error
    if 300 <= answer.status < 400:
        raise ProofError("redirect")
    if answer.status != 200:
        raise ProofError("status")
    if len(content) > MAX_PROOF_BYTES:
        raise ProofError("size")
    if answer.getheader("Content-Encoding", "identity").lower() != "identity":
        raise ProofError("answer")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ProofError("content") from error
