"""One request, again and again over keep-alive sockets, from a process of its own."""

import json
import select
import socket
import subprocess
import sys
import time
from collections.abc import Mapping

from tests.bench.load import ROOT, Load


def drive(
    url: str, method: str, path: str, headers: Mapping[str, str], body: str, *, requests: int, clients: int
) -> Load:
    """Send the request as fast as answers come; every answer must be a 200."""
    address = url.removeprefix("http://")
    head = {"host": address, "content-length": str(len(body.encode())), **headers}
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in head.items())]
    asked = {"message": "\r\n".join([*lines, "", body]), "address": address}
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.raw_load", json.dumps(asked), str(requests), str(clients)],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f"{method} {path}: {done.stderr}")
    return Load(**json.loads(done.stdout))


def main(asked: Mapping[str, str], requests: int, clients: int) -> None:
    host, _, port = asked["address"].partition(":")
    message = asked["message"].encode()
    poll = select.epoll()
    connections = {}
    for _ in range(clients):
        connection = socket.create_connection((host, int(port)))
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        poll.register(connection, select.EPOLLIN)
        connections[connection.fileno()] = connection
    sent, received, latencies = {}, dict.fromkeys(connections, b""), []
    start = time.perf_counter()
    for number, connection in connections.items():
        sent[number] = time.perf_counter()
        connection.sendall(message)
    left = requests - clients
    length = 0
    while len(latencies) < requests:
        for number, _ in poll.poll():
            connection = connections[number]
            answer = received[number] + connection.recv(65536)
            if not answer.startswith(b"HTTP/1.1 200"):
                raise SystemExit(answer[:500].decode("latin-1") or "the connection was closed")
            if not length and b"\r\n\r\n" in answer:
                head, _, _ = answer.partition(b"\r\n\r\n")
                length = len(head) + 4 + int(head.lower().partition(b"content-length: ")[2].split()[0])
            if not length or len(answer) < length:
                received[number] = answer
                continue
            if len(answer) != length:
                raise SystemExit(answer[:500].decode("latin-1"))
            now = time.perf_counter()
            latencies.append((now - sent[number]) * 1e3)
            received[number] = b""
            if left > 0:
                left -= 1
                sent[number] = now
                connection.sendall(message)
    elapsed = time.perf_counter() - start
    print(json.dumps({"each": elapsed * 1e3 / requests, "latencies": sorted(latencies)}))


if __name__ == "__main__":
    main(json.loads(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
