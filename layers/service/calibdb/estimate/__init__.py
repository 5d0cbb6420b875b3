"""Estimate of a field of view by all evidence about a camera without reliable calibration.

Pure Python, and read only when a lookup misses. `docs/estimates.md` measures how often the intervals hold.
"""
