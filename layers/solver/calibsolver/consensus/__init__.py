"""Consensus of calibrations of one camera: agreement between them, and their pooled fit."""
