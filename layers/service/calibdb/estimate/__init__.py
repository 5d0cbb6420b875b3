"""Estimate of a field of view: evidence about a camera that nothing reliable is known of, combined.

Pure Python, and read only when a lookup misses. `docs/estimates.md` measures how often the intervals hold.
"""
