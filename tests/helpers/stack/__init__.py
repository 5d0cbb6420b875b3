"""Helpers around the local stack: processes, faults, a toy deployment."""
