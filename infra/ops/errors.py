"""The error that ends a command."""

from __future__ import annotations


class OpsError(ValueError):
    """A command cannot be executed; the message states the reason."""
