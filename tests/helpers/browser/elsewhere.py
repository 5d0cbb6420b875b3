"""Pages of another origin than the service's."""

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any


class Quiet(SimpleHTTPRequestHandler):
    """Files of a folder, with other settings of the client, if any."""

    def __init__(self, *request: Any, settings: dict[str, str] | None, directory: str):
        self._settings = settings
        super().__init__(*request, directory=directory)

    def log_message(self, *_: object) -> None:
        pass

    def do_GET(self) -> None:
        if self._settings is None or self.path.partition("?")[0] != "/config.json":
            return super().do_GET()
        content = json.dumps(self._settings).encode()
        self.send_response(200)
        self.send_header("content-type", "application/json")
        self.send_header("content-length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)
        return None


@contextmanager
def serving(folder: Path, settings: dict[str, str] | None = None) -> Iterator[str]:
    """Serve a folder in the block; yield its address."""
    handler = partial(Quiet, settings=settings, directory=str(folder))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}/"
        finally:
            server.shutdown()
            thread.join()
