"""Fetching a proof: nothing but public HTTPS addresses is ever connected to, for no longer than 3 s."""

import socket
import ssl
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from calibdb.proof import MAX_PROOF_BYTES, ProofError, is_public, read_proof
from calibdb.schema.origins import is_loopback, proof_host, requirement
from tests.helpers.service import proof_host as hosts

PUBLIC = "93.184.216.34"

INNER_ADDRESSES = [
    "127.0.0.1", "0.0.0.0", "10.0.0.1", "172.31.255.255", "192.168.1.1", "169.254.169.254", "100.64.0.1",
    "192.0.0.192", "192.0.2.1", "198.18.0.1", "198.51.100.7", "203.0.113.9", "239.255.255.250", "240.0.0.1",
    "::1", "::127.0.0.1", "::ffff:169.254.169.254", "64:ff9b::10.0.0.1", "fe80::1%eth0", "fc00::1", "ff02::1",
    "2002:a00:1::1", "2001:0:4136:e378:8000:63bf:3fff:fdd2", "2001:db8::1", "3fff::1", "2600::1%1",
    "2001:20::1", "localhost", "", "1.2.3", "0x7f.0.0.1", "017700000001",
]  # fmt: skip

EVASIVE_ORIGINS = [
    "file:///etc/passwd", "//example.org", "https://127.0.0.1", "https://0x7f.1", "https://169.254.169.254",
    "https://[::1]", "https://①②⑦.0.0.1", "https://example.org:443", "https://user:pass@example.org",
    "https://example.org#@10.0.0.1", "https://example.org/", "https://example.org\\@10.0.0.1",
    "https://example.org\r\nHost: 10.0.0.1", "https://example.org ", "https://example.org.", "https://example",
    "https://metadata.google.internal", "https://x.onion", "https://1.0.0.127.in-addr.arpa",
    "https://printer.local",
    "https://a.localhost", f"https://{'a' * 64}.org", f"https://{'a.' * 130}org", "https://ex\u0430mple.org",
    "https://example.org\u3002internal", "https://example.0x7f",
]  # fmt: skip


def never(address: str, _: float) -> socket.socket:
    raise AssertionError(address)


@pytest.mark.parametrize("address", INNER_ADDRESSES)
def test_name_with_an_inner_address_is_not_connected_to(address: str) -> None:
    assert not is_public(address)
    for resolved in ([address], [PUBLIC, address], [address, PUBLIC]):
        with pytest.raises(ProofError, match="address"):
            read_proof("example.org", resolve=lambda _, found=resolved: found, connect=never)


@pytest.mark.parametrize("origin", EVASIVE_ORIGINS)
def test_origin_without_a_public_name_at_the_https_port_has_no_proof(origin: str) -> None:
    assert proof_host(origin) is None
    assert requirement(origin) is not None or is_loopback(origin)


@pytest.mark.parametrize("address", [PUBLIC, "8.8.8.8", "2600:1f18::1", "2a00:1450:4001::200e"])
def test_public_address_is_connected_to_by_its_address(address: str) -> None:
    with pytest.raises(AssertionError, match=address):
        read_proof("example.org", resolve=lambda _: [address], connect=never)


def test_peer_that_is_not_public_gets_no_byte() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def inwards(_: str, timeout_s: float) -> socket.socket:
            return socket.create_connection(listener.getsockname(), timeout_s)

        with pytest.raises(ProofError, match="address"):
            read_proof("example.org", resolve=lambda _: [PUBLIC], connect=inwards)
        accepted, _ = listener.accept()
        with accepted:
            assert accepted.recv(1) == b""  # closed, and nothing was sent


def test_name_that_resolves_to_something_else_the_second_time_is_resolved_once() -> None:
    answers = iter([[PUBLIC], ["127.0.0.1"]])
    met = []

    def connect(address: str, _: float) -> socket.socket:
        met.append(address)
        raise ConnectionRefusedError

    with pytest.raises(ProofError, match="connection"):
        read_proof("example.org", resolve=lambda _: next(answers), connect=connect)
    assert met == [PUBLIC]
    assert next(answers) == ["127.0.0.1"]


@pytest.mark.parametrize("error", [socket.gaierror("no name"), UnicodeError("label too long")])
def test_unknown_name_is_said(error: Exception) -> None:
    def fail(_: str) -> list[str]:
        raise error

    with pytest.raises(ProofError, match="name"):
        read_proof("example.org", resolve=fail, connect=never)


def fetch(host: hosts.ProofHost, name: str = "example.org", **named: Any) -> str:
    return read_proof(name, context=host.trusting, resolve=lambda _: [PUBLIC], connect=host.connect, **named)


def http(status: str, body: bytes = b"", *headers: str) -> bytes:
    return "\r\n".join((f"HTTP/1.1 {status}", *headers, "", "")).encode() + body


def test_proof_is_read_without_cookies_or_credentials(tmp_path: Path) -> None:
    with hosts.proof_host(tmp_path, http("200 OK", b"a\nb\n", "Set-Cookie: a=b")) as host:
        for _ in range(2):
            assert fetch(host) == "a\nb\n"
    for asked in host.asked:
        lines = asked.decode().split("\r\n")
        assert lines[0] == "GET /.well-known/calibdb.txt HTTP/1.1"
        assert "Host: example.org" in lines
        assert not [one for one in lines if one.lower().startswith(("cookie", "authorization", "referer"))]


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        *((http(f"{n} X", b"x", "Location: http://10.0.0.1/"), "redirect") for n in (301, 308)),
        (http("404 X", b"x"), "status"),
        (http("204 X"), "status"),
        (http("200 OK", b"x" * (MAX_PROOF_BYTES + 1)), "size"),
        (http("200 OK", b"x", "X: " + "y" * 70_000), "size"),
        (http("200 OK", b"x", "Content-Encoding: gzip"), "answer"),
        (http("200 OK", b"\xff\xfe\xfd"), "content"),
        (b"SSH-2.0-OpenSSH_9.0\r\n", "answer"),
        (b"", "answer"),
        (http("200 OK", b"zz\r\n", "Transfer-Encoding: chunked"), "answer"),
    ],
    ids=lambda value: value if isinstance(value, str) else value[:30].decode("latin-1"),
)  # fmt: skip
def test_answer_that_is_no_proof_is_refused(tmp_path: Path, answer: bytes, reason: str) -> None:
    with hosts.proof_host(tmp_path, answer) as host, pytest.raises(ProofError, match=f"^{reason}$"):
        fetch(host)
    assert len(host.asked) == 1  # nothing was followed


def test_certificate_of_another_name_is_refused(tmp_path: Path) -> None:
    with hosts.proof_host(tmp_path, http("200 OK"), "example.com") as host:
        with pytest.raises(ProofError, match="tls"):
            fetch(host)
        with pytest.raises(ProofError, match="tls"):
            read_proof("example.com", resolve=lambda _: [PUBLIC], connect=host.connect)  # that nobody signed
    assert host.asked == []


MAX_S = 0.2  # of these fetches, s


@contextmanager
def timed_out() -> Iterator[None]:
    begun = time.monotonic()
    with pytest.raises(ProofError, match="timeout"):
        yield
    assert time.monotonic() - begun < 10 * MAX_S


def test_answer_that_drips_ends_in_time(tmp_path: Path) -> None:
    stop = threading.Event()

    def drip(secured: ssl.SSLSocket) -> None:
        secured.sendall(b"HTTP/1.1 200 OK\r\n")
        while not stop.wait(0.01):
            secured.sendall(b"X: y\r\n")

    with hosts.proof_host(tmp_path, drip) as host:
        with timed_out():
            fetch(host, max_s=MAX_S)
        stop.set()


def test_handshake_that_drips_ends_in_time() -> None:
    def drip(listener: socket.socket) -> None:
        with suppress(OSError), listener.accept()[0] as connection:
            for byte in b"\x16\x03\x03\x40\x00\x02\x00\x3f\xfc" + bytes(1000):  # a long record
                connection.send(bytes([byte]))
                time.sleep(0.01)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        threading.Thread(target=drip, args=(listener,), daemon=True).start()
        slow = hosts.ProofHost(listener.getsockname()[1], ssl.create_default_context())
        with timed_out():
            fetch(slow, max_s=MAX_S)


def test_resolver_that_hangs_ends_in_time() -> None:
    release = threading.Event()

    def hang(_: str) -> list[str]:
        release.wait(10)
        return [PUBLIC]

    with timed_out():
        read_proof("example.org", resolve=hang, connect=never, max_s=MAX_S)
    release.set()
