"""Shared code of all functions."""

#: version of the whole project, and its only place
__version__ = "0.1.0"
