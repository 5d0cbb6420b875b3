"""Estimate of a field of view by all evidence about a camera without reliable calibration."""
