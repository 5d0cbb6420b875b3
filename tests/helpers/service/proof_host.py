"""A host with a certificate of its own that answers over TLS what a test says, on the loopback interface."""

import datetime
import socket
import ssl
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

Talk = Callable[[ssl.SSLSocket], None]


@dataclass
class ProofHost:
    """The host: where it listens, who trusts it, and what it was asked."""

    port: int
    trusting: ssl.SSLContext
    asked: list[bytes] = field(default_factory=list)

    def connect(self, _: str, timeout_s: float) -> socket.socket:
        connection = _Elsewhere(socket.AF_INET, socket.SOCK_STREAM)
        connection.settimeout(timeout_s)
        connection.connect(("127.0.0.1", self.port))
        return connection


class _Elsewhere(socket.socket):
    def getpeername(self) -> tuple[str, int]:
        return ("93.184.216.34", 443)


@contextmanager
def proof_host(folder: Path, answer: bytes | Talk, name: str = "example.org") -> Iterator[ProofHost]:
    """Listen until the end of the block. `answer`: bytes, or what is to be done with a connection."""
    serving = _certified(folder, name)
    trusting = ssl.create_default_context(cafile=str(folder / "certificate.pem"))
    with socket.create_server(("127.0.0.1", 0)) as listener:
        host = ProofHost(listener.getsockname()[1], trusting)
        thread = threading.Thread(target=_serve, args=(listener, serving, answer, host), daemon=True)
        thread.start()
        yield host
        listener.shutdown(socket.SHUT_RDWR)
    thread.join(10)


def _serve(listener: socket.socket, serving: ssl.SSLContext, answer: bytes | Talk, host: ProofHost) -> None:
    while True:
        try:
            connection, _ = listener.accept()
        except OSError:
            return
        try:
            with connection, serving.wrap_socket(connection, server_side=True) as secured:
                host.asked.append(secured.recv(65536))
                if callable(answer):
                    answer(secured)
                else:
                    secured.sendall(answer)
        except OSError:
            continue  # whoever asked has gone


def _certified(folder: Path, name: str) -> ssl.SSLContext:
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    now = datetime.datetime.now(datetime.UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(hours=1))
        .not_valid_after(now + datetime.timedelta(hours=1))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName(name)]), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )
    (folder / "certificate.pem").write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
    (folder / "key.pem").write_bytes(
        key.private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        )
    )
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(folder / "certificate.pem", folder / "key.pem")
    return context
