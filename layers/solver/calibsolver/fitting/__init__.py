"""Fitting: camera models and board poses estimated from views by bundle adjustment."""
