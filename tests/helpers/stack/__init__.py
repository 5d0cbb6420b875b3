"""Helpers around a server of its own process."""
