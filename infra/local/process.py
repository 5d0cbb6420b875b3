"""The local stack as a process that a signal stops."""

from __future__ import annotations

import gc
import logging
import os
import signal
import sys
from pathlib import Path

from infra.local.intrinsics import TemplateError
from infra.local.journal import JournalError
from infra.local.secrets import SecretsError
from infra.local.server import PortInUseError
from infra.local.stack import DEVELOPMENT_TOKEN, LocalStack

_STOPPING = {signal.SIGINT, signal.SIGTERM}


def main() -> int:
    """Run the stack; return the exit status."""
    logging.basicConfig(format="%(asctime)s %(message)s", datefmt="%H:%M:%S")
    logging.getLogger("infra").setLevel(logging.INFO)
    # Blocked before there is another thread, which would inherit it otherwise: a signal that the kernel gives
    # to another thread does not wake a main thread that waits in Python, and its handler would never run.
    signal.pthread_sigmask(signal.SIG_BLOCK, _STOPPING)
    try:
        port = _port(os.environ.get("PORT") or "8000")
        stack = LocalStack(
            Path(os.environ.get("DATA_DIR") or ".data"),
            port=port,
            new_secrets=bool(os.environ.get("NEW_SECRETS")),
        )
        with stack:
            for sentence in stack.damage:
                print(f"warning: {sentence}", file=sys.stderr, flush=True)
            stack.warm()
            # What is there by now mostly stays; the collector need not walk it in the middle of requests.
            gc.freeze()
            gc.enable()
            with stack.serve() as url:
                print(f"calibDB is at {url}/")
                print(f"API token, for this machine only: {DEVELOPMENT_TOKEN}", flush=True)
                signal.sigwait(_STOPPING)
                _end_at_once_when_asked_again()
                print("stopping: requests and computations under way are finished", flush=True)
    except (JournalError, PortInUseError, SecretsError, TemplateError, ValueError) as error:
        print(f"calibDB cannot start: {error}", file=sys.stderr)
        return 1
    return 0


def _end_at_once_when_asked_again() -> None:
    for number in _STOPPING:
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _STOPPING)


def _port(text: str) -> int:
    if not text.isdecimal():
        raise ValueError(f"PORT is a number, not {text!r}")
    return int(text)
