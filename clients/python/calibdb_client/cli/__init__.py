"""The command `calibdb`."""

from .program import main

__all__ = ["main"]
