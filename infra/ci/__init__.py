"""Continuous integration: vulnerability audit, browsers, and another implementation of AWS."""
