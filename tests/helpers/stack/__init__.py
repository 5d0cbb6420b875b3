"""Helpers around a server: processes, and an emulated gateway."""
