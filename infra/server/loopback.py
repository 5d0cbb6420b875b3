"""Allowed Host names of a private server (protection against DNS rebinding)."""

from __future__ import annotations

import re

ORIGINS = ("http://127.0.0.1:*", "http://localhost:*", "http://[::1]:*")
"""Origins of pages of this machine, at any port."""
_HOST = re.compile(
    r"(?:127(?:\.[0-9]{1,3}){3}|localhost|(?:[a-z0-9-]{1,63}\.)+localhost|\[::1\])(?::[0-9]{1,5})?"
)


def is_loopback(host: str) -> bool:
    """True if a Host header names this machine. A name that leads here by DNS rebinding does not."""
    return _HOST.fullmatch(host.strip().lower()) is not None
